// SPDX-License-Identifier: Apache-2.0
// Inputs that are known to cause problems in splat tools, five generated ones of each kind. The program reads
// them with 4 GB of address space. Each is read correctly, or one line names the problem.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "common/gaussian/ply/ply_columns.h"
#include "core/file.h"
#include "gaussian/asset_file.h"
#include "known_gaps.h"
#include "scratch_folder.h"
#include "system/support/limited_tool.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

class InputKinds : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::vector<std::byte>& bytes) {
    EXPECT_TRUE(write_file_atomically(folder_ / name, bytes));
    return folder_ / name;
  }
  // Checks the output of `info` for a valid asset.
  ToolOutcome expect_read(const std::string& path, size_t kernels, double size, double tolerance = 1e-3) {
    const ToolOutcome outcome = run_tool({"info", path});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.number("kernels"), static_cast<double>(kernels)) << outcome.out;
    std::istringstream sizes(outcome.value("size"));
    for (double one = 0; sizes >> one;) EXPECT_NEAR(one, size, tolerance * size) << outcome.out;
    return outcome;
  }
  std::string converted(const std::string& from, const std::string& name) {
    const ToolOutcome outcome = run_tool({"convert", from, folder_ / name});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return folder_ / name;
  }
  const ScratchFolder folder_;
};

constexpr size_t kKernels = 600;

// A ball of radius 1 whose extent is that of its poles within half a percent.
GaussianAsset kinds_ball() { return ball_asset(kKernels, 0.03, 0.95); }
constexpr double kBallSize = 2, kBallTolerance = 0.01, kBallVolume = 4.0 / 3 * std::numbers::pi;

TEST_F(InputKinds, TwoScales) {
  const GaussianAsset asset = kinds_ball();
  for (int i = 0; i < 5; ++i) {
    std::vector<Column> columns = columns_of(asset);
    remove(columns, "scale_2");
    if (i == 2) named(columns, "scale_0").type = "double";
    if (i == 3) columns.insert(columns.begin() + 3, {"float", "nx", [](size_t) { return 0.0; }});
    if (i == 4) std::rotate(columns.begin(), columns.begin() + 5, columns.end());
    const ToolOutcome info = expect_read(write("surfels.ply", ply_of(columns, kKernels, "", i % 2 == 1)),
                                         kKernels, kBallSize, kBallTolerance);
    EXPECT_NE(info.value("note").find("2DGS"), std::string::npos) << info.out;
  }
}

TEST_F(InputKinds, NamedAxes) {
  const GaussianAsset asset = kinds_ball();
  for (const auto& [comment, axis] : {std::pair("Vertical Axis: z", "z"),
                                      {"vertical axis: Y", "y"},
                                      {"Up: -z", "-z"},
                                      {"VERTICAL AXIS: x", "x"},
                                      {"up: -X", "-x"}}) {
    const auto ply = ply_of(columns_of(asset), kKernels, "comment " + std::string(comment) + "\n");
    const ToolOutcome info = expect_read(write("axis.ply", ply), kKernels, kBallSize, kBallTolerance);
    EXPECT_EQ(info.value("axes"), std::string(axis) + " up, named by the file") << comment;
  }
}

TEST_F(InputKinds, ColoursInPlaceOfHarmonics) {
  const GaussianAsset asset = kinds_ball();
  const auto byte_of = [](size_t i, int channel) {
    return static_cast<double>((37 * i + 91 * channel) % 256);
  };
  for (int i = 0; i < 5; ++i) {
    std::vector<Column> columns = columns_of(asset);
    const char* types[] = {"uchar", "uchar", "ushort", "float", "double"};
    for (int channel = 0; channel < 3; ++channel) {
      remove(columns, "f_dc_" + std::to_string(channel));
      const char* names[] = {"red", "green", "blue"};
      const double unit = i == 2 ? 257 : i > 2 ? 1.0 / 255 : 1;
      columns.push_back({types[i], names[channel], [=](size_t k) { return unit * byte_of(k, channel); }});
    }
    const std::string path = write("rgb.ply", ply_of(columns, kKernels, "", i == 1));
    expect_read(path, kKernels, kBallSize, kBallTolerance);
    const auto read = read_asset(converted(path, "back.ply"));
    ASSERT_TRUE(read) << read.error().message;
    for (size_t k = 0; k < kKernels; k += 50) {
      for (int channel = 0; channel < 3; ++channel)
        EXPECT_NEAR(read->asset.sh_dc[k][channel], (byte_of(k, channel) / 255 - 0.5) / 0.28209479, 1e-4)
            << types[i] << ", channel " << channel;
    }
  }
}

TEST_F(InputKinds, AntialiasedMarksSurviveFormats) {
  const GaussianAsset asset = kinds_ball();
  for (const auto& [mark, marked] : {std::pair("SplatRenderMode: mip", true),
                                     {"SplatRenderMode: Mip", true},
                                     {"SPLATRENDERMODE: MIP", true},
                                     {"antialiased 1", true},
                                     {"Antialiased: True", true},
                                     {"SplatRenderMode: Default", false},
                                     {"antialiased 0", false},
                                     {"Antialiased: FALSE", false},
                                     {"trained without mip, not antialiased", false},
                                     {"SH degree: 0", false}}) {
    const auto ply = ply_of(columns_of(asset), kKernels, std::string("comment ") + mark + "\n");
    const std::string back = converted(converted(write("mip.ply", ply), "mip.spz"), "back.ply");
    const ToolOutcome info = expect_read(back, kKernels, kBallSize, kBallTolerance);
    EXPECT_EQ(info.value("SH").find("antialiased") != std::string::npos, marked) << mark << "\n" << info.out;
  }
}

TEST_F(InputKinds, EndingsInAnyCase) {
  GaussianAsset asset = kinds_ball();
  for (const auto& [lower, name] : {std::pair("a.ply", "SCAN.PLY"),
                                    {"a.spz", "Vase.Spz"},
                                    {"a.sog", "Cup.SOG"},
                                    {"a.compressed.ply", "Jug.Compressed.Ply"},
                                    {"a.splat", "pot.SPLAT"}}) {
    const ScratchFolder scans;
    ASSERT_TRUE(write_asset(scans / lower, asset));
    fs::rename(scans / lower, scans / name);
    expect_read(scans / name, kKernels, kBallSize, kBallTolerance);
    const ToolOutcome info = run_tool({"info", scans / ""});
    EXPECT_EQ(info.code, 0) << name << ": " << info.err;
    EXPECT_EQ(info.value("builds"), "yes") << name << "\n" << info.out;
  }
}

TEST_F(InputKinds, PositionsOnTheEarth) {
  const GaussianAsset asset = kinds_ball();
  for (const Eigen::Vector3d& place :
       {Eigen::Vector3d(451234.25, 5411235.5, 521), Eigen::Vector3d(-2694045.5, -4266795.25, 3888310),
        Eigen::Vector3d(15540000.5, 4230000.25, 40), Eigen::Vector3d(3e8, -2e8, 0),
        Eigen::Vector3d(0, 0, 6378137.125)}) {
    std::vector<Column> columns = columns_of(asset);
    for (int k = 0; k < 3; ++k) {
      Column& column = named(columns, std::string(1, "xyz"[k]));
      column.type = "double";
      column.value = [&asset, place, k](size_t i) { return place[k] + double{asset.positions[i][k]}; };
    }
    const ToolOutcome info =
        expect_read(write("utm.ply", ply_of(columns, kKernels)), kKernels, kBallSize, kBallTolerance);
    EXPECT_NE(info.value("origin"), "") << place.transpose();
  }
}

// A guessed unit is still marked as a guess after a conversion, and the guessed scale is the same.
TEST_F(InputKinds, GuessedUnitsSurviveFormats) {
  const std::pair<double, const char*> cases[] = {{0.02, "mug.spz"},
                                                  {0.3, "thing.sog"},
                                                  {2.1, "mug.spz"},
                                                  {40, "mug.compressed.ply"},
                                                  {900, "thing.spz"}};
  for (const auto& [radius, file] : cases) {
    GaussianAsset asset = kinds_ball();
    for (Eigen::Vector3f& position : asset.positions) position *= static_cast<float>(radius);
    for (Eigen::Vector3f& scale : asset.log_scales) scale.array() += static_cast<float>(std::log(radius));
    const std::string stem(file, std::string(file).find('.'));
    const std::string ply = write(stem + ".ply", encode_ply(asset));
    const std::string other = converted(ply, file);
    const ToolOutcome info = expect_read(other, kKernels, radius * kBallSize, kBallTolerance);
    EXPECT_TRUE(info.value("unit").starts_with("unknown")) << info.out;
    const ToolOutcome before = run_tool({"mesh", ply}), after = run_tool({"mesh", other});
    ASSERT_EQ(before.code, 0) << before.err;
    ASSERT_EQ(after.code, 0) << after.err;
    EXPECT_NEAR(after.number("scale"), before.number("scale"), 0.01 * before.number("scale")) << file;
    EXPECT_NEAR(after.number("volume"), before.number("volume"), 0.05 * before.number("volume")) << file;
  }
}

// One to five chunks of the finest level.
TEST_F(InputKinds, StreamedSogIsOneObject) {
  const GaussianAsset asset = kinds_ball();
  for (size_t chunks = 1; chunks <= 5; ++chunks) {
    const ScratchFolder streamed;
    nlohmann::json names = nlohmann::json::array(), leaves = nlohmann::json::array();
    for (size_t chunk = 0; chunk < chunks; ++chunk) {
      GaussianAsset part;
      for (size_t i = chunk * kKernels / chunks; i < (chunk + 1) * kKernels / chunks; ++i) {
        const size_t k = part.size();
        part.resize(k + 1);
        part.positions[k] = asset.positions[i];
        part.rotations[k] = asset.rotations[i];
        part.log_scales[k] = asset.log_scales[i];
        part.opacity_logits[k] = asset.opacity_logits[i];
        part.sh_dc[k] = asset.sh_dc[i];
      }
      for (const int level : {0, 1}) {
        const std::string name = std::to_string(level) + "_" + std::to_string(chunk) + ".sog";
        ASSERT_TRUE(write_asset(streamed / name, part));
        names.push_back(name);
      }
      const auto range = [&](size_t file) {
        return nlohmann::json{{"file", file}, {"offset", 0}, {"count", part.size()}};
      };
      leaves.push_back({{"bound", nlohmann::json::object()},
                        {"lods", {{"0", range(2 * chunk)}, {"1", range(2 * chunk + 1)}}}});
    }
    const nlohmann::json index = {{"version", 1},
                                  {"lodLevels", 2},
                                  {"environment", nullptr},
                                  {"filenames", names},
                                  {"tree", {{"children", leaves}}}};
    const std::string path = streamed.write("lod-meta.json", index.dump());
    expect_read(path, kKernels, kBallSize, kBallTolerance);
    expect_read(fs::path(path).parent_path(), kKernels, kBallSize, kBallTolerance);
  }
}

// One flat or round kernel a cell of a grid on each face of a cube of 0.2 m.
TEST_F(InputKinds, SplatsSampledOnAMesh) {
  for (const int edge : {8, 11, 14, 19, 25}) {
    for (const bool flat : {false, true}) {
      const double cell = 0.2 / edge;
      GaussianAsset asset;
      for (int i = 0; i < 6 * edge * edge; ++i) {
        const int face = i / (edge * edge), axis = face / 2;
        Eigen::Vector3d position;
        position[axis] = face % 2 ? 0.1 : -0.1;
        position[(axis + 1) % 3] = (i % edge + 0.5) * cell - 0.1;
        position[(axis + 2) % 3] = (i / edge % edge + 0.5) * cell - 0.1;
        asset.resize(asset.size() + 1);
        asset.positions.back() = position.cast<float>();
        Eigen::Vector3d scale = Eigen::Vector3d::Constant(0.5 * cell);
        if (flat) scale[axis] = 1e-5;
        asset.log_scales.back() = scale.array().log().cast<float>();
        asset.rotations.back().setIdentity();
        asset.opacity_logits.back() = 3;
        asset.sh_dc.back().setZero();
      }
      const ToolOutcome mesh = run_tool({"mesh", write("cube.ply", encode_ply(asset)), "--scale", "1"});
      ASSERT_EQ(mesh.code, 0) << mesh.err;
      EXPECT_EQ((mesh.out + mesh.err).find("leak"), std::string::npos) << mesh.out << mesh.err;
      const double error = std::abs(mesh.number("volume") / 0.008 - 1);
      // Round kernels reach a deviation beyond the cube: half a cell.
      if (edge == 8 && !flat) {
        report_gap("input_kinds.round_8_volume", error);
        continue;
      }
      EXPECT_LE(error, flat ? 0.02 : 0.2) << edge << (flat ? " flat\n" : " round\n") << mesh.out << mesh.err;
    }
  }
}

// Each box rests on the one below, or a line before the run names the ratio of the masses.
TEST_F(InputKinds, HeavyOnLight) {
  int warned = 0;
  for (const double light_kg : {5.0, 1.0, 0.1, 0.01, 0.001}) {
    const std::string scene =
        R"({ "rate_hz": 60, "environment": { "colliders": [ { "plane": {} } ] }, "objects": [
      { "name": "light", "shape": { "box": { "size_m": [0.3, 0.3, 0.3] } }, "pose": { "position_m": [0, 0.15, 0] },
        "physics": { "behavior": "RIGID", "mass_kg": )" +
        std::to_string(light_kg) + R"( } },
      { "name": "heavy", "shape": { "box": { "size_m": [0.3, 0.3, 0.3] } }, "pose": { "position_m": [0, 0.5, 0] },
        "physics": { "behavior": "RIGID", "mass_kg": 100 } } ] })";
    const std::string out = folder_ / "run";
    const ToolOutcome run =
        run_tool({"simulate", folder_.write("heavy.scene.json", scene), "-o", out, "--seconds", "2"});
    ASSERT_EQ(run.code, 0) << run.err;
    const double ratio = named_mass_ratio(run.err);
    if (ratio > 0) {
      EXPECT_NEAR(ratio, 100 / light_kg, 1) << run.err;
      ++warned;
      continue;
    }
    EXPECT_NEAR(last_value(fs::path(out) / "bodies.csv", "light", "py"), 0.15, 1e-3) << light_kg << " kg";
    EXPECT_NEAR(last_value(fs::path(out) / "bodies.csv", "heavy", "py"), 0.45, 1e-3) << light_kg << " kg";
  }
  EXPECT_LE(warned, 1);  // a ratio of 10 000 is carried
}

// Five file layouts: other elements before, after and around the vertices, with lists, and empty.
TEST_F(InputKinds, OtherElements) {
  const GaussianAsset asset = kinds_ball();
  const auto bytes = ply_of(columns_of(asset), kKernels, "", true);
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string first = "element camera 2\nproperty float fx\nproperty uint width\n",
                    first_rows = "1.5 640\n2.5 480\n";
  const std::string list = "element edge 2\nproperty list uchar int at\n", list_rows = "3 1 2 3\n0\n";
  const std::string empty = "element nothing 0\nproperty float none\n";
  const auto file = [&](const std::string& before, const std::string& before_rows, const std::string& behind,
                        const std::string& behind_rows) {
    std::string made = text;
    made.insert(made.find("end_header\n"), behind);
    made.insert(made.find("element vertex"), before);
    made.insert(made.find("end_header\n") + 11, before_rows);
    made += behind_rows;
    const auto span = std::as_bytes(std::span(made));
    return std::vector<std::byte>(span.begin(), span.end());
  };
  for (const auto& ply : {file(first, first_rows, "", ""), file("", "", first, first_rows),
                          file(first, first_rows, list, list_rows), file(list, list_rows, "", ""),
                          file(empty, "", first + list, first_rows + list_rows)}) {
    expect_read(write("elements.ply", ply), kKernels, kBallSize, kBallTolerance);
  }
}

// 300 000 kernels of up to the width of the object. They are recognised as activated values, and the surface
// does not grow with their width.
TEST_F(InputKinds, ActivatedValues) {
  for (const double deviation : {0.01, 0.05, 0.2, 0.5, 1.0}) {
    constexpr size_t kMany = 300'000;
    const GaussianAsset asset = ball_asset(kMany, deviation, 0.9);
    std::vector<Column> columns = columns_of(asset);
    for (const char* name : {"scale_0", "scale_1", "scale_2"})
      named(columns, name).value = [=](size_t) { return deviation; };
    named(columns, "opacity").value = [](size_t) { return 0.9; };
    const std::string path = write("activated.ply", ply_of(columns, kMany));
    const ToolOutcome info = expect_read(path, kMany, kBallSize, kBallTolerance);
    EXPECT_NE(info.out.find("activated"), std::string::npos) << info.out;
    const ToolOutcome mesh = run_tool({"mesh", path, "--scale", "0.1"});
    EXPECT_EQ(mesh.code, 0) << mesh.err;
    // Kernels of this width do not define a surface, so the surface is that of their centres.
    EXPECT_NEAR(mesh.number("volume"), kBallVolume * 1e-3, 0.02 * kBallVolume * 1e-3) << mesh.out;
  }
}

}  // namespace
}  // namespace livegs
