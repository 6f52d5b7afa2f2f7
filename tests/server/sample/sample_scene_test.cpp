// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "sample/sample_scene.h"
#include "server/sample/specimens.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

// Upright in a y-up world: a rotation by 180 degrees about x.
PosedKernels stand_upright(const GaussianAsset& asset) {
  const Eigen::Quaternionf upright(0.0f, 1.0f, 0.0f, 0.0f);
  PosedKernels posed;
  posed.resize(asset.size());
  for (size_t i = 0; i < asset.size(); ++i) {
    posed.positions_m[i] = upright * asset.positions[i];
    const Eigen::Matrix3f axes = (upright * asset.rotations[i]).toRotationMatrix();
    const Eigen::Vector3f variances = (2.0f * asset.log_scales[i]).array().exp();
    const Eigen::Matrix3f c = axes * variances.asDiagonal() * axes.transpose();
    posed.covariances_m2[i] = {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)};
    posed.world_from_asset[i] = upright;
  }
  return posed;
}

RasterisedView seen_from(const GaussianAsset& asset, double azimuth_rad, double elevation_rad) {
  const PosedKernels posed = stand_upright(asset);
  Eigen::Vector3f low = posed.positions_m.front(), high = low;
  for (const Eigen::Vector3f& p : posed.positions_m) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector3d middle = (0.5f * (low + high)).cast<double>();
  const double distance_m = 1.6 * (high - low).cast<double>().norm();
  const Eigen::Vector3d toward(std::sin(azimuth_rad) * std::cos(elevation_rad), std::sin(elevation_rad),
                               std::cos(azimuth_rad) * std::cos(elevation_rad));
  const Camera camera =
      look_at(middle + distance_m * toward, middle, Eigen::Vector3d::UnitY(), 0.6, 640, 480);
  const DrawnObject object{&asset, &posed, 0};
  Rasteriser rasteriser;
  RasterisedView view;
  rasteriser.draw(std::span(&object, 1), camera, {}, view);
  return view;
}

void expect_at_origin(const GaussianAsset& asset, bool is_room) {
  const Box box = box_of(asset);
  EXPECT_NEAR(box.high.y(), 0.0, 1e-6);  // -Y is up: no kernel is below the floor
  if (!is_room) {
    EXPECT_NEAR(box.low.x() + box.high.x(), 0.0, 1e-6);
    EXPECT_NEAR(box.low.z() + box.high.z(), 0.0, 1e-6);
    return;
  }
  // Walls at x = -1.5 and z = +1.5. The outermost row of kernels is up to half a row, 15 mm, from an edge.
  EXPECT_NEAR(box.low.x(), -1.5, 0.001);
  EXPECT_NEAR(box.high.z(), 1.5, 0.001);
  EXPECT_NEAR(box.high.x(), 1.5, 0.015);
  EXPECT_NEAR(box.low.z(), -1.5, 0.015);
  EXPECT_NEAR(box.low.y(), -2.4, 0.015);
  for (const Eigen::Vector3f& p : asset.positions)
    if (std::abs(p.x()) < 1.2f && std::abs(p.z()) < 1.2f) {
      ASSERT_GT(p.y(), -0.001f);  // the middle is empty; seams are drawn 0.4 mm above the boards
    }
}

// Tests one asset per instance, so that each process makes only the asset that it needs.
class SampleSpecimen : public testing::TestWithParam<Specimen> {
 protected:
  bool is_room() const { return GetParam().make == make_room_corner; }
};

TEST_P(SampleSpecimen, IsValidAndHasTheDocumentedSize) {
  const GaussianAsset asset = GetParam().make(1);
  expect_small_capture(asset);
  expect_invariants(asset);
  expect_size(asset, GetParam());
  expect_at_origin(asset, is_room());
  for (size_t i = 0; i < asset.size(); ++i) {
    // The third axis is the normal. The thickest material, loose soil, has a thickness of 0.35 of its width.
    // A thread twice as long as wide divides the other axis by the square root of two.
    const float tangential = std::min(asset.log_scales[i].x(), asset.log_scales[i].y());
    ASSERT_LT(asset.log_scales[i].z(), tangential + std::log(0.36f * 1.5f)) << "kernel " << i;
  }
}

// Holes appear as pixels inside the silhouette that show the background.
TEST_P(SampleSpecimen, IsClosedWhenDrawn) {
  const GaussianAsset asset = GetParam().make(1);
  // The room is viewed from inside, towards the corner: azimuths of the open sides.
  const std::vector<double> azimuths_rad =
      is_room() ? std::vector<double>{0.4, 0.8, 1.2} : std::vector<double>{0.4, 2.0, 3.6, 5.2};
  for (const double azimuth_rad : azimuths_rad) {
    const RasterisedView view = seen_from(asset, azimuth_rad, 0.35);
    double coverage = 0.0;
    size_t inside = 0;
    constexpr int kMargin = 2;  // pixels; the soft edge of a kernel is not a hole
    for (int y = kMargin; y < view.image.height - kMargin; ++y)
      for (int x = kMargin; x < view.image.width - kMargin; ++x) {
        bool within = true;
        for (int dy = -kMargin; dy <= kMargin && within; ++dy)
          for (int dx = -kMargin; dx <= kMargin && within; ++dx)
            within = view.image.at(x + dx, y + dy)[3] > 0.5f;
        if (!within) continue;
        ++inside;
        coverage += view.image.at(x, y)[3];
      }
    ASSERT_GT(inside, 3000u);
    EXPECT_GT(coverage / static_cast<double>(inside), 0.99) << "from " << azimuth_rad << " rad";
  }
}

INSTANTIATE_TEST_SUITE_P(SampleScene, SampleSpecimen, testing::ValuesIn(kSpecimens),
                         [](const auto& specimen) { return std::string(specimen.param.name); });

TEST(SampleScene, HasSixNamedObjectsAndARoom) {
  std::vector<std::string> names;
  for (const SampleAsset& sample : make_sample_assets(1)) names.push_back(sample.name);
  EXPECT_EQ(names, (std::vector<std::string>{"cup", "pillow", "hat", "plant", "duck", "stool", "room"}));
}

TEST(SampleScene, GlazeShinesOnTheSideOfTheWindow) {
  const GaussianAsset cup = make_cup(1);
  const auto bright_share = [&](double azimuth_rad) {
    const RasterisedView view = seen_from(cup, azimuth_rad, 0.25);
    double bright = 0.0;
    size_t count = 0;
    for (size_t i = 0; i < view.image.pixels.size(); i += 4)
      if (view.image.pixels[i + 3] > 0.99f) {
        bright += view.image.pixels[i] > 0.9f && view.image.pixels[i + 2] > 0.8f;
        ++count;
      }
    return bright / static_cast<double>(count);
  };
  const double toward = bright_share(0.7), away = bright_share(0.7 + 3.14159);
  EXPECT_GT(toward, 0.02);
  EXPECT_LT(away, 0.25 * toward);
}

}  // namespace
}  // namespace livegs
