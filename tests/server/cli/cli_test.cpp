// SPDX-License-Identifier: Apache-2.0
// `livegs` as a whole program: what it writes, and what it says of bad input.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "core/file.h"
#include "gaussian/asset_file.h"
#include "scratch_folder.h"
#include "splat/image.h"
#include "system/program.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

struct Said {
  int code;
  std::string out, err;
};
Said run(std::vector<std::string> words) {
  words.insert(words.begin(), LIVEGS_TOOL);
  Program program(words);
  const int code = program.wait();
  return {code, program.out(), program.err()};
}

std::vector<std::string> lines_of(const fs::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

constexpr const char* kScene = R"({
  "rate_hz": 60,
  "environment": { "colliders": [ { "plane": {} } ] },
  "objects": [
    { "name": "soft", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [-0.3, 0.2, 0] },
      "physics": { "behavior": "ELASTIC", "density_kg_m3": 300, "youngs_modulus_pa": 2e4 } },
    { "name": "hard", "shape": { "sphere": { "radius_m": 0.1 } }, "pose": { "position_m": [0.3, 0.3, 0] },
      "physics": { "behavior": "RIGID", "mass_kg": 1 } } ] })";

TEST(Cli, SimulateWritesEveryFileItPromises) {
  ScratchFolder folder;
  const Said said =
      run({"simulate", folder.write("two.scene.json", kScene), "--seconds", "0.5", "--output", folder / "out",
           "--particles", "--kernels", "--pictures", "--every", "15", "--quiet"});
  ASSERT_EQ(said.code, 0) << said.err;
  const fs::path out = folder / "out";
  // Frame 0 is the start; 30 steps follow; two bodies a frame.
  const auto bodies = lines_of(out / "bodies.csv");
  EXPECT_EQ(bodies[0], "frame,time_s,object,body,px,py,pz,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz,mass_kg,asleep");
  EXPECT_EQ(bodies.size(), 1u + 31u * 2u);
  EXPECT_EQ(bodies[1].rfind("0,0,soft,0,-0.3,0.2,", 0), 0u) << bodies[1];
  EXPECT_NE(bodies[1].find(",2.4,0"), std::string::npos) << bodies[1];  // 300 kg/m3 times 8 litres, awake
  EXPECT_EQ(lines_of(out / "energy.csv").size(), 32u);
  EXPECT_EQ(lines_of(out / "energy.csv")[0], "frame,time_s,kinetic_j,elastic_j,gravity_j,px,py,pz,lx,ly,lz");
  EXPECT_EQ(lines_of(out / "particles.csv")[0],
            "frame,time_s,object,particle_id,x,y,z,vx,vy,vz,mass_kg,F00,F01,F02,F10,F11,F12,F20,F21,F22");
  EXPECT_EQ(
      lines_of(out / "kernels.csv")[0],
      "frame,time_s,object,kernel_id,x,y,z,sxx,sxy,sxz,syy,syz,szz,F00,F01,F02,F10,F11,F12,F20,F21,F22");
  EXPECT_TRUE(fs::exists(out / "events.csv"));
  EXPECT_NE(read_text_file(out / "summary.json").value().find("\"ns_per_node_substep\""), std::string::npos);
  for (const char* picture : {"frame_0000.png", "frame_0015.png", "frame_0030.png"}) {
    EXPECT_TRUE(read_png(out / picture)) << picture;
  }
}

TEST(Cli, SimulatingTwiceWritesTheSameBytesForAnyThreadCount) {
  ScratchFolder folder;
  const std::string scene = folder.write("two.scene.json", kScene);
  for (const char* threads : {"1", "2", "3"}) {
    ASSERT_EQ(run({"simulate", scene, "--seconds", "0.7", "--output", folder / threads, "--particles",
                   "--quiet", "--threads", threads})
                  .code,
              0);
  }
  for (const char* file : {"bodies.csv", "particles.csv", "energy.csv", "events.csv"}) {
    const std::string one = read_text_file(folder.path() / "1" / file).value();
    EXPECT_EQ(one, read_text_file(folder.path() / "2" / file).value()) << file;
    EXPECT_EQ(one, read_text_file(folder.path() / "3" / file).value()) << file;
  }
}

TEST(Cli, BothSolversAndSkinningsRun) {
  ScratchFolder folder;
  const std::string scene = folder.write("two.scene.json", kScene);
  for (const char* solver : {"cells", "livegs-v1"}) {
    for (const char* skinning : {"lattice", "livegs-v1"}) {
      const Said said = run({"simulate", scene, "--seconds", "0.2", "--output", folder / "out", "--kernels",
                             "--quiet", "--elastic-solver", solver, "--skinning", skinning});
      EXPECT_EQ(said.code, 0) << solver << " " << skinning << ": " << said.err;
    }
  }
}

TEST(Cli, InfoConvertRenderMeshAndAnalyzeAnAsset) {
  ScratchFolder folder;
  ASSERT_EQ(run({"sample", folder / "scene", "--quiet"}).code, 0);
  const std::string cup = folder.path() / "scene" / "cup.ply";
  const Said info = run({"info", cup});
  EXPECT_EQ(info.code, 0);
  EXPECT_NE(info.out.find("SH degree"), std::string::npos);
  EXPECT_EQ(run({"convert", cup, folder / "cup.spz"}).code, 0);
  const auto first = read_asset(cup), second = read_asset(folder / "cup.spz");
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->asset.size(), second->asset.size());
  EXPECT_EQ(run({"render", cup, "-o", folder / "cup.png", "--width", "160", "--height", "120"}).code, 0);
  const auto picture = read_png(folder / "cup.png");
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->width, 160);
  EXPECT_EQ(run({"mesh", cup, "--output", folder / "cup.obj"}).code, 0);
  EXPECT_GT(lines_of(folder / "cup.obj").size(), 1000u);
  const Said analysis = run({"analyze", cup, "--json"});
  EXPECT_EQ(analysis.code, 0);
  EXPECT_NE(analysis.out.find("\"mass_kg\""), std::string::npos);
  EXPECT_NE(analysis.out.find("stoneware"), std::string::npos);
}

// One line that names the thing; exit code 2 for what the user can mend.
TEST(Cli, BadInputIsOneLine) {
  ScratchFolder folder;
  folder.write("broken.ply", "ply\nformat binary_little_endian 1.0\nelement vertex 5\n");
  folder.write("bad.scene.json", R"({ "objects": [ { "nam": "x" } ] })");
  const std::pair<std::vector<std::string>, const char*> cases[] = {
      {{"info", folder / "absent.ply"}, "absent.ply"},
      {{"info", folder / "broken.ply"}, "broken.ply"},
      {{"info", folder / "bad.scene.json"}, "nam"},
      {{"info", folder.write("lost.scene.json", R"({ "environment": { "asset": "lost.ply" } })")}, "lost.ply"},
      {{"simulate", folder.write("ok.scene.json", kScene), "-o", folder / "o", "--seconds", "nan"}, "--seconds"},
      {{"convert", folder / "absent.spz", folder / "x.ply"}, "absent.spz"},
      {{"render", folder / "absent.ply"}, "absent.ply"},
      {{"simulate", folder / "absent.scene.json", "-o", folder / "o"}, "absent.scene.json"},
      {{"simulate", folder / "bad.scene.json", "-o", folder / "o"}, "nam"},
      {{"analyze", folder / "broken.ply"}, "broken.ply"},
      {{"mesh", folder / "broken.ply"}, "broken.ply"},
  };
  for (const auto& [words, named] : cases) {
    const Said said = run(words);
    EXPECT_EQ(said.code, 2) << words[0] << " " << words[1];
    EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1) << said.err;
    EXPECT_NE(said.err.find(named), std::string::npos) << said.err;
    if (words[1].find("lost.scene.json") == std::string::npos) EXPECT_EQ(said.out, "");  // what could be read is told
  }
  EXPECT_EQ(run({"simulate"}).code, 2);
  EXPECT_EQ(run({"dance"}).code, 2);
  EXPECT_EQ(run({"--help"}).code, 0);
  // A folder that cannot be made is not the scene's fault.
  const std::string scene = folder.write("two.scene.json", kScene);
  EXPECT_EQ(run({"simulate", scene, "-o", "/proc/nowhere", "--quiet"}).code, 1);
}

// Every malformed fixture: refused in one line, never a crash.
TEST(Cli, MalformedFixturesAreRefusedInOneLine) {
  const fs::path fixtures = fs::path(LIVEGS_SHARED_DATA_DIR) / "fixtures";
  if (!fs::exists(fixtures)) GTEST_SKIP() << "shared data is not here";
  int refused = 0;
  for (const auto& entry : fs::recursive_directory_iterator(fixtures)) {
    if (!entry.is_regular_file() || entry.path().extension() == ".webp") continue;
    const Said said = run({"info", entry.path()});
    if (said.code == 0) continue;
    ++refused;
    EXPECT_EQ(said.code, 2) << entry.path();
    EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1) << said.err;
    EXPECT_NE(
        said.err.find(entry.path().filename() == "meta.json" ? entry.path().parent_path().filename().string()
                                                             : entry.path().filename().string()),
        std::string::npos)
        << said.err;
  }
  EXPECT_GE(refused, 40);
}

}  // namespace
}  // namespace livegs
