// SPDX-License-Identifier: Apache-2.0
// Checks the predictions of parallax.h against the reference renderer before they are applied to headset
// pictures.
#include "system/headset/parallax.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "system/headset/headset_session.h"

namespace livegs {
namespace {

class Parallax : public HeadsetSession {
 protected:
  void SetUp() override {
    const Scene scene =
        floating({{"middle", {0, 0, 0}}, {"left", {-0.35, 0, 0}}, {"right", {0.4, 0.1, 0.2}}});
    for (const SceneObject& object : scene.objects())
      ASSERT_TRUE(view_.add(object.id, object.asset, object.rest, object.environment));
    ids_ = {scene.find("middle")->id, scene.find("left")->id, scene.find("right")->id};
    drivers_ = scene.world().drivers();
  }

  // As in openxr_runtime/spaces.cpp; `scale` times 96 x 108 pixels.
  static std::vector<Camera> eyes_of(const Pose& head, double apart_m, double toed_in_rad, int scale) {
    std::vector<Camera> eyes;
    for (const double side : {-1.0, 1.0}) {
      const Pose eye{{0.5 * side * apart_m, 0, 0},
                     Eigen::Quaterniond(Eigen::AngleAxisd(side * toed_in_rad, Eigen::Vector3d::UnitY()))};
      eyes.push_back(camera_from_fov(head * eye, side < 0 ? -0.90 : -0.75, side < 0 ? 0.75 : 0.90, 0.80,
                                     -0.85, 96 * scale, 108 * scale));
    }
    return eyes;
  }

  // Measured parallax of each box from each of `heads` positions, relative to that of parallel eyes 64 mm
  // apart.
  std::vector<double> shares(int heads, double apart_m, double toed_in_rad, int scale) {
    std::mt19937 random(7);
    const auto between = [&](double low, double high) {
      return std::uniform_real_distribution(low, high)(random);
    };
    std::vector<double> found;
    for (int i = 0; i < heads; ++i) {
      const Pose head{{between(-0.15, 0.15), between(-0.1, 0.1), 1 + between(-0.1, 0.1)},
                      Eigen::Quaterniond(Eigen::AngleAxisd(between(-0.15, 0.15), Eigen::Vector3d::UnitY()))};
      const auto nominal = eyes_of(head, kEyesApart_m, 0, scale),
                 drawn = eyes_of(head, apart_m, toed_in_rad, scale);
      std::vector<Image> pictures;
      EXPECT_TRUE(view_.draw(drivers_, drawn, pictures));
      for (const uint32_t id : ids_) {
        const auto seen = seen_by_both(*view_.drawn_object(id), nominal);
        const auto measured = seen ? parallax(pictures[0], pictures[1], nominal, *seen) : std::nullopt;
        if (measured) found.push_back(*measured / seen->parallax);
      }
    }
    return found;
  }
  static double mean(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  }

  SceneView view_;
  DriverFrame drivers_;
  std::vector<uint32_t> ids_;
};

// Pixels of 5 mm resolve the centroid well. The pixels of the headset tests, 20 mm, do so in the mean of many
// pictures.
TEST_F(Parallax, OfBoxesMatchesTheirVisibleFaces) {
  const auto fine = shares(8, kEyesApart_m, 0, 4);
  ASSERT_GE(fine.size(), 20u);
  const auto [least, most] = std::minmax_element(fine.begin(), fine.end());
  std::printf("fine: %.4f to %.4f, mean %.4f of %zu\n", *least, *most, mean(fine), fine.size());
  EXPECT_GT(*least, 0.98);
  EXPECT_LT(*most, 1.02);
  const auto coarse = shares(60, kEyesApart_m, 0, 1);
  std::printf("coarse: mean %.4f of %zu\n", mean(coarse), coarse.size());
  EXPECT_NEAR(mean(coarse), 1.0, 0.01);
}

// Detects eyes that are 4 mm closer together, or turned towards each other by a quarter of a degree.
TEST_F(Parallax, DetectsWrongEyeDistanceAndDirection) {
  EXPECT_NEAR(mean(shares(8, 0.060, 0, 4)), 60.0 / 64.0, 0.01);
  const double toed_in_rad = 0.25 * M_PI / 180;
  EXPECT_NEAR(mean(shares(8, kEyesApart_m, toed_in_rad, 4)), 1 - 2 * toed_in_rad / (kEyesApart_m / 0.98),
              0.03);
}

// For a box that shows only its front, the parallax is that of a point at the depth of the front.
TEST_F(Parallax, OfAFrontFaceIsThatOfAPoint) {
  ASSERT_TRUE(view_.pose(drivers_));
  const auto seen = seen_by_both(*view_.drawn_object(ids_[0]),
                                 eyes_of({{0, 0, 1}, Eigen::Quaterniond::Identity()}, kEyesApart_m, 0, 1));
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->parallax, kEyesApart_m / 0.94,
              1e-3 * kEyesApart_m);  // kernels are 0.3 mm below the surface
}

}  // namespace
}  // namespace livegs
