// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/file.h"
#include "gaussian/asset_file.h"
#include "geometry/field/sample_particles.h"
#include "geometry/mesh/mass_properties.h"
#include "geometry/mesh/mesh_io.h"
#include "geometry/reconstruct_surface.h"
#include "rates.h"
#include "server/geometry/mesh/mesh_checks.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

const fs::path kData = LIVEGS_SHARED_DATA_DIR;

// Rotates from x right, -y up to +y up.
Similarity turned_up() {
  Similarity similarity;
  similarity.rotation = Eigen::Quaterniond(0, 1, 0, 0);
  return similarity;
}

TEST(RealAssets, AllCapturedAssetsGiveABody) {
  if (!fs::exists(kData / "splats")) GTEST_SKIP() << "the shared data is missing";
  std::vector<fs::path> files{kData / "splats/fur_block/meta.json",
                              kData / "splats/playbot/sog_lod2/meta.json"};
  for (const auto& entry : fs::recursive_directory_iterator(kData / "splats")) {
    const std::string extension = entry.path().extension();
    const bool small = entry.is_regular_file() && entry.file_size() < 1'200'000;  // the nightly run takes all
    const bool captured =
        extension == ".ply" || extension == ".spz" || extension == ".sog" || extension == ".splat";
    if (captured && (small || full_sets())) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  int bodies = 0;
  for (const fs::path& file : files) {
    SCOPED_TRACE(file.string());
    const auto asset = read_asset(file);
    if (!asset) {
      std::printf("%s: not read: %s\n", file.filename().c_str(), asset.error().message.c_str());
      continue;
    }
    const auto points = body_points(asset->asset, turned_up());
    for (const bool rigid : {false, true}) {
      const auto surface =
          reconstruct_surface(points, rigid ? rigid_surface_options() : elastic_surface_options());
      ASSERT_TRUE(surface) << surface.error().message;
      testing::expect_body(surface->mesh);
      // Captured assets are not degenerate: an alpha shape must be found.
      EXPECT_TRUE(surface->source == SurfaceSource::AlphaShape ||
                  surface->source == SurfaceSource::LargerAlphaShape);
      EXPECT_LT(mesh_topology(surface->mesh).piece_count, 60);
      const ParticleSet particles = sample_particles(surface->mesh);
      EXPECT_GE(particles.positions_m.size(), 20u);
      double volume_m3 = 0.0;
      for (double share_m3 : particles.volumes_m3) {
        EXPECT_GT(share_m3, 0.0);
        volume_m3 += share_m3;
      }
      EXPECT_NEAR(volume_m3 / signed_volume_m3(surface->mesh), 1.0, 1e-9);
    }
    ++bodies;
  }
  EXPECT_GE(bodies, full_sets() ? 15 : 6);
}

// The table contains volume and surface of the scans that the kernels were made from.
TEST(RealAssets, YcbVolumesMatchTheirScans) {
  const auto text = read_text_file(kData / "ycb/objects.json");
  if (!text) GTEST_SKIP() << "the shared data is missing";
  const auto table = nlohmann::json::parse(*text);
  std::printf("%-24s %9s %8s %8s\n", "object", "scan cm3", "elastic", "rigid");
  std::vector<double> solid_errors;
  for (const auto& object : table["objects"]) {
    const std::string id = object["id"];
    SCOPED_TRACE(id);
    const auto asset = read_asset(kData / "ycb" / id / "splat.ply");
    ASSERT_TRUE(asset) << asset.error().message;
    const double scan_m3 = object["mesh_volume_cm3"].get<double>() * 1e-6;
    const auto points = body_points(asset->asset, Similarity{});
    double ratios[2];
    for (const bool rigid : {false, true}) {
      const auto surface =
          reconstruct_surface(points, rigid ? rigid_surface_options() : elastic_surface_options());
      ASSERT_TRUE(surface) << surface.error().message;
      testing::expect_body(surface->mesh);
      ratios[rigid] = signed_volume_m3(surface->mesh) / scan_m3;
    }
    std::printf("%-24s %9.1f %+7.1f%% %+7.1f%%\n", id.c_str(), scan_m3 * 1e6, 100 * (ratios[0] - 1),
                100 * (ratios[1] - 1));
    // Solids: objects thicker than the diameter of the ball (a wall of 2 V / A compared with 0.06 of the
    // diagonal).
    const double size_m = std::hypot(object["size_m"][0].get<double>(), object["size_m"][1].get<double>(),
                                     object["size_m"][2].get<double>());
    const double wall_m = 2 * scan_m3 / (object["surface_cm2"].get<double>() * 1e-4);
    if (wall_m > 0.06 * size_m) solid_errors.push_back(std::abs(ratios[0] - 1));
  }
  ASSERT_GE(solid_errors.size(), 8u);
  std::sort(solid_errors.begin(), solid_errors.end());
  std::printf("solids: %zu, median %.1f %%, worst %.1f %%\n", solid_errors.size(),
              100 * solid_errors[solid_errors.size() / 2], 100 * solid_errors.back());
  // Kernel centres lie on the scan. A ball of 0.03 of the diagonal rounds edges and dents.
  EXPECT_LT(solid_errors[solid_errors.size() / 2], 0.05);
  EXPECT_LT(solid_errors.back(), 0.25);
}

TEST(RealAssets, ScansReadAsMeshesKeepTheirVolume) {
  const auto text = read_text_file(kData / "ycb/objects.json");
  if (!text) GTEST_SKIP() << "the shared data is missing";
  const auto table = nlohmann::json::parse(*text);
  for (const auto& object : table["objects"]) {
    const std::string id = object["id"];
    const auto mesh = read_obj(kData / "ycb" / id / "textured.obj");
    ASSERT_TRUE(mesh) << mesh.error().message;
    EXPECT_EQ(mesh->triangles.size(), object["faces"].get<size_t>()) << id;
    // The table has one decimal in cubic centimetres, the file five in metres.
    const double scan_cm3 = object["mesh_volume_cm3"].get<double>();
    EXPECT_NEAR(signed_volume_m3(*mesh) * 1e6, scan_cm3, 0.06 + 1e-3 * scan_cm3) << id;
  }
}

}  // namespace
}  // namespace livegs
