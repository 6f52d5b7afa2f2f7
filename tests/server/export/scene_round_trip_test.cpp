// SPDX-License-Identifier: Apache-2.0
// A scene to glTF and to USDA and back keeps every body within 1e-6.
#include <gtest/gtest.h>

#include <cmath>

#include "export/collect_scene.h"
#include "export/gltf_scene.h"
#include "export/usda_scene.h"
#include "gaussian/asset_file.h"
#include "geometry/surface/shape_mesh.h"
#include "scene/build/shape_asset.h"
#include "scene/scene.h"
#include "scratch_folder.h"
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
  const auto kernels = [&](const auto& change) {
    return difference([&](PortableScene& s) {
      GaussianAsset asset = *s.bodies[1].asset;
      change(asset);
      s.bodies[1].asset = std::make_shared<const GaussianAsset>(std::move(asset));
    });
  };
  EXPECT_NE(kernels([](GaussianAsset& a) { a.antialiased = !a.antialiased; }), "");
  EXPECT_NE(kernels([](GaussianAsset& a) { a.positions[2].y() += 1e-4f; }), "");
  EXPECT_NE(kernels([](GaussianAsset& a) { a.log_scales[2].y() += 1e-3f; }), "");
  EXPECT_NE(kernels([](GaussianAsset& a) { a.opacity_logits[2] += 1e-3f; }), "");
  EXPECT_NE(kernels([](GaussianAsset& a) { a.sh_dc[2].y() += 1e-4f; }), "");
  EXPECT_NE(kernels([](GaussianAsset& a) { a.sh_rest[2].y() += 1e-3f; }), "");
  EXPECT_NE(kernels([](GaussianAsset& a) {
              a.rotations[2] = a.rotations[2] * Eigen::Quaternionf(1, 0.01f, 0, 0).normalized();
            }),
            "");
  EXPECT_NE(difference([](PortableScene& s) { s.bodies[1].object_from_asset.scale *= 1.001; }), "");
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

// A captured room that collides: the box of 4 x 2.5 x 4 m around its objects is a contact surface.
TEST(CollectScene, CapturedRoomIsAContactSurface) {
  const Vector3d size_m(4, 2.5, 4), shift_m(1, 0, 0);
  TriangleMesh box = box_mesh(size_m);
  for (Vector3d& vertex : box.vertices_m) vertex.y() += 0.5 * size_m.y();
  const ScratchFolder folder;
  ASSERT_TRUE(write_asset(folder / "room.ply", mesh_asset(box, {0.7f, 0.7f, 0.6f}, 30000)));
  const auto scene = collect_scene(folder.write("room.scene.json", R"({
    "environment": { "asset": "room.ply", "up": "+y", "collide": true, "pose": { "position_m": [1, 0, 0] } },
    "objects": [ { "name": "ball", "shape": { "sphere": { "radius_m": 0.1 } },
      "pose": { "position_m": [1.5, 0.1, 0.3] }, "physics": { "behavior": "RIGID", "mass_kg": 1 } } ] })"));
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_TRUE(scene->notes.empty());
  ASSERT_EQ(scene->fixed.size(), 1u);
  const PortableShape& room = scene->fixed[0];
  ASSERT_EQ(room.kind, PortableShape::Kind::Mesh);
  EXPECT_FALSE(room.convex);
  EXPECT_EQ(room.owner_from_shape.position_m, shift_m);
  ASSERT_TRUE(room.mesh);
  // The surface has an outside, at the kernels, and an inside, which is hollow around the ball: rays along
  // the axes leave the ball's centre through a wall at the distance of the room's sides.
  const Vector3d centre_m = Vector3d(1.5, 0.1, 0.3) - shift_m;
  Vector3d low = Vector3d::Constant(-1e9), high = -low;
  for (const Vector3d& vertex : room.mesh->vertices_m) {
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d off = vertex - centre_m;
      const double aside = std::max(std::abs(off[(axis + 1) % 3]), std::abs(off[(axis + 2) % 3]));
      if (aside > 0.08) continue;
      (off[axis] < 0 ? low : high)[axis] =
          off[axis] < 0 ? std::max(low[axis], vertex[axis]) : std::min(high[axis], vertex[axis]);
    }
  }
  EXPECT_LT((low - Vector3d(-2, 0, -2)).cwiseAbs().maxCoeff(), 0.05) << low.transpose();
  EXPECT_LT((high - Vector3d(2, 2.5, 2)).cwiseAbs().maxCoeff(), 0.05) << high.transpose();
  expect_round_trips(*scene, "room");
}

}  // namespace
}  // namespace livegs
