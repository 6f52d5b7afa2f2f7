// SPDX-License-Identifier: Apache-2.0
#include "viewer/hands/force_arrow.h"

#include <gtest/gtest.h>

#include <cmath>

#include "viewer/camera/orbit_camera.h"

namespace livegs {
namespace {

// Two metres from the point, so that a metre there is 250 px.
const Camera kCamera = [] {
  Camera camera = look_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 1.0, 640, 480);
  camera.focal_x_px = camera.focal_y_px = 500;
  return camera;
}();

double length_px(const ProjectedArrow& arrow) {
  return (arrow.outline_px[3] - 0.5 * (arrow.outline_px[0] + arrow.outline_px[6])).norm();
}
double shaft_px(const ProjectedArrow& arrow) { return (arrow.outline_px[0] - arrow.outline_px[6]).norm(); }

TEST(ForceArrow, LengthScalesWithForceAndWidthIsFixed) {
  const auto one = project_arrow(kCamera, {0, 0, 0}, {0, 5, 0}, 0.02),
             two = project_arrow(kCamera, {0, 0, 0}, {0, 10, 0}, 0.02);
  ASSERT_TRUE(one && two);
  EXPECT_NEAR(length_px(*one), 5 * 0.02 * 250, 1e-9);
  EXPECT_NEAR(length_px(*two), 2 * length_px(*one), 1e-9);
  for (const auto& arrow : {*one, *two}) {
    EXPECT_NEAR(shaft_px(arrow), kArrowShaftWidth_px, 1e-9);
    EXPECT_NEAR((arrow.outline_px[2] - arrow.outline_px[4]).norm(), kArrowHeadWidth_px, 1e-9);
  }
  // World up is picture up, from the point of application.
  EXPECT_NEAR(one->outline_px[3].x(), 320, 1e-9);
  EXPECT_NEAR(one->outline_px[3].y(), 240 - 25, 1e-9);
}

// A force of any size, from any visible point, in any direction: the arrow stays in the picture.
TEST(ForceArrow, LargeForcesStayInView) {
  size_t drawn = 0;
  for (const double force_n : {20.0, 38.0, 1e3, 1e6}) {
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int i = 0; i < 24; ++i) {
          const double angle = i * M_PI / 12, tilt = (i % 5 - 2) * 0.5;
          const Eigen::Vector3d force =
              force_n * Eigen::Vector3d(std::cos(angle), std::sin(angle), tilt).normalized();
          const auto arrow = project_arrow(kCamera, {1.1 * x, 0.8 * y, 0.0}, force, 0.02);
          if (!arrow) continue;
          ++drawn;
          EXPECT_LE(length_px(*arrow), 0.3 * 480 + 1e-9);
          for (const Eigen::Vector2d& corner : arrow->outline_px) {
            EXPECT_TRUE(corner.x() >= 0 && corner.x() <= 640 && corner.y() >= 0 && corner.y() <= 480)
                << corner.transpose();
          }
        }
      }
    }
  }
  EXPECT_GT(drawn, 700u);  // of 864: only arrows from near an edge to that edge are left out
  const auto large = project_arrow(kCamera, {0, 0, 0}, {0, 1e3, 0}, 0.02);
  ASSERT_TRUE(large);
  EXPECT_NEAR(length_px(*large), 0.3 * 480, 1e-9);
  // The tip of this force is behind the eye; the arrow still has the direction of the force.
  const auto behind = project_arrow(kCamera, {0.2, 0, 0}, {0, 5, 200}, 0.02);
  ASSERT_TRUE(behind);
  EXPECT_GT(behind->outline_px[3].x(), behind->outline_px[0].x());
}

TEST(ForceArrow, ProjectionHasPerspective) {
  const auto near = project_arrow(kCamera, {0, 0, 1}, {0, 10, 0}, 0.02),
             far = project_arrow(kCamera, {0, 0, 0}, {0, 10, 0}, 0.02);
  ASSERT_TRUE(near && far);
  EXPECT_NEAR(length_px(*near), 2 * length_px(*far), 1e-9);  // at half the distance
  const auto slanted = project_arrow(kCamera, {0, 0, 0}, {0, 5, 5}, 0.02);
  ASSERT_TRUE(slanted);
  EXPECT_LT(length_px(*slanted), std::sqrt(50) * 0.02 * 250);  // foreshortened
  // Short arrows end where the pinhole projects the end of the force.
  const Eigen::Vector3d point(0.3, -0.2, 0.1), force(0.8, 0.5, 0.7);
  const auto small = project_arrow(kCamera, point, force, 0.02);
  const auto end_px = pixel_of(kCamera, point + 0.02 * force);
  ASSERT_TRUE(small && end_px);
  EXPECT_LT((small->outline_px[3] - *end_px).norm(), 0.1);
}

TEST(ForceArrow, InvisibleArrowsAreNotDrawn) {
  EXPECT_FALSE(project_arrow(kCamera, {0, 0, 0}, {0, 0, 0}, 0.02));
  EXPECT_FALSE(project_arrow(kCamera, {0, 0, 5}, {0, 5, 0}, 0.02));    // behind the eye
  EXPECT_FALSE(project_arrow(kCamera, {0, 0, 0}, {0, 0, 5}, 0.02));    // towards the eye
  EXPECT_FALSE(project_arrow(kCamera, {0, 0, 0}, {0, 0.1, 0}, 0.02));  // half a pixel
}

// A force equal to the weight is drawn at 0.4 of the object's size.
TEST(ForceArrow, WeightArrowScalesWithObject) {
  for (const auto& [mass_kg, size_m] : {std::pair(0.1, 0.3), {0.72, 0.5}, {12.0, 1.1}}) {
    EXPECT_NEAR(9.81 * mass_kg * arrow_metres_per_newton(mass_kg, size_m), 0.4 * size_m, 1e-12);
  }
  EXPECT_GT(arrow_metres_per_newton(0, 1), 0);  // without a mass
}

}  // namespace
}  // namespace livegs
