// SPDX-License-Identifier: Apache-2.0
// Runs the scenes of tests/scenes for a short time and compares them with closed forms.
#include <gtest/gtest.h>

#include "scene/build/fragile_object.h"
#include "scene/scene.h"
#include "scene/values/points_file.h"
#include "skin/skin_kernels.h"

namespace livegs {
namespace {

using Eigen::Vector3d;
namespace fs = std::filesystem;

// Sleep is off, because it may stop a slow oscillation before equilibrium.
Scene example(const std::string& name) {
  SceneOptions options;
  options.sleep = false;
  auto scene = Scene::load(fs::path(LIVEGS_TESTS_DIR) / "scenes" / (name + ".scene.json"), options);
  EXPECT_TRUE(scene) << scene.error().message;
  return std::move(*scene);
}

void run(Scene& scene, double seconds) {
  const auto ticks = static_cast<int>(std::lround(seconds * scene.world().settings().rate_hz));
  for (int tick = 0; tick < ticks; ++tick) scene.step();
}

// Two halves in series under the same stress: u = sigma L / E of each. With nu = 0 there is no other strain.
// The bar is 10 % of each part's strain.
TEST(ExampleScenes, TwoMaterialBarStretchesLikeSprings) {
  Scene scene = example("bar_in_tension");
  const SceneObject& bar = *scene.find("bar");
  const auto moved = [&](double x) { return scene.world().world_point(bar.id, {x, 0, 0}).x() - x; };
  run(scene, 1.5);
  const double clamp = moved(-0.175), middle = moved(0.025), end = moved(0.225);
  EXPECT_NEAR(clamp, 0.0, 1e-5);
  EXPECT_NEAR((middle - clamp) / 0.2, 500 / 1e5, 0.1 * 500 / 1e5);
  EXPECT_NEAR((end - middle) / 0.2, 500 / 2e5, 0.1 * 500 / 2e5);

  // After the release the load accelerates the bar: 500 Pa on 0.01 m2 for half a second is 2.5 N s.
  run(scene, 0.5);
  const Vector3d momentum = scene.world().energy().linear_momentum;
  EXPECT_NEAR(momentum.x(), 2.5, 0.025);
  EXPECT_NEAR(momentum.tail<2>().norm(), 0.0, 0.025);
}

// m sqrt(2 g H) (1 + e): the cup breaks at 0.9 N s. The upper fall gives 1.59 N s, the lower one 0.80 N s.
TEST(ExampleScenes, OnlyTheHigherCupBreaksByItself) {
  Scene scene = example("cup_breaks");
  const SceneObject& cup = *scene.find("cup");
  const SceneObject& lower = *scene.find("lower cup");
  const size_t kernels = cup.asset->size();
  ASSERT_TRUE(cup.fragility && cup.fragility->pieces > 8) << "the cup must be cut";
  EXPECT_NEAR(cup.fragility->drop_height_m, 0.9 * 0.9 / (0.36 * 0.36) / (2 * 9.81), 1e-6);
  run(scene, 0.6);
  EXPECT_GT(cup.fragility->bodies, 1u);
  EXPECT_EQ(lower.fragility->bodies, 1u);
  double impulse = 0;
  for (const WorldEvent& event : scene.world().take_events()) {
    if (event.kind == WorldEventKind::Fracture && impulse == 0) impulse = event.impulse_n_s;
  }
  EXPECT_NEAR(impulse, 0.3 * std::sqrt(2 * 9.81) * 1.2, 0.01 * 1.6);
  run(scene, 1.5);
  EXPECT_GT(lower.fragility->bodies, 1u);

  // Each kernel belongs to the new asset, or was split into parts of it. The runs list each kernel once.
  std::vector<int> parts(kernels, 0);
  for (const uint32_t source : cup.broken->source) {
    if (source < kernels) ++parts[source];
  }
  EXPECT_EQ(std::count(parts.begin(), parts.end(), 0), 0);
  size_t bound = 0;
  for (const RestBody::KernelRun& run : cup.rest.kernel_runs) bound += run.count;
  EXPECT_EQ(bound, cup.asset->size());
  EXPECT_EQ(cup.asset->size(), cup.broken->source.size());
  EXPECT_TRUE(bind_kernels(*cup.asset, cup.rest));
  double mass_kg = 0;
  for (const BodyState& body : scene.world().bodies()) mass_kg += body.object_id == cup.id ? body.mass_kg : 0;
  EXPECT_NEAR(mass_kg, 0.3, 1e-9);
}

// No forces act on the ball: its velocity, spin and energy are constant.
TEST(ExampleScenes, BallOfPointsKeepsItsVelocities) {
  Scene scene = example("spinning_ball");
  const SceneObject& ball = *scene.find("ball");
  const auto list = read_points_file(fs::path(LIVEGS_TESTS_DIR) / "scenes" / "spinning_ball.csv");
  ASSERT_TRUE(list);
  const size_t count = list->positions_m.size();
  const double mass_kg = 1000 * 1e-6 * static_cast<double>(count);  // density times cubes of 10 mm
  EXPECT_NEAR(ball.mass_kg, mass_kg, 1e-9);
  ASSERT_EQ(ball.asset->size(), count);  // one kernel per point, in the list's order
  for (size_t i = 0; i < count; ++i) {
    ASSERT_LT((ball.asset->positions[i].cast<double>() - list->positions_m[i]).norm(), 1e-6) << i;
  }
  const std::vector<ParticleState> start = scene.world().elastic_body(ball.id)->particles();
  ASSERT_EQ(start.size(), count);
  for (size_t i = 0; i < count; ++i) {
    ASSERT_LT((start[i].position_m - Vector3d(0, 1, 0) - list->positions_m[i]).norm(), 1e-7)
        << i;  // single precision about the body's centre
  }
  const BodyEnergy before = scene.world().energy();
  EXPECT_NEAR(before.linear_momentum.x(), 0.5 * mass_kg, 1e-7 * mass_kg);
  for (size_t i = 0; i < count; ++i) {
    const Vector3d expected_m_s = Vector3d(0.5, 0, 0) + Vector3d(0, 0, 4).cross(list->positions_m[i]);
    ASSERT_LT((start[i].velocity_m_s - expected_m_s).norm(), 1e-5) << i;
  }
  // A ball of points has the inertia of its points. The lattice has its mass at its nodes, farther out.
  double inertia = 0;
  for (const Vector3d& r : list->positions_m) inertia += 1e-3 * r.head<2>().squaredNorm();
  const auto spin = [&](const BodyEnergy& energy) {
    const Vector3d centre = scene.world().elastic_body(ball.id)->centre_pose().position_m;
    return (energy.angular_momentum - centre.cross(energy.linear_momentum)).eval();
  };
  EXPECT_NEAR(spin(before).z() / (4 * inertia), 1.0, 1e-6);

  const Vector3d spin_before = spin(before);
  run(scene, 1.0);
  const BodyEnergy after = scene.world().energy();
  EXPECT_LT((after.linear_momentum - before.linear_momentum).norm(), 1e-6 * before.linear_momentum.norm());
  EXPECT_LT((spin(after) - spin_before).norm(), 1e-6 * spin_before.norm());
  EXPECT_LT(after.kinetic_j + after.elastic_j, 1.01 * (before.kinetic_j + before.elastic_j));
  const Vector3d centre = scene.world().elastic_body(ball.id)->centre_pose().position_m;
  EXPECT_LT((centre - Vector3d(0.5, 1, 0)).norm(), 1e-6);
}

TEST(ExampleScenes, JointsHoldAndHandCarriesABox) {
  Scene scene = example("joints");
  const World& world = scene.world();
  const auto place = [&](const char* name) {
    return world.world_point(scene.find(name)->id, Vector3d::Zero());
  };
  double opened = 0.0, error_m = 0.0, error_rad = 0.0, highest = 0.0, farthest = 0.0;
  for (int tick = 0; tick < 240; ++tick) {
    scene.step();
    opened = std::max(opened, -place("door").z());
    highest = std::max(highest, place("box").y());
    farthest = std::max(farthest, (place("weight") - Vector3d(0, 2, 0)).norm());
    for (const JointState& joint : world.joints()) {
      error_m = std::max(error_m, joint.error_m);
      error_rad = std::max(error_rad, joint.error_rad);
    }
  }
  EXPECT_EQ(world.joints().size(), 6u);
  EXPECT_GT(opened, 0.1);  // the ball pushed the door open
  EXPECT_LT(error_m, 1e-3);
  EXPECT_LT(error_rad, 1e-3);
  // A weight of 10 kg on links of 0.1 kg falls from level and swings back. A slack chain is closer than its
  // length to its anchor, never farther.
  EXPECT_LT(farthest, 0.7 + 1e-3);
  EXPECT_GT(farthest, 0.699);
  // The hand lifted the box by its top to 0.6 m, rotated it and put it down at x = 0.6.
  EXPECT_NEAR(highest, 0.5, 0.03);
  EXPECT_LT((place("box") - Vector3d(0.6, 0.1, 0.6)).norm(), 0.03);
}

}  // namespace
}  // namespace livegs
