// SPDX-License-Identifier: Apache-2.0
// Fragile objects in scene files: number of pieces, later changes of fragility, and hollow objects.
#include <gtest/gtest.h>

#include <chrono>

#include "geometry/fracture/piece_kernels.h"
#include "scene/build/fragile_object.h"
#include "scene/scene.h"

namespace livegs {
namespace {

// One object 0.5 m above a floor.
v1::Scene one_object(const v1::Physics& physics, bool ball) {
  v1::Scene file;
  file.mutable_environment()->add_colliders()->mutable_plane();
  v1::Object& object = *file.add_objects();
  object.set_name("thing");
  if (ball) {
    object.mutable_shape()->mutable_sphere()->set_radius_m(0.05);
  } else {
    for (const double edge : {0.1, 0.12, 0.08}) object.mutable_shape()->mutable_box()->add_size_m(edge);
  }
  for (const double value : {0.0, 0.5, 0.0}) object.mutable_pose()->add_position_m(value);
  *object.mutable_physics() = physics;
  return file;
}

v1::Physics fragile(unsigned pieces) {
  v1::Physics physics;
  physics.set_behavior(v1::Physics::RIGID);
  physics.set_fill(v1::Physics::SOLID);
  physics.set_mass_kg(0.5);
  physics.set_fragile(true);
  physics.set_break_impulse_n_s(0.2);
  if (pieces > 0) physics.set_fracture_pieces(pieces);
  return physics;
}

uint32_t pieces_of(const v1::Physics& physics) {
  const auto scene = Scene::build(one_object(physics, false), "", "one", {});
  EXPECT_TRUE(scene) << scene.error().message;
  return scene ? scene->find("thing")->fragility->pieces : 0;
}

TEST(FragileScene, CutsIntoTheRequestedNumberOfPieces) {
  EXPECT_EQ(pieces_of(fragile(0)), 32u);
  EXPECT_EQ(pieces_of(fragile(5)), 5u);
  EXPECT_EQ(pieces_of(fragile(64)), 64u);
}

TEST(FragileScene, RefusesANumberOfPiecesOutOfRange) {
  for (const unsigned pieces : {0u, 1u, 65u}) {
    v1::Physics physics = fragile(0);
    physics.set_fracture_pieces(pieces);
    const auto scene = Scene::build(one_object(physics, false), "", "one", {});
    ASSERT_FALSE(scene) << pieces;
    EXPECT_NE(scene.error().message.find("physics.fracture_pieces"), std::string::npos)
        << scene.error().message;
    EXPECT_NE(scene.error().message.find("2 and 64"), std::string::npos) << scene.error().message;
  }
}

v1::Scene made_fragile_later() {
  v1::Physics tough = fragile(0);
  tough.set_fragile(false);
  v1::Scene file = one_object(tough, false);
  v1::Event& event = *file.add_events();
  event.set_time_s(0.05);
  event.mutable_set_physics()->set_object("thing");
  event.mutable_set_physics()->mutable_physics()->set_fragile(true);
  event.mutable_set_physics()->mutable_physics()->set_break_impulse_n_s(0.2);
  event.mutable_set_physics()->mutable_physics()->set_fracture_pieces(12);
  return file;
}

TEST(FragileScene, BreaksOnLandingAfterBecomingFragile) {
  auto scene = Scene::build(made_fragile_later(), "", "later", {});
  ASSERT_TRUE(scene) << scene.error().message;
  const SceneObject& thing = *scene->find("thing");
  EXPECT_FALSE(thing.fragility);
  for (int tick = 0; tick < 60; ++tick) scene->step();
  ASSERT_TRUE(thing.fragility);
  EXPECT_EQ(thing.fragility->pieces, 12u);
  EXPECT_GT(thing.fragility->bodies, 1u);
  ASSERT_TRUE(thing.broken);
  EXPECT_EQ(thing.asset, thing.broken->asset);
}

// Covers a manual edit in the window and an answer that arrives during the run: neither waits for a reload.
TEST(FragileScene, EditsMakeAFallingObjectBreakable) {
  v1::Physics tough = fragile(0);
  tough.set_fragile(false);
  auto scene = Scene::build(one_object(tough, false), "", "edited", {});
  ASSERT_TRUE(scene) << scene.error().message;
  for (int tick = 0; tick < 5; ++tick) scene->step();
  const SceneObject& thing = *scene->find("thing");
  v1::PhysicalParameters edited = thing.physics;
  edited.set_fragile(true);
  edited.mutable_break_impulse_n_s()->set_best(0.2);
  const auto later = scene->set_physics(thing.id, edited);
  ASSERT_TRUE(later) << later.error().message;
  EXPECT_TRUE(later->empty()) << later->front();
  for (int tick = 0; tick < 60; ++tick) scene->step();
  ASSERT_TRUE(thing.fragility);
  EXPECT_GT(thing.fragility->bodies, 1u);
}

// An analysis that classifies the object as tough gives no break impulse. The pieces exist, so the object
// keeps its old break impulse.
TEST(FragileScene, KeepsItsBreakImpulseWhenMadeTough) {
  auto scene = Scene::build(one_object(fragile(8), false), "", "tough", {});
  ASSERT_TRUE(scene) << scene.error().message;
  const SceneObject& thing = *scene->find("thing");
  v1::PhysicalParameters tough = thing.physics;
  tough.set_fragile(false);
  tough.clear_break_impulse_n_s();
  const auto set = scene->set_physics(thing.id, tough);
  ASSERT_TRUE(set) << set.error().message;
  EXPECT_EQ(scene->world().material(thing.id)->break_impulse_n_s, 0.2);
  for (int tick = 0; tick < 60; ++tick) scene->step();
  EXPECT_EQ(scene->world().revision(thing.id), 0u);
  EXPECT_TRUE(scene->world().break_object(thing.id, {0.04, 0, 0}));
}

TEST(FragileScene, CutFacesHaveTheInteriorColour) {
  const Eigen::Vector3f interior_rgb(0.8f, 0.3f, 0.1f);
  const auto off = [&](const SceneObject& thing) {
    float most = 0;
    size_t inside = 0;
    for (size_t k = 0; k < thing.broken->source.size(); ++k) {
      if (thing.broken->source[k] != kInteriorKernel) continue;
      ++inside;
      const Eigen::Vector3f rgb = (0.5f + 0.28209479f * thing.broken->asset->sh_dc[k].array()).matrix();
      most = std::max(most, (rgb - interior_rgb).cwiseAbs().maxCoeff());
    }
    EXPECT_GT(inside, 100u);
    return most;
  };
  v1::Physics physics = fragile(8);
  v1::Event recoloured;
  recoloured.mutable_set_physics()->set_object("thing");
  for (const float part : interior_rgb)
    recoloured.mutable_set_physics()->mutable_physics()->add_interior_rgb(part);
  v1::Scene file = one_object(physics, false);
  recoloured.set_time_s(0.05);
  *file.add_events() = recoloured;
  auto scene = Scene::build(file, "", "colour", {});
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_GT(off(*scene->find("thing")), 0.05f);  // the colour of the nearby surface
  for (int tick = 0; tick < 6; ++tick) scene->step();
  EXPECT_LT(off(*scene->find("thing")), 1e-6f);

  physics.add_interior_rgb(0.5);
  EXPECT_FALSE(Scene::build(one_object(physics, false), "", "colour", {}));
  physics.add_interior_rgb(0.5);
  physics.add_interior_rgb(1.5);
  const auto refused = Scene::build(one_object(physics, false), "", "colour", {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("interior_rgb"), std::string::npos) << refused.error().message;
}

TEST(FragileScene, LiveScenesCutInTheBackground) {
  SceneOptions options;
  options.wait_for_pieces = false;
  auto scene = Scene::build(made_fragile_later(), "", "later", options);
  ASSERT_TRUE(scene) << scene.error().message;
  const SceneObject& thing = *scene->find("thing");
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!thing.broken && std::chrono::steady_clock::now() < until) scene->step();
  ASSERT_TRUE(thing.broken) << "cut within a minute";
  const auto broken = scene->world().break_object(thing.id, {0.05, 0, 0});
  ASSERT_TRUE(broken) << broken.error().message;
  scene->step();
  EXPECT_GT(thing.fragility->bodies, 1u);
}

// Glass, 2 mm thick: the pieces have the masses and moments of inertia of the wall.
TEST(FragileScene, ClosedShellsBreakIntoPiecesOfTheWall) {
  v1::Physics physics = fragile(24);
  physics.set_fill(v1::Physics::SHELL);
  physics.set_wall_thickness_m(0.002);
  auto scene = Scene::build(one_object(physics, true), "", "ball", {});
  ASSERT_TRUE(scene) << scene.error().message;
  const SceneObject& thing = *scene->find("thing");
  ASSERT_TRUE(thing.broken) << (thing.warnings.empty() ? "" : thing.warnings[0]);
  EXPECT_GE(thing.fragility->pieces, 12u);
  for (int tick = 0; tick < 60; ++tick) scene->step();
  ASSERT_GT(thing.fragility->bodies, 1u);
  double mass_kg = 0.0;
  for (const BodyState& body : scene->world().bodies()) mass_kg += body.mass_kg;
  EXPECT_NEAR(mass_kg, 0.5, 1e-9);
  // No piece has its centre near the centre of the ball, as pieces of a solid ball would.
  const RestBody& rest = thing.rest;
  if (rest.bodies.size() == thing.fragility->pieces) {
    for (const Pose& pose : rest.bodies) EXPECT_GT(pose.position_m.norm(), 0.02);
  }
}

// Moment of inertia of a cube of edge a about an axis through two face centres: m a² / 6 if solid, 5 m a² /
// 18 if all mass is in the faces.
TEST(Scene, HollowObjectsHaveTheInertiaOfAShell) {
  constexpr double kEdge_m = 0.2, kMass_kg = 0.5, kSpin_rad_s = 2.0;
  for (const auto& [fill, share] : {std::pair{v1::Physics::SOLID, 1.0 / 6},
                                    {v1::Physics::SHELL, 5.0 / 18},
                                    {v1::Physics::OPEN_SHELL, 5.0 / 18}}) {
    v1::Scene file;
    v1::Object& cube = *file.add_objects();
    cube.set_name("cube");
    for (int d = 0; d < 3; ++d) {
      cube.mutable_shape()->mutable_box()->add_size_m(kEdge_m);
      cube.add_angular_velocity_rad_s(d == 1 ? kSpin_rad_s : 0.0);
      file.add_gravity_m_s2(0.0);
    }
    cube.mutable_physics()->set_behavior(v1::Physics::RIGID);
    cube.mutable_physics()->set_fill(fill);
    cube.mutable_physics()->set_mass_kg(kMass_kg);
    const auto scene = Scene::build(file, "", "cube", {});
    ASSERT_TRUE(scene) << scene.error().message;
    const double turns = scene->world().energy().angular_momentum.y() / kSpin_rad_s;
    EXPECT_NEAR(turns, share * kMass_kg * kEdge_m * kEdge_m, 1e-3 * turns) << v1::Physics::Fill_Name(fill);
  }
}

TEST(FragileScene, WarnsOfAShellThatIsTooThin) {
  v1::Physics physics = fragile(8);
  physics.set_fill(v1::Physics::SHELL);
  physics.set_wall_thickness_m(0.0001);
  const auto scene = Scene::build(one_object(physics, false), "", "box", {});
  ASSERT_TRUE(scene) << scene.error().message;
  const SceneObject& thing = *scene->find("thing");
  std::string all;
  for (const std::string& warning : thing.warnings) all += warning;
  EXPECT_NE(all.find("too thin"), std::string::npos) << all;
}

TEST(FragileScene, WarnsIfANonRigidObjectIsMadeFragile) {
  v1::Physics physics = fragile(0);
  physics.set_behavior(v1::Physics::ELASTIC);
  physics.set_youngs_modulus_pa(1e5);
  physics.set_fragile(false);
  auto scene = Scene::build(one_object(physics, false), "", "box", {});
  ASSERT_TRUE(scene) << scene.error().message;
  v1::PhysicalParameters now = scene->find("thing")->physics;
  now.set_fragile(true);
  ASSERT_TRUE(scene->set_physics(scene->find("thing")->id, now));
  std::string all;
  for (const std::string& warning : scene->find("thing")->warnings) all += warning;
  EXPECT_NE(all.find("only RIGID objects break"), std::string::npos) << all;
}

TEST(FragileScene, WarnsIfAFragileObjectIsNotRigid) {
  v1::Physics physics = fragile(0);
  physics.set_behavior(v1::Physics::ELASTIC);
  physics.set_youngs_modulus_pa(1e5);
  const auto scene = Scene::build(one_object(physics, false), "", "box", {});
  ASSERT_TRUE(scene) << scene.error().message;
  std::string all;
  for (const std::string& warning : scene->find("thing")->warnings) all += warning;
  EXPECT_NE(all.find("physics.fragile: no effect, only RIGID objects break, and this object is ELASTIC"),
            std::string::npos)
      << all;
}

}  // namespace
}  // namespace livegs
