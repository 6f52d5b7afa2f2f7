// SPDX-License-Identifier: Apache-2.0
// Regions of a scene file during a run.
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include "scene/scene.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A bar of 0.4 m by 0.1 m by 0.1 m, 1000 kg/m3, 1e5 Pa, in free space at (1, 2, 3). It is rotated by 90
// degrees about z, so its x axis is along the world's y axis.
Scene bar(const std::string& regions, const std::string& events = "[]") {
  v1::Scene file;
  const auto parsed = google::protobuf::util::JsonStringToMessage(
      R"({ "rate_hz": 60, "substeps": 4, "gravity_m_s2": [0, 0, 0], "objects": [ { "name": "bar",
        "shape": { "box": { "size_m": [0.4, 0.1, 0.1] } }, "spacing_m": 0.025,
        "pose": { "position_m": [1, 2, 3], "orientation": [0.70710678118654757, 0, 0, 0.70710678118654757] },
        "physics": { "behavior": "ELASTIC", "density_kg_m3": 1000, "youngs_modulus_pa": 1e5, "poisson_ratio": 0,
                     "damping": 1 },
        "regions": [ )" +
          regions + R"( ] } ], "events": )" + events + " }",
      &file);
  EXPECT_TRUE(parsed.ok()) << parsed.message();
  auto scene = Scene::build(file, "", "bar", {});
  EXPECT_TRUE(scene) << scene.error().message;
  return std::move(*scene);
}

void run_to(Scene& scene, double time_s) {
  while (static_cast<double>(scene.world().tick()) < time_s * 60 - 1e-6) scene.step();
}

// Current position of a material point, in the initial frame of the bar.
Vector3d now(const Scene& scene, const Vector3d& rest_m) {
  const Matrix3d turn = (Matrix3d() << 0, -1, 0, 1, 0, 0, 0, 0, 1).finished();
  return turn.transpose() * (scene.world().world_point(scene.find("bar")->id, rest_m) - Vector3d(1, 2, 3));
}

constexpr const char* kClamp = R"({ "name": "clamp", "box": { "max_m": [-0.15, 1, 1] }, "fixed": true })";

// Stretched by 2 mm over the 0.3 m between clamp and grip, the bar has a uniform strain of 2 / 300. After the
// release the strain is 0.
TEST(RegionRun, StretchesTheBarUniformlyUntilReleased) {
  Scene scene = bar(std::string(kClamp) + R"(, { "name": "grip", "box": { "min_m": [0.15, -1, -1] },
      "motion": { "displacement_ramp": { "displacement_m": [0.002, 0, 0], "start_s": 0.1, "end_s": 0.5 } } })",
                    R"([ { "time_s": 2, "release_region": { "object": "bar", "region": "grip" } } ])");
  run_to(scene, 0.3);  // half of the displacement
  EXPECT_NEAR(now(scene, {0.2, 0, 0}).x() - 0.2, 0.001, 1e-5);
  run_to(scene, 2);
  for (const double x : {0.15, 0.175, 0.2}) {
    EXPECT_LT((now(scene, {x, 0.05, -0.05}) - Vector3d(x + 0.002, 0.05, -0.05)).norm(), 1e-5) << x;
  }
  for (const double x : {-0.1, 0.0, 0.1}) {  // 2 % of the stretch
    EXPECT_NEAR(now(scene, {x, 0, 0}).x() - x, 0.002 * (x + 0.15) / 0.3, 0.02 * 0.002) << x;
  }
  run_to(scene, 4);
  EXPECT_NEAR(now(scene, {0.2, 0, 0}).x(), 0.2, 0.02 * 0.002);
}

// All outer particles follow A X about the origin and back. The inside follows them, because an affine map is
// an equilibrium. The bound is 2 % of the deformation.
TEST(RegionRun, AffineBoundaryRampMovesTheInside) {
  Scene scene = bar(R"({ "name": "all", "boundary": true, "motion": { "affine_ramp": {
      "matrix": [1.2, 0.1, 0, 0, 1, 0, 0, 0, 0.9], "start_s": 0, "end_s": 0.5, "return_end_s": 1.5 } } })");
  const Matrix3d a = (Matrix3d() << 1.2, 0.1, 0, 0, 1, 0, 0, 0, 0.9).finished();
  run_to(scene, 0.5);
  const Vector3d corner(0.2, 0.05, 0.05), inside(0.1, 0.0125, -0.0125);
  EXPECT_LT((now(scene, corner) - a * corner).norm(), 0.02 * (a * corner - corner).norm());
  EXPECT_LT((now(scene, inside) - a * inside).norm(), 0.02 * (a * corner - corner).norm());
  run_to(scene, 3);
  EXPECT_LT((now(scene, inside) - inside).norm(), 0.02 * (a * corner - corner).norm());
}

TEST(RegionRun, PulseReturnsToTheStart) {
  Scene scene = bar(std::string(kClamp) + R"(, { "name": "tip", "box": { "min_m": [0.15, -1, -1] },
      "motion": { "half_sine_pulse": { "displacement_m": [0, 0.01, 0], "start_s": 0.1, "width_s": 0.2 } } })");
  run_to(scene, 0.2);
  EXPECT_NEAR(now(scene, {0.2, 0, 0}).y(), 0.01, 1e-5);  // the sine's peak
  run_to(scene, 0.4);
  EXPECT_NEAR(now(scene, {0.2, 0, 0}).y(), 0.0, 1e-5);
}

TEST(RegionRun, DelayedMotionWakesASleepingBody) {
  Scene scene = bar(std::string(kClamp) + R"(, { "name": "tip", "box": { "min_m": [0.15, -1, -1] },
      "motion": { "displacement_ramp": { "displacement_m": [0.002, 0, 0], "start_s": 2, "end_s": 2.5 } } })");
  run_to(scene, 1.9);
  EXPECT_TRUE(scene.world().bodies()[0].asleep);
  run_to(scene, 2.5);
  EXPECT_NEAR(now(scene, {0.2, 0, 0}).x() - 0.2, 0.002, 1e-5);
}

// A body that is moved as a whole keeps its velocity after the release.
TEST(RegionRun, KeepsItsVelocityWhenReleased) {
  Scene scene = bar(R"({ "name": "all", "box": {},
      "motion": { "constant_velocity": { "velocity_m_s": [0.5, 0, 0] } } })",
                    R"([ { "time_s": 1, "release_region": { "object": "bar", "region": "all" } } ])");
  run_to(scene, 1);
  EXPECT_NEAR(now(scene, {0, 0, 0}).x(), 0.5, 1e-4);
  run_to(scene, 2);
  EXPECT_NEAR(now(scene, {0, 0, 0}).x(), 1.0, 5e-3);
  EXPECT_NEAR(scene.world().energy().linear_momentum.y(), 4 * 0.5, 4 * 0.5 * 5e-3);
}

// Half of the bar has a density of 3000 kg/m3 in place of 1000.
TEST(RegionRun, RegionDensityChangesTheMass) {
  const Scene scene =
      bar(R"({ "name": "heavy", "box": { "min_m": [0, -1, -1] }, "material": { "density_kg_m3": 3000 } })");
  EXPECT_NEAR(scene.find("bar")->mass_kg, 8.0, 1e-3);
  for (const BodyState& body : scene.world().bodies()) EXPECT_NEAR(body.mass_kg, 8.0, 1e-3);
  // The centre of mass moves to (2 * -0.1 + 6 * 0.1) / 8 along x, which is the world's y axis.
  EXPECT_NEAR(scene.world().bodies()[0].world_from_body.position_m.y(), 2.05, 1e-4);
}

}  // namespace
}  // namespace livegs
