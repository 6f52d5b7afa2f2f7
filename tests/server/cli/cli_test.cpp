// SPDX-License-Identifier: Apache-2.0
// Runs `livegs` as a program and checks its files and error messages.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/gaussian/synthetic_asset.h"
#include "core/file.h"
#include "gaussian/asset_file.h"
#include "scratch_folder.h"
#include "splat/image.h"
#include "system/support/sample_files.h"

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

TEST(Cli, SimulateWritesAllDocumentedFiles) {
  ScratchFolder folder;
  const Said said =
      run({"simulate", folder.write("two.scene.json", kScene), "--seconds", "0.5", "--output", folder / "out",
           "--particles", "--kernels", "--pictures", "--every", "15", "--quiet"});
  ASSERT_EQ(said.code, 0) << said.err;
  const fs::path out = folder / "out";
  // Frame 0 is the initial state, followed by 30 steps; two bodies per frame.
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

TEST(Cli, SimulateNamesItsFiles) {
  ScratchFolder folder;
  const Said said = run({"simulate", folder.write("two.scene.json", kScene), "--seconds", "0.2", "--offline",
                         "--output", folder / "out", "--pictures", "--quiet"});
  ASSERT_EQ(said.code, 0) << said.err;
  for (const char* name : {"bodies.csv", "energy.csv", "events.csv", "summary.json"})
    EXPECT_NE(said.out.find("written: " + (folder / "out").string() + "/" + name), std::string::npos)
        << said.out;
  EXPECT_NE(
      said.out.find("written: 13 files, " + (folder / "out").string() + "/frame_0000.png to frame_0012.png"),
      std::string::npos)
      << said.out;
}

// Where nothing is, pictures have the background of the scene; the option takes precedence.
TEST(Cli, PicturesHaveTheBackgroundOfTheScene) {
  ScratchFolder folder;
  std::string text = kScene;
  text.insert(1, R"( "background_rgb": [0.2, 0.4, 0.6],)");
  const fs::path scene = folder.write("two.scene.json", text);
  const auto corner = [](const fs::path& file) {
    const auto image = read_png(file);
    EXPECT_TRUE(image) << image.error().message;
    const float* pixel = image ? image->at(0, 0) : nullptr;
    return image ? Eigen::Vector3f(pixel[0], pixel[1], pixel[2]) : Eigen::Vector3f();
  };
  constexpr float kRounding = 0.5f / 255 + 1e-6f;
  const Eigen::Vector3f stated(0.2f, 0.4f, 0.6f);
  ASSERT_EQ(run({"render", scene, "-o", folder / "scene.png"}).code, 0);
  EXPECT_LE((corner(folder / "scene.png") - stated).cwiseAbs().maxCoeff(), kRounding);
  ASSERT_EQ(run({"render", scene, "-o", folder / "option.png", "--background", "1", "0", "0"}).code, 0);
  EXPECT_LE((corner(folder / "option.png") - Eigen::Vector3f(1, 0, 0)).cwiseAbs().maxCoeff(), kRounding);
  ASSERT_EQ(
      run({"simulate", scene, "--seconds", "0", "--output", folder / "out", "--pictures", "--quiet"}).code,
      0);
  EXPECT_LE((corner(folder / "out/frame_0000.png") - stated).cwiseAbs().maxCoeff(), kRounding);
}

TEST(Cli, ConvertTurnsAndScales) {
  ScratchFolder folder;
  GaussianAsset asset = synthetic_asset(100, 2, 4);
  ASSERT_TRUE(write_asset(folder / "z_up.ply", asset));
  const Said said = run({"convert", folder / "z_up.ply", folder / "y_up.ply", "--up", "z", "--scale", "0.5"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find((folder / "y_up.ply").string()), std::string::npos) << said.out;
  const auto turned = read_asset(folder / "y_up.ply");
  ASSERT_TRUE(turned) << turned.error().message;
  for (size_t k = 0; k < asset.size(); ++k) {
    // +Z of the input is -Y of the output.
    EXPECT_NEAR(turned->asset.positions[k].y(), -0.5f * asset.positions[k].z(), 1e-6);
    EXPECT_NEAR(turned->asset.positions[k].norm(), 0.5f * asset.positions[k].norm(), 1e-6);
    EXPECT_NEAR(turned->asset.log_scales[k].x(), asset.log_scales[k].x() + std::log(0.5f), 1e-6);
  }
}

// Kernels on a closed cylinder about y, of this radius and height.
GaussianAsset cylinder(float radius, float height) {
  GaussianAsset asset;
  const auto add = [&](float share, float turn, float y) {
    asset.positions.emplace_back(share * radius * std::cos(turn), y, share * radius * std::sin(turn));
    asset.log_scales.emplace_back(Eigen::Vector3f::Constant(std::log(0.03f * height)));
    asset.rotations.emplace_back(Eigen::Quaternionf::Identity());
    asset.opacity_logits.push_back(3);
    asset.sh_dc.emplace_back(Eigen::Vector3f::Zero());
  };
  for (int step = 0; step < 60; ++step) {
    const float turn = static_cast<float>(step) * 6.2831853f / 60;
    for (int row = 0; row <= 40; ++row) add(1, turn, height * (static_cast<float>(row) / 40 - 0.5f));
    for (int ring = 0; ring < 15; ++ring) {
      for (const float end : {-0.5f, 0.5f}) add(static_cast<float>(ring) / 15, turn, height * end);
    }
  }
  return asset;
}

// A unit that is a guess stays one: an object has the same size before and after a conversion.
TEST(Cli, ConversionsKeepSizeAndUnit) {
  ScratchFolder folder;
  const GaussianAsset mug = cylinder(1.6f, 4.2f);
  ASSERT_TRUE(write_asset(folder / "mug.ply", mug));
  const auto volume = [&](const std::string& file) {
    const Said said = run({"mesh", file});
    EXPECT_EQ(said.code, 0) << said.err;
    const size_t at = said.out.find("volume");
    return at == said.out.npos ? 0.0 : std::stod(said.out.substr(at + 6));
  };
  const double before = volume(folder / "mug.ply");
  EXPECT_GT(before, 1e-5);
  EXPECT_LT(before, 1e-2);  // guessed from the name
  std::string from = "mug.ply";
  for (const std::string to :
       {"a/mug.SPZ", "b/mug.compressed.ply", "c/mug.sog", "d/mug.splat", "e/mug.ply", "f/mug.spz"}) {
    fs::create_directories((folder.path() / to).parent_path());
    const Said said = run({"convert", folder / from, folder / to});
    ASSERT_EQ(said.code, 0) << said.err;
    EXPECT_NEAR(volume(folder / to) / before, 1, 0.05) << to;
    EXPECT_NE(run({"info", folder / to}).out.find("unit         unknown"), std::string::npos) << to;
    from = to;
  }
  ASSERT_EQ(run({"convert", folder / "mug.ply", folder / "m.spz", "--scale", "0.025", "--metric"}).code, 0);
  const Said info = run({"info", folder / "m.spz"});
  EXPECT_NE(info.out.find("metre"), std::string::npos) << info.out;
  const Said lost = run({"convert", folder / "m.spz", folder / "m.splat"});
  EXPECT_NE(lost.err.find("unit"), std::string::npos) << lost.err;
}

// The axis that a file names is used, said, and overridden by --up.
TEST(Cli, ConvertUsesTheAxisOfTheFile) {
  ScratchFolder folder;
  const GaussianAsset asset = synthetic_asset(50, 0, 4);
  AssetFrame frame;
  frame.up_axis = "z";
  frame.origin = {100, 200, 300};
  ASSERT_TRUE(write_asset(folder / "z.ply", asset, frame));
  EXPECT_NE(run({"info", folder / "z.ply"}).out.find("z up, named by the file"), std::string::npos);
  ASSERT_EQ(run({"convert", folder / "z.ply", folder / "named.ply"}).code, 0);
  ASSERT_EQ(run({"convert", folder / "z.ply", folder / "given.ply", "--up", "-y"}).code, 0);
  const auto named = read_asset(folder / "named.ply"), given = read_asset(folder / "given.ply");
  ASSERT_TRUE(named && given);
  EXPECT_NEAR(named->asset.positions[7].y(), -asset.positions[7].z(), 1e-6);
  EXPECT_EQ(named->frame.up_axis, "-y");
  EXPECT_NEAR(named->frame.origin.y(), -300, 1e-9);
  EXPECT_EQ(given->asset.positions[7], asset.positions[7]);
}

TEST(Cli, InfoDescribesFolders) {
  ScratchFolder folder;
  fs::create_directory(folder / "things");
  for (const char* name : {"cup.ply", "duck.ply"})
    fs::copy(sample_files(LIVEGS_TOOL) / name, folder / "things" / name);
  const Said said = run({"info", folder / "things"});
  EXPECT_EQ(said.code, 0) << said.err;
  for (const char* name :
       {"scene        things", "object       cup", "object       duck", "builds       yes"})
    EXPECT_NE(said.out.find(name), std::string::npos) << said.out;
  fs::create_directory(folder / "nothing");
  const Said empty = run({"info", folder / "nothing"});
  EXPECT_EQ(empty.code, 2);
  EXPECT_EQ(empty.err.find("meta.json"), std::string::npos) << empty.err;
}

TEST(Cli, OutputIsBitEqualForAnyThreadCount) {
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

TEST(Cli, AllSolversAndSkinningsRun) {
  ScratchFolder folder;
  const std::string scene = folder.write("two.scene.json", kScene);
  for (const char* solver : {"cells", "livegs-v1", "livegs-v1-steady"}) {
    for (const char* skinning : {"lattice", "livegs-v1"}) {
      const Said said = run({"simulate", scene, "--seconds", "0.2", "--output", folder / "out", "--kernels",
                             "--quiet", "--elastic-solver", solver, "--skinning", skinning});
      EXPECT_EQ(said.code, 0) << solver << " " << skinning << ": " << said.err;
    }
  }
  const Said unknown = run({"simulate", scene, "-o", folder / "out", "--elastic-solver", "fem"});
  EXPECT_EQ(unknown.code, 2);
  for (const char* choice : {"fem", "cells", "livegs-v1", "livegs-v1-steady"}) {
    EXPECT_NE(unknown.err.find(choice), std::string::npos) << unknown.err;
  }
}

// The rows of a CSV file as numbers, with the column indices of the header. The object's name is skipped.
struct Table {
  std::map<std::string, size_t> columns;
  std::vector<std::vector<double>> rows;
  double at(const std::vector<double>& row, const std::string& column) const {
    return row[columns.at(column)];
  }
};
Table table_of(const fs::path& path, const std::string& object) {
  Table table;
  for (const std::string& line : lines_of(path)) {
    std::vector<std::string> cells;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    if (table.columns.empty()) {
      for (size_t i = 0; i < cells.size(); ++i) table.columns[cells[i]] = i;
    } else if (cells[table.columns["object"]] == object) {
      std::vector<double>& row = table.rows.emplace_back();
      for (const std::string& cell : cells) row.push_back(std::strtod(cell.c_str(), nullptr));
    }
  }
  return table;
}

// Both bodies fall freely for 0.1 s, so their momentum is that of 3.4 kg under gravity. Later both have hit
// the floor.
TEST(Cli, EnergyAndEventsIncludeElasticBodies) {
  ScratchFolder folder;
  ASSERT_EQ(run({"simulate", folder.write("two.scene.json", kScene), "--seconds", "0.5", "-o", folder / "out",
                 "--quiet"})
                .code,
            0);
  std::vector<std::vector<double>> energy;
  for (const std::string& line : lines_of(folder.path() / "out" / "energy.csv")) {
    std::stringstream stream(line);
    energy.emplace_back();
    for (std::string cell; std::getline(stream, cell, ',');)
      energy.back().push_back(std::strtod(cell.c_str(), nullptr));
  }
  const auto& falling = energy.at(1 + 6);  // after the header and frame 0
  EXPECT_NEAR(falling[6], -3.4 * 9.81 * 0.1, 1e-5);
  EXPECT_NEAR(falling[2], 0.5 * 3.4 * 0.981 * 0.981, 1e-4);            // kinetic
  EXPECT_NEAR(energy.at(1)[4], 9.81 * (2.4 * 0.2 + 1.0 * 0.3), 1e-6);  // initial gravitational energy
  const std::string events = read_text_file(folder.path() / "out" / "events.csv").value();
  for (const char* touched : {",contact,soft,", ",contact,hard,"}) {
    EXPECT_NE(events.find(touched), std::string::npos) << touched << events;
  }
}

// Each written covariance is F Sigma F^T with the F of the same row. Sigma is the isotropic kernel of a
// point, with half the spacing as its width. Float rounding of three products is a few 1e-7 of the
// covariance.
TEST(Cli, KernelCovariancesMatchTheirDeformation) {
  ScratchFolder folder;
  std::string points = "x,y,z\n";
  for (int i = 0; i < 512; ++i) {
    char line[64];
    std::snprintf(line, sizeof line, "%g,%g,%g\n", 0.02 * (i % 8), 0.02 * (i / 8 % 8), 0.02 * (i / 64));
    points += line;
  }
  folder.write("block.csv", points);
  const std::string scene = folder.write("squash.scene.json", R"({ "rate_hz": 60, "gravity_m_s2": [0, 0, 0],
    "objects": [ { "name": "block", "points": "block.csv", "kernel_per_point": true,
      "pose": { "position_m": [1, 2, 3], "orientation": [0.9, 0.1, 0.3, -0.2] },
      "initial_deformation": [1.2, 0.1, 0, 0, 0.8, 0, 0, 0, 1],
      "physics": { "behavior": "ELASTIC", "density_kg_m3": 1000, "youngs_modulus_pa": 1e4 } } ] })");
  const Said said = run({"simulate", scene, "--seconds", "0.1", "-o", folder / "out", "--kernels",
                         "--particles", "--quiet", "--no-sleep"});
  ASSERT_EQ(said.code, 0) << said.err;
  const Table kernels = table_of(folder.path() / "out" / "kernels.csv", "block");
  const Table particles = table_of(folder.path() / "out" / "particles.csv", "block");
  ASSERT_EQ(kernels.rows.size(), 7u * 512u);
  ASSERT_EQ(particles.rows.size(), 7u * 512u);
  double farthest = 0, worst = 0, bent = 0;
  for (size_t k = 0; k < kernels.rows.size(); ++k) {
    const auto& row = kernels.rows[k];
    EXPECT_EQ(kernels.at(row, "kernel_id"), static_cast<double>(k % 512));
    EXPECT_EQ(particles.at(particles.rows[k], "particle_id"), static_cast<double>(k % 512));
    for (const char* axis : {"x", "y", "z"}) {
      farthest = std::max(farthest, std::abs(kernels.at(row, axis) - particles.at(particles.rows[k], axis)));
    }
    const size_t f = kernels.columns.at("F00"), s = kernels.columns.at("sxx");
    Eigen::Matrix3d gradient, covariance;
    gradient << row[f], row[f + 1], row[f + 2], row[f + 3], row[f + 4], row[f + 5], row[f + 6], row[f + 7],
        row[f + 8];
    covariance << row[s], row[s + 1], row[s + 2], row[s + 1], row[s + 3], row[s + 4], row[s + 2], row[s + 4],
        row[s + 5];
    const Eigen::Matrix3d expected = 0.01 * 0.01 * gradient * gradient.transpose();
    worst = std::max(worst, (covariance - expected).norm() / expected.norm());
    bent = std::max(bent, (gradient.transpose() * gradient - Eigen::Matrix3d::Identity()).norm());
  }
  EXPECT_LT(worst, 3e-6);
  EXPECT_GT(bent, 0.2);       // it was deformed
  EXPECT_LT(farthest, 2e-6);  // one kernel per particle, in the list's order; single precision positions
}

// Physically impossible numbers are refused before the run. The error is one line with the object, the field
// and the range.
TEST(Cli, RefusesBadPhysicsWithItsRange) {
  ScratchFolder folder;
  const std::pair<const char*, const char*> cases[] = {
      {R"("mass_kg": 0)", "physics.mass_kg: is 0; it must be between 1e-06 and 1e+06"},
      {R"("mass_kg": -1)", "physics.mass_kg: is -1; it must be between"},
      {R"("poisson_ratio": 0.5)", "physics.poisson_ratio: is 0.5; it must be between 0 and 0.49"},
      {R"("plasticity": 1.5)", "physics.plasticity: is 1.5; it must be between 0 and 1"},
      {R"("damping": 5)", "physics.damping: is 5; it must be between 0 and 2"},
      {R"("youngs_modulus_pa": 0)", "physics.youngs_modulus_pa: is 0; it must be between 1 and 1e+12"},
  };
  for (const auto& [physics, named] : cases) {
    const std::string scene = folder.write("bad.scene.json", std::string(R"({ "objects": [ { "name": "pillow",
      "shape": { "box": { "size_m": [0.4, 0.1, 0.4] } }, "physics": { "behavior": "ELASTIC", )") +
                                                                 physics + " } } ] }");
    for (const Said& said :
         {run({"info", scene}), run({"simulate", scene, "-o", folder / "out", "--quiet"})}) {
      EXPECT_EQ(said.code, 2) << physics;
      EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1) << said.err;
      EXPECT_NE(said.err.find("object \"pillow\": objects[0]."), std::string::npos) << said.err;
      EXPECT_NE(said.err.find(named), std::string::npos) << said.err;
    }
  }
}

// A modulus of 2 GPa on a pillow is used as written. Both commands print a warning.
TEST(Cli, StiffPillowRunsWithAWarning) {
  ScratchFolder folder;
  const std::string scene = folder.write("stiff.scene.json", R"({ "objects": [ { "name": "pillow",
    "shape": { "box": { "size_m": [0.4, 0.1, 0.4] } },
    "physics": { "behavior": "ELASTIC", "youngs_modulus_pa": 2e9 } } ] })");
  const Said info = run({"info", scene});
  EXPECT_EQ(info.code, 0) << info.err;
  EXPECT_NE(info.out.find("E 2e+09 Pa clipped to "), std::string::npos) << info.out;
  EXPECT_NE(info.out.find(
                "warning      pillow: physics.youngs_modulus_pa: 2e+09 Pa is used as written, but a pillow"),
            std::string::npos)
      << info.out;
  ASSERT_EQ(run({"simulate", scene, "--seconds", "0.1", "-o", folder / "out", "--quiet"}).code, 0);
  const auto summary = nlohmann::json::parse(read_text_file(folder.path() / "out" / "summary.json").value());
  const auto& object = summary["objects"][0];
  EXPECT_EQ(object["band"], "clipped");
  EXPECT_EQ(object["youngs_modulus_pa"], 2e9);
  EXPECT_LT(object["reached_youngs_modulus_pa"], 1e8);
  for (const char* field : {"cell_width_m", "substeps", "courant", "modulus_ratio_low", "modulus_ratio_high",
                            "modulus_ratio_across", "nodes", "bytes"}) {
    EXPECT_GT(object[field].get<double>(), 0) << field;
  }
  EXPECT_EQ(summary["warnings"].size(), 2u) << summary["warnings"];
}

TEST(Cli, AssetCommandsSucceed) {
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
  const Said mesh = run({"mesh", cup, "--output", folder / "cup.obj"});
  EXPECT_EQ(mesh.code, 0);
  EXPECT_NE(mesh.out.find((folder / "cup.obj").string()), std::string::npos) << mesh.out;
  EXPECT_GT(lines_of(folder / "cup.obj").size(), 1000u);
  const Said analysis = run({"analyze", cup, "--json", "--offline", "--explain", folder / "pages"});
  EXPECT_EQ(analysis.code, 0);
  EXPECT_NE(analysis.err.find("drawing views, 1 of 1"), std::string::npos) << analysis.err;
  // Three pictures, scene, object and mask, even without a model.
  const auto page = lines_of(folder / "pages/cup.html");
  EXPECT_EQ(std::count_if(page.begin(), page.end(),
                          [](const std::string& line) {
                            return line.rfind("<figure><img src=\"data:image/png", 0) == 0;
                          }),
            3);
  EXPECT_NE(analysis.out.find("\"mass_kg\""), std::string::npos);
  EXPECT_NE(analysis.out.find("stoneware"), std::string::npos);
  // The page has the same values as the table: the edited mass.
  folder.write("scene/cup.physics.json", R"({ "edits": { "mass_kg": 0.3217 } })");
  ASSERT_EQ(run({"analyze", cup, "--offline", "--explain", folder / "edited"}).code, 0);
  const auto rows = lines_of(folder / "edited/cup.html");
  EXPECT_TRUE(std::any_of(rows.begin(), rows.end(), [](const std::string& line) {
    return line.find("321.7 g") != std::string::npos && line.find(">person<") != std::string::npos;
  }));
}

// Errors are one line that names the input. The exit code is 2 if the user can correct it.
TEST(Cli, ErrorsOfBadInputAreOneLine) {
  ScratchFolder folder;
  folder.write("broken.ply", "ply\nformat binary_little_endian 1.0\nelement vertex 5\n");
  folder.write("bad.scene.json", R"({ "objects": [ { "nam": "x" } ] })");
  const fs::path prompts = folder.write("prompts/user.md", "{{nmae}} {{name}}\n");
  const std::pair<std::vector<std::string>, const char*> cases[] = {
      {{"info", folder / "absent.ply"}, "absent.ply"},
      {{"info", folder / "broken.ply"}, "broken.ply"},
      {{"info", folder / "bad.scene.json"}, "nam"},
      {{"info", folder.write("lost.scene.json", R"({ "environment": { "asset": "lost.ply" } })")},
       "lost.ply"},
      {{"simulate", folder.write("ok.scene.json", kScene), "-o", folder / "o", "--seconds", "nan"},
       "--seconds"},
      {{"convert", folder / "absent.spz", folder / "x.ply"}, "absent.spz"},
      {{"render", folder / "absent.ply"}, "absent.ply"},
      {{"simulate", folder / "absent.scene.json", "-o", folder / "o"}, "absent.scene.json"},
      {{"simulate", folder / "bad.scene.json", "-o", folder / "o"}, "nam"},
      {{"analyze", folder / "broken.ply"}, "broken.ply"},
      {{"analyze", folder / "ok.scene.json", "--name", "mug"}, "--name: is only for a single asset"},
      {{"analyze", folder / "ok.scene.json", "--scale", "2"}, "--scale: is only for a single asset"},
      {{"analyze", folder / "broken.ply", "--offline", "--prompts", prompts.parent_path()},
       "user.md: line 1: {{nmae}} is not a known slot; write {{name}} or remove it"},
      {{"mesh", folder / "broken.ply"}, "broken.ply"},
      // A file is never written in another format than its ending names.
      {{"render", folder / "broken.ply", "-o", folder / "x.jpg"},
       "x.jpg: cannot be written as .jpg; use .png"},
      {{"render", folder / "broken.ply", "-o", folder / "x"},
       "x: cannot be written without an ending; use .png"},
      {{"mesh", folder / "broken.ply", "--output", folder / "x.ply"},
       "x.ply: cannot be written as .ply; use .obj"},
      {{"convert", folder / "broken.ply", folder / "x.gltf"},
       "x.gltf: cannot be written as .gltf; use .ply or .spz or .sog or .splat or .glb"},
      {{"convert", folder / "broken.ply", folder / "x.ply", "--up", "w"}, "--up: is \"w\""},
      {{"convert", folder / "broken.ply", folder / "x.ply", "--scale", "0"},
       "--scale: must be a number above 0"},
      {{"fracture", folder / "broken.ply", "--output", folder / "x.png"}, "x.png: is the name of a file"},
      {{"simulate", folder / "ok.scene.json", "-o", folder / "x.csv"}, "x.csv: is the name of a file"},
      {{"sample", folder / "x.ply"}, "x.ply: is the name of a file"},
      {{"analyze", folder / "broken.ply", "--offline", "--explain", folder / "x.html"},
       "x.html: is the name of a file"},
  };
  for (const auto& [words, named] : cases) {
    const Said said = run(words);
    EXPECT_EQ(said.code, 2) << words[0] << " " << words[1];
    EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1) << said.err;
    EXPECT_NE(said.err.find(named), std::string::npos) << said.err;
    if (words[1].find("lost.scene.json") == std::string::npos) {
      EXPECT_EQ(said.out, "");  // valid inputs may be printed
    }
  }
  EXPECT_EQ(run({"simulate"}).code, 2);
  EXPECT_EQ(run({"dance"}).code, 2);
  EXPECT_EQ(run({"--help"}).code, 0);
  // A folder that cannot be created is not an error of the scene.
  const std::string scene = folder.write("two.scene.json", kScene);
  EXPECT_EQ(run({"simulate", scene, "-o", "/proc/nowhere", "--quiet"}).code, 1);
}

// Malformed fixtures are refused in one line, without a crash.
TEST(Cli, RefusesMalformedFixturesInOneLine) {
  const fs::path fixtures = fs::path(LIVEGS_SHARED_DATA_DIR) / "fixtures";
  if (!fs::exists(fixtures)) GTEST_SKIP() << "the shared data is missing";
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

// `livegs chart` passes --help to livegs-chart, which prints the usage of `livegs chart`.
TEST(Cli, ChartHelpIsAPlainUsageText) {
  for (const char* flag : {"--help", "-h"}) {
    const Said said = run({"chart", flag});
    EXPECT_EQ(said.code, 0) << said.err;
    EXPECT_EQ(said.err, "");
    EXPECT_NE(said.out.find("Usage: livegs chart [OPTIONS]\n"), std::string::npos) << said.out;
    for (const char* option : {"--output", "--only", "--quick", "--help"})
      EXPECT_NE(said.out.find(option), std::string::npos) << option << " is missing in: " << said.out;
    EXPECT_EQ(said.out.find("livegs-chart"), std::string::npos) << said.out;
  }
}

// Runs one scene of the chart: rows, one curve per method, and a page with the ranking.
TEST(Cli, ChartWritesRowsCurvesAndAPage) {
  ScratchFolder folder;
  const fs::path out = folder / "chart";
  const Said said = run({"chart", "--only", "squash", "--quick", "--output", out.string()});
  ASSERT_EQ(said.code, 0) << said.err;
  const auto rows = lines_of(out / "chart.csv");
  ASSERT_GT(rows.size(), 10u);
  EXPECT_EQ(rows[0].find("scene,solver,"), 0u) << rows[0];
  std::map<std::string, size_t> of_solver;
  for (size_t i = 1; i < rows.size(); ++i) {
    ASSERT_EQ(rows[i].find("squash,"), 0u) << rows[i];
    EXPECT_EQ(std::count(rows[i].begin(), rows[i].end(), ','),
              std::count(rows[0].begin(), rows[0].end(), ','))
        << rows[i];
    ++of_solver[rows[i].substr(7, rows[i].find(',', 7) - 7)];
  }
  EXPECT_GT(of_solver["cells"], 0u);
  EXPECT_GT(of_solver["livegs-v1"], 0u);
  const auto whole = [](const fs::path& path) {
    std::string text;
    for (const std::string& line : lines_of(path)) text += line + "\n";
    return text;
  };
  EXPECT_NE(whole(out / "squash.svg").find("</svg>"), std::string::npos);
  const std::string page = whole(out / "chart.md");
  EXPECT_NE(page.find("## Squash by 30 %"), std::string::npos) << page;
  EXPECT_NE(page.find("| case | method | substeps | error |"), std::string::npos) << page;
  EXPECT_NE(page.find("| 1e+05 Pa | `cells"), std::string::npos) << page;
}

}  // namespace
}  // namespace livegs
