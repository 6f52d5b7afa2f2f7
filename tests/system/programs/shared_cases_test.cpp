// SPDX-License-Identifier: Apache-2.0
// The files of the shared cases, each through the program and under 4 GB of address space. The README of that
// folder says what is right; sizes are those of the numbers in the files, volumes those of the shapes.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <set>

#include "common/gaussian/shared_data.h"
#include "gaussian/asset_file.h"
#include "gaussian/spherical_harmonics.h"
#include "scratch_folder.h"
#include "system/support/limited_tool.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

constexpr double kSizeTolerance = 1e-3;  // .spz and .sog store positions in steps
// Round kernels reach up to one deviation beyond the surface on which they lie.
constexpr double kVolumeTolerance = 0.2;
constexpr double kHeightTolerance = 0.1;
// The mug of spz_scale, by the README; the other one is 42 times smaller.
constexpr double kMugVolume = 8.73, kSmallMugVolume = kMugVolume / (42 * 42 * 42);

constexpr double ball_volume(double radius) { return 4.0 / 3 * std::numbers::pi * radius * radius * radius; }

// What `info` and `mesh --scale 1` print of an asset that is read right, in units of the file.
struct SharedAsset {
  const char* path;
  size_t kernels;
  Eigen::Vector3d size;
  const char* axes;  // the begin of the line
  bool antialiased;
  double volume, height;
  const char* note = "";  // a part of the note or warning; empty: there is none
};

constexpr const char* kAssumed = "-y up, assumed";
constexpr const char* kOfSpz = "y up in the file";

const SharedAsset kSharedAssets[] = {
    {"antialiased_flags/brush.ply", 600, {0.9992, 0.9983, 0.9969}, "y up, named", true, ball_volume(0.5), 1},
    {"antialiased_flags/brush_capital.ply",
     600,
     {0.9992, 0.9983, 0.9969},
     kAssumed,
     true,
     ball_volume(0.5),
     1},
    {"antialiased_flags/flag.spz", 600, {0.9992, 0.9983, 0.9969}, kOfSpz, true, ball_volume(0.5), 1},
    {"antialiased_flags/not.ply", 600, {0.9992, 0.9983, 0.9969}, kAssumed, false, ball_volume(0.5), 1},
    {"antialiased_flags/postshot.ply", 600, {0.9992, 0.9983, 0.9969}, kAssumed, true, ball_volume(0.5), 1},
    {"capital_endings/scans/SCAN.PLY", 900, {0.1999, 0.1998, 0.1996}, kAssumed, false, ball_volume(0.1), 0.2},
    {"capital_endings/scans/Vase.Spz", 900, {0.2399, 0.2397, 0.2395}, kOfSpz, false, ball_volume(0.12), 0.24},
    {"capital_endings/scans/cup.SPLAT",
     900,
     {0.09994, 0.09989, 0.0998},
     kAssumed,
     false,
     ball_volume(0.05),
     0.1},
    {"mesh_as_splats/flat_12.ply", 864, {0.2, 0.2, 0.2}, kAssumed, false, 0.008, 0.2},
    {"mesh_as_splats/flat_16.ply", 1536, {0.2, 0.2, 0.2}, kAssumed, false, 0.008, 0.2},
    {"mesh_as_splats/flat_20.ply", 2400, {0.2, 0.2, 0.2}, kAssumed, false, 0.008, 0.2},
    {"mesh_as_splats/round_12.ply", 864, {0.2, 0.2, 0.2}, kAssumed, false, 0.008, 0.2},
    {"mesh_as_splats/round_16.ply", 1536, {0.2, 0.2, 0.2}, kAssumed, false, 0.008, 0.2},
    {"mesh_as_splats/round_20.ply", 2400, {0.2, 0.2, 0.2}, kAssumed, false, 0.008, 0.2},
    {"rgb_colours/export.ply", 1500, {0.9996, 0.9993, 0.9992}, "z up, named", false, ball_volume(0.5), 1},
    {"rgb_colours/sh.ply", 1500, {0.9996, 0.9993, 0.9992}, kAssumed, false, ball_volume(0.5), 1},
    {"sharp_elements/camera_first.ply", 1200, {0.9996, 0.9992, 0.9988}, kAssumed, false, ball_volume(0.5), 1},
    {"sharp_elements/plain.ply", 1200, {0.9996, 0.9992, 0.9988}, kAssumed, false, ball_volume(0.5), 1},
    {"sharp_elements/sharp.ply", 1200, {0.9996, 0.9992, 0.9988}, kAssumed, false, ball_volume(0.5), 1},
    {"spz_scale/mug.ply", 2524, {4.9136, 4.2, 3.528}, kAssumed, false, kMugVolume, 4.2},
    {"streamed_sog/ball/lod-meta.json",
     4000,
     {0.9997, 0.9997, 0.9997},
     kAssumed,
     false,
     ball_volume(0.5),
     1,
     "finest level"},
    {"surfels_2dgs/point_cloud.ply",
     2500,
     {0.9996, 0.9996, 0.9996},
     kAssumed,
     false,
     ball_volume(0.5),
     1,
     "2DGS"},
    {"utm_double/box_origin.ply", 3750, {1, 1, 1}, kAssumed, false, 1, 1},
    {"utm_double/box_utm.ply", 3750, {1, 1, 1}, kAssumed, false, 1, 1, "a float there has steps of 0.5"},
    {"vertical_axis/mug.ply", 2524, {0.117, 0.084, 0.1}, "z up, named", false, kSmallMugVolume, 0.1},
};
constexpr const char* kSharedScenes[] = {"heavy_on_light/hundred.scene.json",
                                         "heavy_on_light/ten_thousand.scene.json",
                                         "vertical_axis/mug.scene.json"};

class SharedCases : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::is_directory(shared_cases())) GTEST_SKIP() << "the shared cases are not here";
  }
  static ToolOutcome run(std::vector<std::string> words) {
    ToolOutcome outcome = run_tool(std::move(words));
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome;
  }
  static std::string file(const std::string& name) { return shared_cases() / name; }
  // The height of the surface that `mesh` writes.
  double height(std::vector<std::string> words) const {
    const std::string obj = folder_ / "surface.obj";
    words.insert(words.end(), {"--output", obj});
    run(words);
    const auto [low, high] = y_range_of_obj(obj);
    return high - low;
  }
  const ScratchFolder folder_;
};

// A file that is added to the folder needs a row.
TEST_F(SharedCases, EachFileHasARow) {
  std::set<std::string> rows(std::begin(kSharedScenes), std::end(kSharedScenes));
  for (const SharedAsset& asset : kSharedAssets) rows.insert(asset.path);
  for (const std::string& row : rows) EXPECT_TRUE(fs::exists(file(row))) << row;
  for (const auto& entry : fs::recursive_directory_iterator(shared_cases())) {
    const fs::path path = entry.path().lexically_relative(shared_cases());
    if (!entry.is_regular_file() || path == "README.md") continue;
    bool of_streamed = false;
    for (fs::path up = path.parent_path(); !up.empty(); up = up.parent_path())
      of_streamed |= rows.contains(up / "lod-meta.json");
    EXPECT_TRUE(of_streamed || rows.contains(path)) << path;
  }
}

TEST_F(SharedCases, AssetsAreReadRight) {
  for (const SharedAsset& asset : kSharedAssets) {
    SCOPED_TRACE(asset.path);
    const ToolOutcome info = run({"info", file(asset.path)});
    EXPECT_EQ(info.number("kernels"), static_cast<double>(asset.kernels));
    std::istringstream sizes(info.value("size"));
    for (int axis = 0; axis < 3; ++axis) {
      double size = 0;
      sizes >> size;
      EXPECT_NEAR(size, asset.size[axis], kSizeTolerance * asset.size[axis] + 1e-4);
    }
    EXPECT_TRUE(info.value("axes").starts_with(asset.axes)) << info.value("axes");
    EXPECT_EQ(info.value("SH").find("antialiased") != std::string::npos, asset.antialiased) << info.out;
    if (*asset.note == '\0') EXPECT_EQ(info.value("note"), "");
    EXPECT_NE(info.value("note").find(asset.note), std::string::npos) << info.out;

    const std::string obj = folder_ / "surface.obj";
    const ToolOutcome mesh = run({"mesh", file(asset.path), "--scale", "1", "--output", obj});
    EXPECT_NEAR(mesh.number("volume"), asset.volume, kVolumeTolerance * asset.volume);
    const auto [low, high] = y_range_of_obj(obj);
    EXPECT_NEAR(high - low, asset.height, kHeightTolerance * asset.height);
    EXPECT_EQ((mesh.out + mesh.err).find("leak"), std::string::npos) << mesh.out << mesh.err;
    EXPECT_NE(mesh.err.find(asset.note), std::string::npos) << mesh.err;
  }
}

// The mug is 0.1 m high about its own axis; 0.084 m wide and 0.117 m long with its handle.
TEST_F(SharedCases, UpOverridesTheNamedAxis) {
  const std::string mug = file("vertical_axis/mug.ply");
  for (const auto& [up, height_m] :
       {std::pair("z", 0.1), {"-z", 0.1}, {"y", 0.084}, {"-y", 0.084}, {"x", 0.117}, {"-x", 0.117}})
    EXPECT_NEAR(height({"mesh", mug, "--scale", "1", "--up", up}), height_m, 0.05 * height_m) << up;
}

// Half a step of a byte. Kernels are in the order of the file with harmonics.
TEST_F(SharedCases, ColoursOfBytesAreThoseOfHarmonics) {
  const auto harmonics = read_asset(file("rgb_colours/sh.ply"));
  ASSERT_TRUE(harmonics) << harmonics.error().message;
  const std::string ply = folder_ / "converted.ply";
  run({"convert", file("rgb_colours/export.ply"), ply});
  const auto bytes = read_asset(ply);
  ASSERT_TRUE(bytes) << bytes.error().message;
  ASSERT_EQ(bytes->asset.size(), harmonics->asset.size());
  for (size_t i = 0; i < bytes->asset.size(); ++i) {
    const Eigen::Array3f difference = bytes->asset.sh_dc[i] - harmonics->asset.sh_dc[i];
    EXPECT_LE(difference.abs().maxCoeff(), 0.51f / 255 / kShBand0) << i;
  }
}

TEST_F(SharedCases, AntialiasedMarksSurviveFormats) {
  for (const SharedAsset& asset : kSharedAssets) {
    if (!std::string(asset.path).starts_with("antialiased_flags")) continue;
    const std::string spz = folder_ / "mark.spz", ply = folder_ / "mark.ply";
    run({"convert", file(asset.path), spz});
    run({"convert", spz, ply});
    for (const std::string& one : {spz, ply})
      EXPECT_EQ(run({"info", one}).value("SH").find("antialiased") != std::string::npos, asset.antialiased)
          << asset.path << " as " << one;
  }
}

TEST_F(SharedCases, GuessedUnitSurvivesSpz) {
  const std::string ply = file("spz_scale/mug.ply"), spz = folder_ / "mug.spz";
  run({"convert", ply, spz});
  EXPECT_TRUE(run({"info", spz}).value("unit").starts_with("unknown"));
  const ToolOutcome before = run({"mesh", ply}), after = run({"mesh", spz});
  EXPECT_NEAR(after.number("volume"), before.number("volume"), 0.05 * before.number("volume"));
  EXPECT_NEAR(after.number("volume"), 0.000116, 0.1 * 0.000116);
}

TEST_F(SharedCases, FoldersAreScenesOfTheirAssets) {
  const ToolOutcome scans = run({"info", file("capital_endings/scans")});
  EXPECT_EQ(scans.value("builds"), "yes");
  for (const char* name : {"SCAN", "Vase", "cup"})
    EXPECT_NE(scans.out.find(std::string("body         ") + name + ":"), std::string::npos) << scans.out;
  // A streamed SOG is one asset, by its folder too.
  EXPECT_EQ(run({"info", file("streamed_sog/ball")}).number("kernels"), 4000);
}

TEST_F(SharedCases, PlacedFilesKeepTheirShape) {
  const ToolOutcome origin = run({"mesh", file("utm_double/box_origin.ply"), "--scale", "1"});
  const ToolOutcome placed = run({"mesh", file("utm_double/box_utm.ply"), "--scale", "1"});
  EXPECT_NEAR(placed.number("volume"), origin.number("volume"), 1e-3 * origin.number("volume"));
  const ToolOutcome info = run({"info", file("utm_double/box_utm.ply")});
  EXPECT_TRUE(info.value("origin").starts_with("451234 5411235 521")) << info.out;
}

TEST_F(SharedCases, MugStandsUpright) {
  const std::string out = folder_ / "mug";
  run({"simulate", file("vertical_axis/mug.scene.json"), "-o", out, "--seconds", "2"});
  EXPECT_GT(std::abs(last_value(fs::path(out) / "bodies.csv", "mug", "qw")), 0.9999);
  // The centre of the walls is 0.044 m above the outer face of the base.
  EXPECT_NEAR(last_value(fs::path(out) / "bodies.csv", "mug", "py"), 0.0444, 0.0025);
}

// Each box rests on the one below, or a line before the run names the ratio of the masses.
TEST_F(SharedCases, HeavyRestsOnLightOrAWarningNamesTheRatio) {
  for (const auto& [scene, ratio] : {std::pair("hundred", 100.0), {"ten_thousand", 10000.0}}) {
    SCOPED_TRACE(scene);
    const std::string out = folder_ / scene;
    const ToolOutcome outcome = run({"simulate", file(std::string("heavy_on_light/") + scene + ".scene.json"),
                                     "-o", out, "--seconds", "2"});
    if (named_mass_ratio(outcome.err) == ratio) continue;
    EXPECT_NEAR(last_value(fs::path(out) / "bodies.csv", "light", "py"), 0.15, 1e-3);
    EXPECT_NEAR(last_value(fs::path(out) / "bodies.csv", "heavy", "py"), 0.45, 1e-3);
  }
}

}  // namespace
}  // namespace livegs
