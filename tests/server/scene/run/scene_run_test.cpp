// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gaussian/asset_file.h"
#include "sample/sample_scene.h"
#include "scene/scene.h"
#include "scene/views/scene_drawing.h"
#include "scratch_folder.h"
#include "splat/frame_bounds.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

// A soft cube, a rigid cube and points above a floor, with a force, a ball and a change of material.
Scene busy_scene() {
  ScratchFolder folder;
  std::string points = "x,y,z\n";
  for (int i = 0; i < 216; ++i) {
    points += std::to_string(0.02 * (i % 6)) + "," + std::to_string(0.02 * (i / 6 % 6)) + "," +
              std::to_string(0.02 * (i / 36)) + "\n";
  }
  folder.write("points.csv", points);
  const auto path = folder.write("busy.scene.json", R"({
    "rate_hz": 60, "substeps": 4,
    "environment": { "colliders": [ { "plane": {} , "friction": 0.5 } ] },
    "objects": [
      { "name": "soft", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0, 0.3, 0] },
        "physics": { "behavior": "ELASTIC", "density_kg_m3": 500, "youngs_modulus_pa": 2e4, "friction": 0.6 } },
      { "name": "hard", "shape": { "box": { "size_m": [0.1, 0.1, 0.1] } }, "pose": { "position_m": [0.5, 0.2, 0] },
        "physics": { "behavior": "RIGID", "mass_kg": 0.5 } },
      { "name": "dots", "points": "points.csv", "pose": { "position_m": [-0.5, 0.1, 0] },
        "physics": { "behavior": "ELASTIC", "density_kg_m3": 200, "youngs_modulus_pa": 1e4 } } ],
    "events": [
      { "time_s": 0.2, "force": { "object": "soft", "point_m": [0, 0.1, 0], "force_n": [6, 0, 0], "duration_s": 0.2 } },
      { "time_s": 0.3, "ball": { "from_m": [0, 0.1, 1], "velocity_m_s": [0, 0, -5] } },
      { "time_s": 0.4, "set_physics": { "object": "soft", "physics": { "friction": 0.1 } } } ] })");
  auto scene = Scene::load(path, {});
  EXPECT_TRUE(scene) << scene.error().message;
  return std::move(*scene);
}

TEST(SceneRun, EventsTakeEffectOnTime) {
  Scene scene = busy_scene();
  const uint32_t soft = scene.find("soft")->id;
  EXPECT_NEAR(scene.find("soft")->mass_kg, 500 * 0.008, 1e-12);  // density times the volume of the box
  for (int tick = 0; tick < 18; ++tick) scene.step();            // up to 0.3 s, where tick 18 starts
  EXPECT_EQ(scene.objects().size(), 4u);                         // drawn floor and three objects
  EXPECT_EQ(scene.world().material(soft)->friction, 0.6);        // the initial value until 0.4 s
  scene.step();
  EXPECT_EQ(scene.objects().size(), 5u);
  EXPECT_EQ(scene.take_changes().added.size(), 1u);
  for (int tick = 19; tick < 24; ++tick) scene.step();
  EXPECT_EQ(scene.world().material(soft)->friction, 0.6);
  scene.step();
  EXPECT_EQ(scene.world().material(soft)->friction, 0.1);
  EXPECT_EQ(scene.find("soft")->physics.friction().source(), v1::EstimatedValue::SCENE);
}

// Compares a ball of a scene event with a ball of a hand; both use shoot_ball.
TEST(SceneRun, BallsOfEventsAndHandsAreEqual) {
  Scene scene = busy_scene();
  const uint32_t one = scene.shoot_ball({0, 1, 2}, {0, 0, -3}).id;
  (void)scene.take_changes();
  for (int tick = 0; tick < 30; ++tick) scene.step();  // the event's ball, at 0.3 s
  const Scene::Changes changes = scene.take_changes();
  ASSERT_EQ(changes.added.size(), 1u);
  const uint32_t other = changes.added[0];
  const World& world = scene.world();
  const auto mass_kg = [&](uint32_t id) {
    for (const BodyState& body : world.bodies()) {
      if (body.object_id == id) return body.mass_kg;
    }
    return 0.0;
  };
  EXPECT_EQ(mass_kg(one), 0.1);
  EXPECT_EQ(mass_kg(other), 0.1);
  EXPECT_EQ(world.material(one)->friction, world.material(other)->friction);
  EXPECT_EQ(world.material(one)->restitution, world.material(other)->restitution);
  EXPECT_EQ(scene.find(one)->asset, scene.find(other)->asset);  // the same kernels, so the same radius
  EXPECT_EQ(scene.find(one)->physics.SerializeAsString(), scene.find(other)->physics.SerializeAsString());
}

TEST(SceneRun, RemovesTheOldestBallAtTheLimit) {
  Scene scene = busy_scene();
  (void)scene.take_changes();
  std::vector<uint32_t> ids;
  for (size_t i = 0; i < Scene::kMaxBalls + 3; ++i) {
    ids.push_back(scene.shoot_ball({0.0, 1.0 + 0.2 * static_cast<double>(i), 2.0}, {0, 0, -1}).id);
  }
  const Scene::Changes changes = scene.take_changes();
  EXPECT_EQ(changes.added.size(), Scene::kMaxBalls + 3);
  EXPECT_EQ(changes.removed, (std::vector<uint32_t>{ids[0], ids[1], ids[2]}));
  EXPECT_EQ(scene.find(ids[0]), nullptr);
  EXPECT_NE(scene.find(ids[3]), nullptr);
  scene.step();
}

// A soft box of 4 kg and 10 kPa that gets these parameters in the first tick.
v1::Scene soft_box_that_becomes(const v1::Physics& changed) {
  v1::Scene file;
  v1::Object& object = *file.add_objects();
  object.set_name("soft");
  for (int d = 0; d < 3; ++d) object.mutable_shape()->mutable_box()->add_size_m(0.2);
  object.mutable_physics()->set_behavior(v1::Physics::ELASTIC);
  object.mutable_physics()->set_density_kg_m3(500);
  object.mutable_physics()->set_youngs_modulus_pa(1e4);
  v1::Event& event = *file.add_events();
  event.mutable_set_physics()->set_object("soft");
  *event.mutable_set_physics()->mutable_physics() = changed;
  return file;
}

// The reported values of a body follow a change of its parameters.
TEST(SceneRun, PhysicsChangesUpdateTheReport) {
  v1::Physics changed;
  changed.set_youngs_modulus_pa(4e4);
  changed.set_mass_kg(2);
  auto scene = Scene::build(soft_box_that_becomes(changed), "", "soft", {});
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->objects()[0].elastic->youngs_modulus_pa, 1e4);
  EXPECT_NEAR(scene->objects()[0].mass_kg, 4.0, 1e-9);
  scene->step();
  EXPECT_EQ(scene->objects()[0].elastic->youngs_modulus_pa, 4e4);
  EXPECT_NEAR(scene->objects()[0].mass_kg, 2.0, 1e-9);
}

// Parameters of the paper that change at run time: plasticity, and a deformation resistance as the equivalent
// modulus.
TEST(SceneRun, PlasticityAndResistanceChangeTheBody) {
  v1::Physics changed;
  changed.set_plasticity(0.7);
  changed.set_deformation_resistance(0.3);
  auto scene = Scene::build(soft_box_that_becomes(changed), "", "soft", {});
  ASSERT_TRUE(scene) << scene.error().message;
  const uint32_t id = scene->objects()[0].id;
  EXPECT_NE(scene->world().material(id)->plasticity, 0.7);
  scene->step();
  EXPECT_EQ(scene->world().material(id)->plasticity, 0.7);
  const Material& material = *scene->world().material(id);
  EXPECT_NEAR(material.structure_coefficient * material.youngs_modulus_pa, effective_youngs_modulus_pa(0.3),
              1e-6 * effective_youngs_modulus_pa(0.3));
}

TEST(SceneRun, PointsHaveOneKernelEachByDefault) {
  ScratchFolder folder;
  std::string points = "x,y,z,vx,vy,vz\n";
  for (int i = 0; i < 216; ++i) {
    points += std::to_string(0.02 * (i % 6)) + "," + std::to_string(0.02 * (i / 6 % 6)) + "," +
              std::to_string(0.02 * (i / 36)) + ",0,0,1\n";
  }
  folder.write("points.csv", points);
  const auto load = [&](const std::string& more, const char* behavior) {
    return Scene::load(folder.write("points.scene.json", R"({ "objects": [ { "points": "points.csv", )" +
                                                             more + R"("physics": { "behavior": ")" +
                                                             behavior + R"(", "density_kg_m3": 500 } } ] })"),
                       {});
  };
  for (const char* more : {"", R"("kernel_per_point": true, )"}) {
    const auto scene = load(more, "ELASTIC");
    ASSERT_TRUE(scene) << scene.error().message;
    const GaussianAsset& asset = *scene->objects()[0].asset;
    ASSERT_EQ(asset.size(), 216u);
    for (size_t i = 0; i < 216; ++i) {
      EXPECT_NEAR(asset.positions[i].y(), 0.02 * static_cast<double>(i / 6 % 6), 1e-6);
      EXPECT_EQ(asset.log_scales[i], Eigen::Vector3f::Constant(asset.log_scales[0].x()));  // isotropic
    }
    EXPECT_NEAR(scene->objects()[0].mass_kg, 500 * 216 * 8e-6, 1e-9);
  }
  const auto surface = load(R"("kernel_per_point": false, )", "ELASTIC");
  ASSERT_TRUE(surface) << surface.error().message;
  EXPECT_EQ(surface->objects()[0].asset->size(), 6000u);  // the kernel count of a shape

  // A body that cannot deform cannot have velocities of single points.
  const auto rigid = load("", "RIGID");
  ASSERT_FALSE(rigid);
  EXPECT_NE(rigid.error().message.find(
                "object \"points\": objects[0].points: have velocities, which are only for elastic"),
            std::string::npos)
      << rigid.error().message;
}

// Both skinnings show the same motion. For a smooth deformation their pictures differ only slightly.
TEST(SceneRun, BothSkinningsDrawTheSameBody) {
  Scene scene = busy_scene();
  for (int tick = 0; tick < 30; ++tick) scene.step();
  const Camera camera = frame_bounds(scene.bounds_m(), 160, 120);
  Rasteriser rasteriser;
  RasterisedView lattice, paper;
  SceneDrawing by_lattice(Skinning::Lattice), by_paper(Skinning::LivegsV1);
  Scene fresh = busy_scene();  // bindings are made at rest
  ASSERT_TRUE(by_paper.pose(fresh));
  auto drawn = by_lattice.pose(scene);
  ASSERT_TRUE(drawn) << drawn.error().message;
  rasteriser.draw(*drawn, camera, {}, lattice);
  auto drawn_paper = by_paper.pose(scene);
  ASSERT_TRUE(drawn_paper) << drawn_paper.error().message;
  rasteriser.draw(*drawn_paper, camera, {}, paper);
  EXPECT_GT(psnr_db(lattice.image, paper.image), 22.0);
}

TEST(SceneRun, FloorSupportsAllObjects) {
  Scene scene = busy_scene();
  for (int tick = 0; tick < 180; ++tick) scene.step();
  for (const BodyState& body : scene.world().bodies()) {
    const SceneObject* object = scene.find(body.object_id);
    if (object->environment) continue;
    EXPECT_TRUE(body.world_from_body.position_m.allFinite());
    EXPECT_GT(body.world_from_body.position_m.y(), 0.02) << object->name;
  }
}

// A ray lifts an object by its centre and holds it there. The object hangs below the target by its weight
// over the spring's stiffness, g / (2 pi 3 Hz)^2 = 27.6 mm for any mass. It falls when the path ends.
TEST(SceneRun, PullHoldsUntilItsPathEnds) {
  ScratchFolder folder;
  folder.write("up.csv", "time_s,x,y,z\n0,0,0.05,0\n1,0,0.6,0\n4,0,0.6,0\n");
  for (const char* physics : {R"("RIGID", "mass_kg": 0.4)", R"("RIGID", "mass_kg": 4)",
                              R"("ELASTIC", "density_kg_m3": 300, "youngs_modulus_pa": 1e5)"}) {
    const auto path = folder.write("pull.scene.json", std::string(R"({
      "environment": { "colliders": [ { "plane": {} } ] },
      "objects": [ { "name": "thing", "shape": { "box": { "size_m": [0.1, 0.1, 0.1] } }, "pose": { "position_m": [0, 0.05, 0] },
                     "physics": { "behavior": )") + physics +
                                                          R"( } } ],
      "events": [ { "time_s": 0, "pull": { "object": "thing", "path": "up.csv" } } ] })");
    auto scene = Scene::load(path, {});
    ASSERT_TRUE(scene) << scene.error().message;
    const uint32_t id = scene->find("thing")->id;
    const auto height_m = [&] { return scene->world().world_point(id, Eigen::Vector3d::Zero()).y(); };
    for (int tick = 0; tick < 350; ++tick) scene->step();
    const double below_m = 9.81 / std::pow(2 * M_PI * 3, 2);
    EXPECT_NEAR(height_m(), 0.6 - below_m, 1e-3) << physics;
    for (int tick = 0; tick < 30; ++tick) scene->step();
    EXPECT_LT(height_m(), 0.5) << physics;
  }
}

// A gram of foam, pushed by 100 kN for a fifth of a second.
TEST(SceneRun, ResetAfterDivergenceIsReported) {
  ScratchFolder folder;
  const auto path = folder.write("lost.scene.json", R"({
    "gravity_m_s2": [0, 0, 0],
    "objects": [ { "name": "foam", "shape": { "box": { "size_m": [0.1, 0.1, 0.1] } },
                   "physics": { "behavior": "ELASTIC", "density_kg_m3": 1, "youngs_modulus_pa": 1e3 } } ],
    "events": [ { "time_s": 0.1, "force": { "object": "foam", "point_m": [0, 0, 0], "force_n": [1e5, 0, 0], "duration_s": 0.2 } } ] })");
  auto scene = Scene::load(path, {});
  ASSERT_TRUE(scene) << scene.error().message;
  const SceneObject& foam = scene->objects().front();
  int reports = 0;
  std::string warnings;
  for (int i = 0; i < 60; ++i) {
    scene->step();
    const Scene::Changes changes = scene->take_changes();
    reports += static_cast<int>(std::count(changes.changed.begin(), changes.changed.end(), foam.id));
    for (const std::string& warning : foam.all_warnings()) warnings = warning;
  }
  EXPECT_GE(reports, 1);
  EXPECT_LE(reports, 3);
  EXPECT_NE(warnings.find("simulation diverged"), std::string::npos) << warnings;
}

// The brim of the sample hat flutters on the floor by some tenths of a millimetre. That is no motion to
// watch.
TEST(SceneRun, TheSampleHatComesToRest) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_asset(folder.path() / "hat.ply", make_felt_hat()));
  const auto path = folder.write("hat.scene.json", R"({
    "rate_hz": 90, "substeps": 4,
    "environment": { "colliders": [ { "plane": {}, "friction": 0.6 } ] },
    "objects": [ { "name": "hat", "asset": "hat.ply", "scale": 1, "spacing_m": 0.014,
                   "pose": { "position_m": [-0.42, 0.3, 0.12] } } ] })");
  auto scene = Scene::load(path, {});
  ASSERT_TRUE(scene) << scene.error().message;
  const ElasticBody* hat = scene->world().elastic_body(scene->find("hat")->id);
  ASSERT_TRUE(hat);
  for (int tick = 0; tick < 3 * 90 && !hat->asleep(); ++tick) scene->step();
  EXPECT_TRUE(hat->asleep());
  EXPECT_GT(hat->centre_m().y(), 0.02);
}

}  // namespace
}  // namespace livegs
