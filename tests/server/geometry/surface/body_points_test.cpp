// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/reconstruct_surface.h"
#include "server/geometry/mesh/mesh_checks.h"
#include "server/geometry/surface/point_clouds.h"

namespace livegs {
namespace {

using namespace testing;

GaussianAsset kernels_at(const Points& points, double deviation, float opacity_logit = 4.0f) {
  GaussianAsset asset;
  asset.resize(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    asset.positions[i] = points[i].cast<float>();
    asset.log_scales[i].setConstant(static_cast<float>(std::log(deviation)));
    asset.rotations[i].setIdentity();
    asset.opacity_logits[i] = opacity_logit;
    asset.sh_dc[i].setZero();
  }
  return asset;
}

void append(GaussianAsset& asset, const GaussianAsset& more) {
  asset.positions.insert(asset.positions.end(), more.positions.begin(), more.positions.end());
  asset.log_scales.insert(asset.log_scales.end(), more.log_scales.begin(), more.log_scales.end());
  asset.rotations.insert(asset.rotations.end(), more.rotations.begin(), more.rotations.end());
  asset.opacity_logits.insert(asset.opacity_logits.end(), more.opacity_logits.begin(),
                              more.opacity_logits.end());
  asset.sh_dc.insert(asset.sh_dc.end(), more.sh_dc.begin(), more.sh_dc.end());
}

TEST(BodyPoints, LieInTheObjectFrame) {
  const Points points = sphere_cloud(500, 1.0);
  Similarity object_from_asset;
  object_from_asset.scale = 0.25;
  object_from_asset.rotation = Eigen::Quaterniond(0, 1, 0, 0);  // y and z reversed
  object_from_asset.translation_m = {0, 1, 0};
  const Points body = body_points(kernels_at(points, 1e-3), object_from_asset);
  ASSERT_EQ(body.size(), points.size());
  for (size_t i = 0; i < body.size(); ++i) {
    const Eigen::Vector3d p = points[i].cast<float>().cast<double>();
    EXPECT_TRUE(body[i].isApprox(Eigen::Vector3d(0.25 * p.x(), 1 - 0.25 * p.y(), -0.25 * p.z()), 1e-12));
  }
}

TEST(BodyPoints, ExcludeHazeAndFloaters) {
  GaussianAsset asset = kernels_at(sphere_cloud(20000, 1.0), 1e-3);
  append(asset,
         kernels_at(cloud(5000, 2, [](Random& r) { return Eigen::Vector3d(2 * r.in_cube()); }), 0.05, -3.0f));
  append(asset, kernels_at({{40, 0, 0}, {0, 1e6, 0}, {0, 1e6, 1}, {1.6, 1.6, 1.6}, {-3, 0, 0}}, 1e-3));
  const Points body = body_points(asset, Similarity{});
  EXPECT_EQ(body.size(), 20000u);
  for (const auto& p : body) EXPECT_LT(p.norm(), 1.001);
}

TEST(BodyPoints, KeepALongThinLeaf) {
  GaussianAsset asset = kernels_at(sphere_cloud(20000, 0.2), 1e-3);
  // 120 kernels along a stalk six radii long: 0.6 % of all kernels, fading, and far from the middle.
  Points leaf;
  for (int i = 0; i < 120; ++i) leaf.emplace_back(0.2 + 0.01 * i, 0.02 * std::sin(0.1 * i), 0.0);
  append(asset, kernels_at(leaf, 1e-3, -1.5f));
  const Points body = body_points(asset, Similarity{});
  EXPECT_EQ(body.size(), 20120u);
  const auto surface = reconstruct_surface(body, elastic_surface_options());
  ASSERT_TRUE(surface);
  expect_body(surface->mesh);
  EXPECT_NEAR(mesh_bounds_m(surface->mesh).max().x(), 1.39, 0.02);
  EXPECT_EQ(mesh_topology(surface->mesh).piece_count, 1);
}

TEST(BodyPoints, LargeKernelsAreSampledOverTheirExtent) {
  // A plate of 7 x 7 flat discs, farther apart than the alpha radius.
  Points points;
  for (int x = -3; x <= 3; ++x) {
    for (int z = -3; z <= 3; ++z) points.emplace_back(0.1 * x, 0.0, 0.1 * z);
  }
  GaussianAsset asset = kernels_at(points, 0.06);
  for (auto& scale : asset.log_scales) scale.y() = std::log(1e-4f);
  const Points body = body_points(asset, Similarity{});
  EXPECT_GT(body.size(), 49u * 20u);
  for (const auto& p : body) EXPECT_LT(std::abs(p.y()), 1e-6);
  EXPECT_LE(body.size(), 49u * 49u);
  const auto surface = reconstruct_surface(body, elastic_surface_options());
  ASSERT_TRUE(surface);
  EXPECT_EQ(mesh_topology(surface->mesh).piece_count, 1);
  EXPECT_EQ(surface->source, SurfaceSource::AlphaShape) << surface->note;
}

TEST(BodyPoints, SmallAndEmptyAssets) {
  EXPECT_TRUE(body_points(GaussianAsset{}, Similarity{}).empty());
  EXPECT_TRUE(body_points(kernels_at({{0, 0, 0}}, 1e-3, -9.0f), Similarity{}).empty());
  EXPECT_EQ(body_points(kernels_at({{0, 0, 0}}, 1e-3), Similarity{}).size(), 1u);
  EXPECT_EQ(body_points(kernels_at({{0, 0, 0}, {0, 0, 0}}, 1e-3), Similarity{}).size(), 2u);
  // A few kernels are not outliers of each other, however large they are.
  EXPECT_GE(body_points(kernels_at({{0, 0, 0}, {1, 0, 0}, {0, 5, 0}}, 1e18), Similarity{}).size(), 3u);
}

}  // namespace
}  // namespace livegs
