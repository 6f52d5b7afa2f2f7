// SPDX-License-Identifier: Apache-2.0
// Bodies on a device compared with the same bodies on the CPU. The accuracy on the device is tested by
// elastic_on_device_test, the passes by device_pass_test.
#include "device/device_elastic.h"

#include <algorithm>
#include <cmath>

#include "common/compute/backends.h"
#include "geometry/field/sample_particles.h"
#include "geometry/surface/shape_mesh.h"
#include "physics/world.h"
#include "scenes/elastic_bodies.h"

namespace livegs::test {
namespace {

using DeviceElasticBackend = OnEveryBackend;
INSTANTIATE_TEST_SUITE_P(Backend, DeviceElasticBackend, ::testing::Values("cpu", "vulkan"), backend_name);

// Sets the device of the process for its lifetime.
struct Using {
  explicit Using(Backend& backend) : device(std::make_shared<DeviceElastic>(backend)) {
    set_elastic_device(device);
  }
  ~Using() { set_elastic_device(nullptr); }
  std::shared_ptr<DeviceElastic> device;
};

struct Case {
  const char* name;
  Stage stage;
  int ticks;
  double bound_m;  // of a node after these ticks
};

Stage stage_of(ElasticBodyDescription body, const Vector3d& gravity) {
  Stage stage;
  stage.rate_hz = 90.0;
  stage.gravity_m_s2 = gravity;
  stage.make(body);
  return stage;
}

ElasticBodyDescription tilted_box() {
  ElasticBodyDescription body = describe(sample_particles(box_mesh({0.13, 0.09, 0.11})), 3e4, 0.35);
  body.material.loss_factor = 0.1;
  body.world_from_object = {{3.0, 0.2, -2.0},
                            Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()))};
  body.velocity_m_s = {1.0, -1.0, 0.5};
  body.angular_velocity_rad_s = {3.0, -2.0, 5.0};
  return body;
}

// A tilted box that spins and flies; one that lands on a floor, a box or a sphere; a held, sagging bar; a
// pulled bar. The bound of one tick is rounding: positions of 0.1 m have steps of 7e-9 m, which the steps of
// a tick add up and contact multiplies.
std::vector<Case> cases() {
  std::vector<Case> all;
  all.push_back({"flight", stage_of(tilted_box(), kGravity), 1, 2e-7});
  {
    Case& one = all.emplace_back(Case{"a floor", stage_of(tilted_box(), kGravity), 1, 1e-6});
    one.stage.add_floor();
    one.stage.colliders[0].world_from_collider.position_m.y() = 0.13;
  }
  {
    Case& one = all.emplace_back(Case{"a box", stage_of(tilted_box(), kGravity), 1, 1e-6});
    Collider box;
    box.shape = BoxShape{.size_m = {0.3, 0.2, 0.3}};
    box.world_from_collider.position_m = {3.0, 0.02, -2.0};
    one.stage.colliders.push_back(box);
  }
  {
    Case& one = all.emplace_back(Case{"a sphere", stage_of(tilted_box(), kGravity), 1, 1e-6});
    Collider sphere;
    sphere.shape = SphereShape{.radius_m = 0.1};
    sphere.world_from_collider.position_m = {3.02, 0.03, -2.0};
    one.stage.colliders.push_back(sphere);
  }
  {
    ElasticBodyDescription bar = describe_bar(1e5, 0.3, 0.025);
    bar.regions.push_back(fixed_box({-1, -1, -1}, {-0.15, 1, 1}));
    all.push_back({"a held bar", stage_of(bar, kGravity), 1, 2e-7});
  }
  {
    Case& one =
        all.emplace_back(Case{"a pulled bar", stage_of(describe_bar(1e5, 0.3, 0.025), kNoGravity), 1, 2e-7});
    add_end_traction(one.stage.forces, 0.5 * kBarLength_m, 500.0);
    add_end_traction(one.stage.forces, -0.5 * kBarLength_m, -500.0);
  }
  return all;
}

double furthest_m(const ElasticBody& a, const ElasticBody& b) {
  const auto of_a = a.particles(), of_b = b.particles();
  double furthest = 0.0;
  for (size_t i = 0; i < of_a.size(); ++i)
    furthest = std::max(furthest, (of_a[i].position_m - of_b[i].position_m).norm());
  return furthest;
}

TEST_P(DeviceElasticBackend, TicksMatchTheSolver) {
  std::vector<Case> on_cpu = cases(), here = cases();
  for (size_t i = 0; i < here.size(); ++i) {
    SCOPED_TRACE(here[i].name);
    // Some ticks before, on the CPU for both, so that the body is in motion and in contact.
    for (int tick = 0; tick < 6; ++tick) {
      on_cpu[i].stage.frame();
      here[i].stage.frame();
    }
    ASSERT_EQ(furthest_m(*on_cpu[i].stage.body, *here[i].stage.body), 0.0);
    Using use(*backend_);
    for (int tick = 0; tick < here[i].ticks; ++tick) {
      ASSERT_TRUE(here[i].stage.frame_on_device());
      here[i].stage.body->end_frame(1.0 / here[i].stage.rate_hz);
    }
    set_elastic_device(nullptr);
    for (int tick = 0; tick < here[i].ticks; ++tick) on_cpu[i].stage.frame();
    EXPECT_LT(furthest_m(*on_cpu[i].stage.body, *here[i].stage.body), here[i].bound_m);
    EXPECT_GT(furthest_m(*on_cpu[i].stage.body, *cases()[i].stage.body), 1e-4);  // it has moved
    const BodyEnergy a = on_cpu[i].stage.body->energy(kGravity), b = here[i].stage.body->energy(kGravity);
    EXPECT_LT((a.linear_momentum - b.linear_momentum).norm(), 1e-4);
    EXPECT_LT((a.angular_momentum - b.angular_momentum).norm(), 1e-4);
  }
}

TEST_P(DeviceElasticBackend, TwoRunsHaveTheSameBits) {
  const auto run = [&] {
    std::vector<Case> all = cases();
    Using use(*backend_);
    std::vector<double> places;
    for (Case& one : all) {
      for (int tick = 0; tick < 12; ++tick) one.stage.frame();
      for (const ParticleState& particle : one.stage.body->particles())
        places.insert(places.end(), particle.position_m.data(), particle.position_m.data() + 3);
    }
    EXPECT_GT(use.device->counts().body_ticks, 40u);
    return places;
  };
  EXPECT_EQ(run(), run());
}

// Bodies on one device do not depend on each other, whatever steps they take.
TEST_P(DeviceElasticBackend, ManyBodiesMoveAsOne) {
  std::vector<Case> together = cases(), alone = cases();
  Using use(*backend_);
  for (int tick = 0; tick < 8; ++tick) {
    // One call with all bodies whose tick and colliders are those of the second case.
    std::vector<DeviceBody> bodies;
    FlatTick all;
    all.duration_s = 1.0 / 90.0;
    all.start_s = tick * all.duration_s;
    all.substeps = 4;
    all.gravity_m_s2 = kGravity;
    all.colliders = together[1].stage.colliders;
    for (Case& one : together) bodies.push_back({dynamic_cast<FlatBody*>(one.stage.body.get()), {}});
    use.device->step(bodies, all);
    for (size_t i = 0; i < bodies.size(); ++i) {
      ASSERT_EQ(bodies[i].reason, nullptr);
      together[i].stage.body->end_frame(all.duration_s);
    }
  }
  for (size_t i = 0; i < alone.size(); ++i) {
    Stage& stage = alone[i].stage;
    stage.colliders = together[1].stage.colliders;
    stage.gravity_m_s2 = kGravity;
    stage.forces.clear();
    for (int tick = 0; tick < 8; ++tick) {
      ASSERT_TRUE(stage.frame_on_device());
      stage.body->end_frame(1.0 / 90.0);
    }
    EXPECT_EQ(furthest_m(*stage.body, *together[i].stage.body), 0.0) << alone[i].name;
  }
}

// Two hundred boxes slide on a floor, one of them under a ball. All but that one are stepped on the device.
// They are too slow for impact steps, which the device chooses once a tick and the CPU in every substep.
TEST_P(DeviceElasticBackend, WorldOfManyBodiesMovesAsOnTheCpu) {
  const auto make_world = [] {
    World world(WorldSettings{});
    Collider floor;
    floor.shape = PlaneShape{};
    world.add_collider(floor);
    ElasticBodyDescription box = describe(particle_grid({0.06, 0.04, 0.05}, 0.01), 2e4, 0.3, 0.02);
    for (uint32_t i = 0; i < 200; ++i) {
      box.object_id = i + 1;
      box.world_from_object.position_m = {0.2 * (i % 20), 0.02 + 0.0001 * (i % 7), 0.2 * (i / 20)};
      box.velocity_m_s = {0.1, 0.0, 0.0};
      EXPECT_TRUE(world.add_elastic(box));
    }
    BallDescription ball;
    ball.object_id = 300;
    ball.position_m = {0.0, 0.09, 0.0};
    EXPECT_TRUE(world.add_ball(ball));
    return world;
  };
  World on_cpu = make_world(), here = make_world();
  constexpr int kTicks = 4;
  {
    Using use(*backend_);
    for (int tick = 0; tick < kTicks; ++tick) here.step();
    EXPECT_GE(use.device->counts().body_ticks, 190u * kTicks);
    EXPECT_LT(use.device->counts().body_ticks, 200u * kTicks);
    EXPECT_EQ(use.device->counts().lattice_uploads, 1u);
  }
  for (int tick = 0; tick < kTicks; ++tick) on_cpu.step();
  for (uint32_t id = 1; id <= 200; ++id) {
    ASSERT_LT(furthest_m(*on_cpu.elastic_body(id), *here.elastic_body(id)), 2e-5) << id;
    ASSERT_NEAR(on_cpu.elastic_body(id)->velocity_m_s().y(), here.elastic_body(id)->velocity_m_s().y(), 1e-2);
  }
}

// A backend that is lost after some dispatches.
class LostBackend final : public Backend {
 public:
  explicit LostBackend(int dispatches) : left_(dispatches) {}
  Result<BufferId> create_buffer(size_t bytes) override { return cpu_.create_buffer(bytes); }
  Result<void> destroy_buffer(BufferId id) override { return cpu_.destroy_buffer(id); }
  Result<void> upload(BufferId id, std::span<const std::byte> bytes) override {
    return cpu_.upload(id, bytes);
  }
  Result<void> dispatch(const Pass& pass, std::span<const BufferId> ids, std::span<const std::byte> constants,
                        uint32_t count) override {
    if (left_-- <= 0) return Error{ErrorCode::Unavailable, "the device is lost"};
    return cpu_.dispatch(pass, ids, constants, count);
  }
  Result<void> submit() override { return {}; }
  Result<void> read(BufferId id, std::span<std::byte> bytes) override { return cpu_.read(id, bytes); }

 private:
  CpuBackend cpu_;
  int left_;
};

TEST(DeviceElastic, LostDeviceLosesNothing) {
  Stage on_cpu = stage_of(tilted_box(), kGravity), here = stage_of(tilted_box(), kGravity);
  LostBackend backend(60);
  Using use(backend);
  ASSERT_FALSE(here.frame_on_device());  // lost in the middle of the tick
  EXPECT_EQ(use.device->failure(), "the device is lost");
  for (int tick = 0; tick < 5; ++tick) here.frame();
  set_elastic_device(nullptr);
  for (int tick = 0; tick < 5; ++tick) on_cpu.frame();
  EXPECT_EQ(furthest_m(*on_cpu.body, *here.body), 0.0);
}

TEST(DeviceElastic, BodiesThatItCannotTakeStayAsTheyAre) {
  CpuBackend cpu;
  Using use(cpu);
  const auto reason_of = [&](Stage& stage) -> std::string {
    FlatTick tick;
    tick.duration_s = 1.0 / stage.rate_hz;
    tick.substeps = stage.substeps;
    tick.gravity_m_s2 = stage.gravity_m_s2;
    tick.colliders = stage.colliders;
    DeviceBody one{dynamic_cast<FlatBody*>(stage.body.get()), stage.forces};
    use.device->step({&one, 1}, tick);
    return one.reason ? one.reason : "";
  };
  Stage thin = stage_of(describe(sample_particles(box_mesh({0.3, 0.003, 0.3})), 1e6, 0.3), kGravity);
  EXPECT_EQ(reason_of(thin), "it has sheets or cords thinner than a cell");
  ElasticBodyDescription round = describe(sample_particles(sphere_mesh(0.05, 3)), 1e5, 0.3);
  round.cells.thin = false;
  Stage ball = stage_of(round, kGravity);
  EXPECT_EQ(reason_of(ball), "");
  ball.add_floor();
  EXPECT_EQ(reason_of(ball), "its surface is curved and something is near");
  Stage pulled = stage_of(tilted_box(), kGravity);
  PointSpring spring;
  pulled.forces.push_back({Vector3d::Zero(), Vector3d::Zero(), &spring});
  EXPECT_EQ(reason_of(pulled), "a hand holds it");
}

}  // namespace
}  // namespace livegs::test
