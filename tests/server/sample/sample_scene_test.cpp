// SPDX-License-Identifier: Apache-2.0
#include "sample/sample_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>

#include "splat/rasterise.h"

namespace livegs {
namespace {

const std::vector<SampleAsset>& assets() {
  static const std::vector<SampleAsset> made = make_sample_assets(1);
  return made;
}

const GaussianAsset& asset_named(const std::string& name) {
  for (const SampleAsset& sample : assets())
    if (sample.name == name) return sample.asset;
  ADD_FAILURE() << "no sample asset is called " << name;
  static const GaussianAsset none;
  return none;
}

struct Box {
  Eigen::Vector3f low, high;
  Eigen::Vector3f size() const { return high - low; }
};

Box box_of(const GaussianAsset& asset) {
  Box box{asset.positions.front(), asset.positions.front()};
  for (const Eigen::Vector3f& p : asset.positions) {
    box.low = box.low.cwiseMin(p);
    box.high = box.high.cwiseMax(p);
  }
  return box;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(static_cast<const void*>(a.data()), static_cast<const void*>(b.data()),
                                   a.size() * sizeof(T)) == 0);
}

bool same_bits(const GaussianAsset& a, const GaussianAsset& b) {
  return a.sh_degree == b.sh_degree && same_bits(a.positions, b.positions) &&
         same_bits(a.log_scales, b.log_scales) && same_bits(a.rotations, b.rotations) &&
         same_bits(a.opacity_logits, b.opacity_logits) && same_bits(a.sh_dc, b.sh_dc) &&
         same_bits(a.sh_rest, b.sh_rest);
}

// Upright in a y-up world: half a turn about x.
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

TEST(SampleScene, HasSixObjectsAndARoom) {
  std::vector<std::string> names;
  for (const SampleAsset& sample : assets()) names.push_back(sample.name);
  EXPECT_EQ(names, (std::vector<std::string>{"cup", "pillow", "hat", "plant", "duck", "stool", "room"}));
}

TEST(SampleScene, KernelCountsAreThoseOfASmallCapture) {
  for (const SampleAsset& sample : assets()) {
    EXPECT_GE(sample.asset.size(), 20000u) << sample.name;
    EXPECT_LE(sample.asset.size(), 80000u) << sample.name;
  }
}

TEST(SampleScene, AssetsKeepTheInvariants) {
  for (const auto& [name, asset] : assets()) {
    const size_t count = asset.size();
    EXPECT_GE(asset.sh_degree, 1) << name;
    EXPECT_LE(asset.sh_degree, 3) << name;
    ASSERT_EQ(asset.log_scales.size(), count) << name;
    ASSERT_EQ(asset.rotations.size(), count) << name;
    ASSERT_EQ(asset.opacity_logits.size(), count) << name;
    ASSERT_EQ(asset.sh_dc.size(), count) << name;
    ASSERT_EQ(asset.sh_rest.size(), count * asset.sh_rest_count()) << name;
    for (size_t i = 0; i < count; ++i) {
      ASSERT_TRUE(asset.positions[i].allFinite() && asset.log_scales[i].allFinite() && asset.sh_dc[i].allFinite() &&
                  std::isfinite(asset.opacity_logits[i]))
          << name << " kernel " << i;
      // Four float roundings of a unit quaternion.
      ASSERT_NEAR(asset.rotations[i].norm(), 1.0f, 4 * 1.2e-7f) << name << " kernel " << i;
    }
    for (const Eigen::Vector3f& c : asset.sh_rest) ASSERT_TRUE(c.allFinite()) << name;
  }
}

TEST(SampleScene, KernelsLieFlatOnTheirSurface) {
  for (const auto& [name, asset] : assets())
    for (size_t i = 0; i < asset.size(); ++i) {
      const float tangential = std::min(asset.log_scales[i].x(), asset.log_scales[i].y());
      // The thickest material, loose soil, is 0.35 of its width.
      ASSERT_LT(asset.log_scales[i].z(), tangential + std::log(0.36f) + std::log(2.0f)) << name << " kernel " << i;
    }
}

TEST(SampleScene, ObjectsStandAtTheOriginInTheirStatedSize) {
  struct Size {
    double width_m, height_m, depth_m;
  };
  // Stated sizes in the header; 6 % for what differs from one specimen to the next.
  const std::map<std::string, Size> sizes = {{"cup", {0.116, 0.100, 0.084}},  {"pillow", {0.45, 0.148, 0.45}},
                                             {"hat", {0.288, 0.132, 0.301}},  {"duck", {0.094, 0.118, 0.137}},
                                             {"stool", {0.33, 0.450, 0.33}}};
  for (const auto& [name, size] : sizes) {
    const Box box = box_of(asset_named(name));
    EXPECT_NEAR(box.size().x(), size.width_m, 0.06 * size.width_m) << name;
    EXPECT_NEAR(box.size().y(), size.height_m, 0.06 * size.height_m) << name;
    EXPECT_NEAR(box.size().z(), size.depth_m, 0.06 * size.depth_m) << name;
  }
  EXPECT_NEAR(box_of(asset_named("plant")).size().y(), 0.50, 0.03);  // blades reach as far as they like sideways
  for (const auto& [name, asset] : assets()) {
    if (name == "room") continue;
    const Box box = box_of(asset);
    EXPECT_NEAR(box.high.y(), 0.0, 1e-6) << name;  // -Y is up: nothing below the floor
    EXPECT_NEAR(box.low.x() + box.high.x(), 0.0, 1e-6) << name;
    EXPECT_NEAR(box.low.z() + box.high.z(), 0.0, 1e-6) << name;
  }
}

TEST(SampleScene, RoomHasItsCornerWhereTheHeaderSaysAndStandsClearOfTheMiddle) {
  const GaussianAsset& room = asset_named("room");
  const Box box = box_of(room);
  // Kernels of the outermost row lie up to half a row from the edge: 15 mm.
  EXPECT_NEAR(box.low.x(), -1.5, 0.015);
  EXPECT_NEAR(box.high.x(), 1.5, 0.015);
  EXPECT_NEAR(box.high.z(), 1.5, 0.015);
  EXPECT_NEAR(box.low.z(), -1.5, 0.015);
  EXPECT_NEAR(box.low.y(), -2.4, 0.015);
  EXPECT_NEAR(box.high.y(), 0.0, 1e-6);
  for (const Eigen::Vector3f& p : room.positions)
    if (std::abs(p.x()) < 1.2f && std::abs(p.z()) < 1.2f) {
      ASSERT_GT(p.y(), -0.001f);  // seams are drawn 0.4 mm above the boards
    }
}

TEST(SampleScene, SameSeedGivesTheSameBits) {
  const std::vector<SampleAsset> again = make_sample_assets(1);
  ASSERT_EQ(again.size(), assets().size());
  for (size_t i = 0; i < again.size(); ++i) EXPECT_TRUE(same_bits(again[i].asset, assets()[i].asset)) << again[i].name;
}

TEST(SampleScene, AnotherSeedGivesAnotherSpecimenOfTheSameSize) {
  for (const auto& [name, asset] : make_sample_assets(7)) {
    const GaussianAsset& first = asset_named(name);
    EXPECT_FALSE(same_bits(asset, first)) << name;
    EXPECT_GE(asset.size(), 20000u) << name;
    EXPECT_LE(asset.size(), 80000u) << name;
    // Shape noise moves pillow and hat by a few millimetres: 6 % of their height.
    const float height_m = box_of(first).size().y();
    EXPECT_NEAR(box_of(asset).size().y(), height_m, 0.06 * height_m) << name;
  }
}

// Holes would show as pixels inside the silhouette that the background reaches.
TEST(SampleScene, SurfacesAreClosedWhenDrawn) {
  for (const auto& [name, asset] : assets()) {
    if (name == "room") continue;  // open by design; the next test looks at it from inside
    for (const double azimuth_rad : {0.4, 2.0, 3.6, 5.2}) {
      const RasterisedView view = seen_from(asset, azimuth_rad, 0.35);
      double coverage = 0.0;
      size_t inside = 0;
      constexpr int kMargin = 2;  // pixels; the soft edge of a kernel is not a hole
      for (int y = kMargin; y < view.image.height - kMargin; ++y)
        for (int x = kMargin; x < view.image.width - kMargin; ++x) {
          bool within = true;
          for (int dy = -kMargin; dy <= kMargin && within; ++dy)
            for (int dx = -kMargin; dx <= kMargin && within; ++dx) within = view.image.at(x + dx, y + dy)[3] > 0.5f;
          if (!within) continue;
          ++inside;
          coverage += view.image.at(x, y)[3];
        }
      ASSERT_GT(inside, 3000u) << name;
      EXPECT_GT(coverage / static_cast<double>(inside), 0.99) << name << " from " << azimuth_rad << " rad";
    }
  }
}

TEST(SampleScene, RoomFillsTheViewOfSomeoneStandingInIt) {
  const GaussianAsset& room = asset_named("room");
  const PosedKernels posed = stand_upright(room);
  const Camera camera = look_at({0.9, 1.1, 0.9}, {-0.6, 0.6, -0.9}, Eigen::Vector3d::UnitY(), 0.6, 640, 480);
  const DrawnObject object{&room, &posed, 0};
  Rasteriser rasteriser;
  RasterisedView view;
  rasteriser.draw(std::span(&object, 1), camera, {}, view);
  double coverage = 0.0;
  for (size_t i = 3; i < view.image.pixels.size(); i += 4) coverage += view.image.pixels[i];
  EXPECT_GT(coverage / (640 * 480), 0.99);
}

TEST(SampleScene, GlazeShinesFromTheSideOfTheWindowOnly) {
  // A kernel on the cup's flank that faces the window mirrors it to a viewer there and not to one far round.
  const GaussianAsset& cup = asset_named("cup");
  const RasterisedView toward = seen_from(cup, 0.7, 0.25), away = seen_from(cup, 0.7 + 3.14159, 0.25);
  const auto brightest = [](const RasterisedView& view) {
    double sum = 0.0;
    size_t count = 0;
    for (size_t i = 0; i < view.image.pixels.size(); i += 4)
      if (view.image.pixels[i + 3] > 0.99f) {
        sum += view.image.pixels[i] > 0.9f && view.image.pixels[i + 2] > 0.8f;
        ++count;
      }
    return sum / static_cast<double>(count);
  };
  EXPECT_GT(brightest(toward), 0.02);
  EXPECT_LT(brightest(away), 0.25 * brightest(toward));
}

}  // namespace
}  // namespace livegs
