// SPDX-License-Identifier: Apache-2.0
#include "viewer/hands/force_arrow.h"

#include <gtest/gtest.h>

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

TEST(ForceArrow, LengthAndWidthScaleWithForce) {
  const auto one = project_arrow(kCamera, {0, 0, 0}, {0, 5, 0}, 0.02),
             two = project_arrow(kCamera, {0, 0, 0}, {0, 10, 0}, 0.02);
  ASSERT_TRUE(one && two);
  EXPECT_NEAR(length_px(*one), 5 * 0.02 * 250, 1e-9);
  EXPECT_NEAR(length_px(*two), 2 * length_px(*one), 1e-9);
  EXPECT_NEAR(shaft_px(*two), 2 * shaft_px(*one), 1e-9);
  // World up is picture up, from the point of application.
  EXPECT_NEAR(one->outline_px[3].x(), 320, 1e-9);
  EXPECT_NEAR(one->outline_px[3].y(), 240 - 25, 1e-9);
}

TEST(ForceArrow, ProjectionHasPerspective) {
  const auto near = project_arrow(kCamera, {0, 0, 1}, {0, 10, 0}, 0.02),
             far = project_arrow(kCamera, {0, 0, 0}, {0, 10, 0}, 0.02);
  ASSERT_TRUE(near && far);
  EXPECT_NEAR(length_px(*near), 2 * length_px(*far), 1e-9);  // at half the distance
  const auto slanted = project_arrow(kCamera, {0, 0, 0}, {0, 5, 5}, 0.02);
  ASSERT_TRUE(slanted);
  EXPECT_LT(length_px(*slanted), std::sqrt(50) * 0.02 * 250);  // foreshortened
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
