// SPDX-License-Identifier: Apache-2.0
// `livegs export gltf`, `usd` and `--format` as programs.
#include <gtest/gtest.h>

#include <filesystem>

#include "export/gltf_scene.h"
#include "export/usda_scene.h"
#include "scratch_folder.h"
#include "system/support/program.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

struct Printed {
  int code;
  std::string out, err;
};
Printed run_tool(std::vector<std::string> words) {
  words.insert(words.begin(), LIVEGS_TOOL);
  Program program(words);
  const int code = program.wait();
  return {code, program.out(), program.err()};
}

const std::string kJoints = std::string(LIVEGS_TESTS_DIR) + "/scenes/joints.scene.json";

TEST(ExportCommand, WritesAndListsEveryFile) {
  ScratchFolder folder;
  const Printed glb = run_tool({"export", "gltf", kJoints, folder / "a.glb"});
  ASSERT_EQ(glb.code, 0) << glb.err;
  EXPECT_NE(glb.out.find((folder / "a.glb").string()), std::string::npos) << glb.out;
  EXPECT_NE(glb.out.find("joints: 6"), std::string::npos) << glb.out;
  const Printed gltf = run_tool({"export", kJoints, folder / "out", "--format", "gltf"});
  ASSERT_EQ(gltf.code, 0) << gltf.err;
  for (const char* name : {"joints.gltf", "joints.bin"}) {
    EXPECT_TRUE(fs::exists(folder / "out" / name)) << name;
    EXPECT_NE(gltf.out.find((folder / "out" / name).string()), std::string::npos) << gltf.out;
  }
  const Printed usd = run_tool({"export", "usd", kJoints, folder / "out"});
  ASSERT_EQ(usd.code, 0) << usd.err;
  EXPECT_TRUE(fs::exists(folder / "out" / "joints.usda"));
  const auto a = read_gltf_scene(folder / "a.glb"), b = read_gltf_scene(folder / "out" / "joints.gltf");
  const auto c = read_usda_scene(folder / "out" / "joints.usda");
  ASSERT_TRUE(a && b && c);
  EXPECT_EQ(a->bodies.size(), b->bodies.size());
  EXPECT_EQ(a->joints.size(), c->joints.size());
}

TEST(ExportCommand, EqualScenesGiveEqualBytes) {
  ScratchFolder folder;
  ASSERT_EQ(run_tool({"export", "gltf", kJoints, folder / "a.glb"}).code, 0);
  ASSERT_EQ(run_tool({"export", "gltf", kJoints, folder / "b.glb"}).code, 0);
  std::ifstream a(folder / "a.glb", std::ios::binary), b(folder / "b.glb", std::ios::binary);
  const std::string first((std::istreambuf_iterator<char>(a)), {}),
      second((std::istreambuf_iterator<char>(b)), {});
  EXPECT_GT(first.size(), 1000u);
  EXPECT_EQ(first, second);
}

TEST(ExportCommand, InfoShowsThePhysics) {
  ScratchFolder folder;
  ASSERT_EQ(run_tool({"export", "gltf", kJoints, folder / "a.glb"}).code, 0);
  ASSERT_EQ(run_tool({"export", "usd", kJoints, folder / "a.usda"}).code, 0);
  for (const char* name : {"a.glb", "a.usda"}) {
    const Printed info = run_tool({"info", folder / name});
    ASSERT_EQ(info.code, 0) << info.err;
    EXPECT_NE(info.out.find("body         door: RIGID"), std::string::npos) << info.out;
    EXPECT_NE(info.out.find("8 kg"), std::string::npos) << info.out;
    EXPECT_NE(info.out.find("joint        hinge door to the world"), std::string::npos) << info.out;
    EXPECT_NE(info.out.find("joint        ball weight to link 3"), std::string::npos) << info.out;
  }
}

TEST(ExportCommand, ErrorsAreOneLineWithARemedy) {
  ScratchFolder folder;
  const auto expect = [&](std::vector<std::string> words, const std::string& text) {
    const Printed printed = run_tool(std::move(words));
    EXPECT_EQ(printed.code, 2) << printed.out << printed.err;
    EXPECT_NE(printed.err.find(text), std::string::npos) << printed.err;
    EXPECT_EQ(std::count(printed.err.begin(), printed.err.end(), '\n'), 1) << printed.err;
  };
  expect({"export"},
         "export: SCENE, OUT or --format is missing; give all three, or one of web, gltf and usd");
  expect({"export", kJoints, folder / "out"}, "--format is missing");
  expect({"export", "usd", kJoints, folder / "a.usdz"}, "cannot be written as .usdz; use .usda, or a folder");
  expect({"export", "gltf", kJoints, folder / "a.usda"}, "is the name of a file");
  expect({"export", kJoints, folder / "a", "--format", "usd", "--spz"}, "--spz: is only for gltf; omit it");
  expect({"export", "gltf", folder / "none.scene.json", folder / "a.glb"}, "none.scene.json");
  expect({"export", "gltf", kJoints, folder / "a.glb", "--recording", kJoints}, "joints.scene.json");
  EXPECT_FALSE(fs::exists(folder / "a.glb"));
}

TEST(ExportCommand, HelpNamesTheFormats) {
  const Printed help = run_tool({"export", "--help"});
  EXPECT_EQ(help.code, 0);
  for (const char* word : {"gltf", "usd", "web", "--format", "--recording", "--spz"})
    EXPECT_NE(help.out.find(word), std::string::npos) << word;
}

}  // namespace
}  // namespace livegs
