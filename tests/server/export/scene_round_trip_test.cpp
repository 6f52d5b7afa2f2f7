// SPDX-License-Identifier: Apache-2.0
// A scene to glTF and to USDA and back keeps every body within 1e-6.
#include <gtest/gtest.h>

#include <cmath>

#include "export/collect_scene.h"
#include "export/gltf_scene.h"
#include "export/usda_scene.h"
#include "scene/scene.h"
#include "server/export/gltf_structure.h"
#include "server/export/made_up_scene.h"
#include "server/export/scene_difference.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

constexpr double kTolerance = 1e-6;
constexpr double kFloatMotion = 1e-5;  // keys of glTF are floats

void expect_round_trips(const PortableScene& scene, const std::string& what) {
  const auto files = encode_gltf_scene(scene, "");
  ASSERT_TRUE(files) << what << ": " << files.error().message;
  for (const std::string& violation : gltf_violations(*files)) ADD_FAILURE() << what << ": " << violation;
  const auto glb = encode_glb(*files);
  ASSERT_TRUE(glb) << what;
  const auto from_gltf = decode_gltf_scene(*glb, {}, "scene.glb");
  ASSERT_TRUE(from_gltf) << what << ": " << from_gltf.error().message;
  EXPECT_EQ(scene_difference(scene, *from_gltf, kTolerance, kFloatMotion), "") << what << ", glTF";
  EXPECT_TRUE(from_gltf->notes.empty()) << from_gltf->notes[0];
  const auto from_usd = decode_usda_scene(encode_usda_scene(scene), "scene.usda");
  ASSERT_TRUE(from_usd) << what << ": " << from_usd.error().message;
  EXPECT_EQ(scene_difference(scene, *from_usd, kTolerance, kTolerance), "") << what << ", USD";
}

TEST(SceneRoundTrip, RandomScenesAreKept) {
  for (uint64_t seed = 1; seed <= 40; ++seed) expect_round_trips(made_up_scene(seed), std::to_string(seed));
}

// The comparison of the tests above finds each change.
TEST(SceneRoundTrip, DifferencesAreFound) {
  const PortableScene scene = made_up_scene(9);
  EXPECT_EQ(scene_difference(scene, scene, kTolerance, kTolerance), "");
  const auto difference = [&](const auto& change) {
    PortableScene changed = scene;
    change(changed);
    return scene_difference(scene, changed, kTolerance, kTolerance);
  };
  EXPECT_NE(difference([](PortableScene& s) { s.bodies[1].mass_kg *= 1 + 1e-5; }), "");
  EXPECT_NE(difference([](PortableScene& s) { s.bodies[1].centre_m.x() += 1e-5; }), "");
  EXPECT_NE(difference([](PortableScene& s) { s.bodies[1].inertia_kg_m2.y() *= 1.001; }), "");
  EXPECT_NE(difference([](PortableScene& s) { s.bodies[0].world_from_object.position_m.y() += 1e-4; }), "");
  EXPECT_NE(difference([](PortableScene& s) { s.bodies[2].elastic->youngs_modulus_pa *= 1.001; }), "");
  EXPECT_NE(difference([](PortableScene& s) { s.bodies[2].elastic->lattice.cells[0][0] ^= 1; }), "");
  EXPECT_NE(difference([](PortableScene& s) { s.joints[0].point_m.x() += 1e-4; }), "");
  EXPECT_NE(difference([](PortableScene& s) { s.bodies[0].estimates.set_label("cup"); }), "");
  EXPECT_NE(
      difference([](PortableScene& s) { s.animation->tracks[0].world_from_object[0].position_m.x() += 1; }),
      "");
}

class ExampleSceneRoundTrip : public ::testing::TestWithParam<const char*> {};

TEST_P(ExampleSceneRoundTrip, EveryBodyIsKept) {
  const auto path =
      std::filesystem::path(LIVEGS_TESTS_DIR) / "scenes" / (std::string(GetParam()) + ".scene.json");
  const auto scene = collect_scene(path);
  ASSERT_TRUE(scene) << scene.error().message;
  const auto file = read_scene_file(path);
  ASSERT_TRUE(file);
  size_t bodies = 0;
  for (const PortableBody& body : scene->bodies) bodies += body.drawn_only ? 0 : 1;
  EXPECT_EQ(bodies, static_cast<size_t>(file->objects_size()));
  EXPECT_EQ(scene->joints.size(), static_cast<size_t>(file->joints_size()));
  EXPECT_EQ(scene->fixed.size(), static_cast<size_t>(file->environment().colliders_size()));
  EXPECT_TRUE(scene->notes.empty());
  expect_round_trips(*scene, GetParam());
}
INSTANTIATE_TEST_SUITE_P(Scenes, ExampleSceneRoundTrip,
                         ::testing::Values("bar_in_tension", "cup_breaks", "everything", "joints",
                                           "spinning_ball"),
                         [](const auto& info) { return std::string(info.param); });

const PortableBody& body_named(const PortableScene& scene, const std::string& name) {
  for (const PortableBody& body : scene.bodies) {
    if (body.name == name) return body;
  }
  ADD_FAILURE() << name << " is missing";
  return scene.bodies[0];
}

// Mass, centre and inertia are those of the closed forms: a box of m (a² + b²) / 12, a sphere near 2/5 m r².
TEST(CollectScene, ValuesAreThoseOfTheBodies) {
  const auto scene =
      collect_scene(std::filesystem::path(LIVEGS_TESTS_DIR) / "scenes" / "everything.scene.json");
  ASSERT_TRUE(scene) << scene.error().message;
  const PortableBody& door = body_named(*scene, "door");
  EXPECT_EQ(door.mass_kg, 4);
  EXPECT_LT((door.world_from_object.position_m - Vector3d(-0.6, 0.5, 0)).norm(), 1e-12);
  const Vector3d expected =
      4.0 / 12 * Vector3d(0.8 * 0.8 + 0.04 * 0.04, 0.4 * 0.4 + 0.04 * 0.04, 0.4 * 0.4 + 0.8 * 0.8);
  EXPECT_LT((door.inertia_tensor_kg_m2() - Eigen::Matrix3d(expected.asDiagonal())).norm(), 1e-9);
  ASSERT_EQ(door.shapes.size(), 1u);
  EXPECT_EQ(door.shapes[0].size_m, Vector3d(0.4, 0.8, 0.04));
  const PortableBody& marble = body_named(*scene, "marble");
  EXPECT_EQ(marble.shapes[0].kind, PortableShape::Kind::Sphere);
  EXPECT_NEAR(marble.inertia_kg_m2.mean(), 0.4 * 0.3 * 0.04 * 0.04, 0.05 * 0.4 * 0.3 * 0.04 * 0.04);
  EXPECT_EQ(body_named(*scene, "link").shapes[0].kind, PortableShape::Kind::Capsule);
  EXPECT_EQ(body_named(*scene, "cup").shapes[0].kind, PortableShape::Kind::Mesh);
  // An elastic body: its particles fill the box, so that the mass is that of the volume, and the inertia too.
  const PortableBody& block = body_named(*scene, "block");
  ASSERT_TRUE(block.elastic);
  const double mass = 300 * 0.2 * 0.15 * 0.2;
  EXPECT_NEAR(block.mass_kg, mass, 1e-6);
  EXPECT_LT(block.centre_m.norm(), 1e-6);
  EXPECT_NEAR(block.inertia_tensor_kg_m2()(1, 1), mass / 12 * 2 * 0.2 * 0.2,
              0.02 * mass / 12 * 2 * 0.2 * 0.2);
  EXPECT_EQ(block.elastic->youngs_modulus_pa, 3e4);
  EXPECT_GT(block.elastic->lattice.node_coordinates.size(), 8u);
  EXPECT_GT(block.elastic->accuracy.cell_width_m(), 0);
  EXPECT_EQ(block.estimates.youngs_modulus_pa().source(), v1::EstimatedValue::SCENE);
  // Joints: the hinge of the door to the world, the weight on the link.
  EXPECT_TRUE(scene->joints[0].hinge);
  EXPECT_FALSE(scene->joints[0].other);
  ASSERT_TRUE(scene->joints[2].other);
  EXPECT_EQ(scene->bodies[*scene->joints[2].other].name, "link");
}

}  // namespace
}  // namespace livegs
