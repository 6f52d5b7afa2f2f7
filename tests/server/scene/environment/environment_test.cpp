// SPDX-License-Identifier: Apache-2.0
// Environments of scene files: a mesh collider, and a captured background that collides.
#include <gtest/gtest.h>

#include <cmath>

#include "gaussian/asset_file.h"
#include "geometry/mesh/mesh_io.h"
#include "scene/build/shape_asset.h"
#include "scene/scene.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

// Two steps: height 0.4 m for x < 0 and 0.2 m for x > 0; not convex.
const char* const kStair =
    "v 0 0.2 -0.3\nv 0 0.4 -0.3\nv -0.4 0.4 -0.3\nv -0.4 0 -0.3\nv 0.4 0 -0.3\nv 0.4 0.2 -0.3\n"
    "v 0 0.2 0.3\nv 0 0.4 0.3\nv -0.4 0.4 0.3\nv -0.4 0 0.3\nv 0.4 0 0.3\nv 0.4 0.2 0.3\n"
    "f 6 5 4 3 2 1\n"
    "f 7 8 9 10 11 12\n"
    "f 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n";

// A box, a ball and a soft cube, released 50 mm above each step. There is no floor below the steps.
std::string scene_text(const std::string& environment) {
  std::string objects;
  for (const auto& [name, x, top_m] : {std::tuple{"upper", -0.2, 0.4}, {"lower", 0.2, 0.2}}) {
    const auto add = [&](const char* what, double z, const char* shape, const char* physics) {
      objects += std::string(objects.empty() ? "" : ",") + R"({"name":")" + name + " " + what +
                 R"(","shape":)" + shape + R"(,"pose":{"position_m":[)" + std::to_string(x) + "," +
                 std::to_string(top_m + 0.1) + "," + std::to_string(z) + R"(]},"physics":)" + physics + "}";
    };
    add("box", -0.18, R"({"box":{"size_m":[0.1,0.1,0.1]}})", R"({"behavior":"RIGID","mass_kg":0.5})");
    add("ball", 0.0, R"({"sphere":{"radius_m":0.05}})", R"({"behavior":"RIGID","mass_kg":0.5})");
    add("soft", 0.18, R"({"box":{"size_m":[0.1,0.1,0.1]}})",
        R"({"behavior":"ELASTIC","density_kg_m3":500,"youngs_modulus_pa":5e4,"damping":0.3})");
  }
  return R"({"rate_hz":60,"environment":)" + environment + R"(,"objects":[)" + objects + "]}";
}

void expect_all_rest_on_their_steps(const ScratchFolder& folder, const std::string& environment,
                                    double tolerance_m) {
  auto scene = Scene::load(folder.write("stair.scene.json", scene_text(environment)), {});
  ASSERT_TRUE(scene) << scene.error().message;
  for (int tick = 0; tick < 180; ++tick) scene->step();
  int found = 0;
  for (const BodyState& body : scene->world().bodies()) {
    const SceneObject& object = *scene->find(body.object_id);
    if (object.environment) continue;
    const double top_m = object.name.starts_with("upper") ? 0.4 : 0.2;
    // The soft cube is compressed by its own weight, rho g h² / (2 E) = 0.5 mm.
    EXPECT_NEAR(body.world_from_body.position_m.y(), top_m + 0.05, tolerance_m) << object.name;
    EXPECT_LT(body.velocity_m_s.norm(), 0.05) << object.name;
    ++found;
  }
  EXPECT_EQ(found, 6);
}

TEST(BuiltEnvironment, MeshSupportsObjects) {
  const ScratchFolder folder;
  folder.write("stair.obj", kStair);
  expect_all_rest_on_their_steps(folder, R"({"colliders":[{"mesh":"stair.obj","friction":0.6}]})", 1e-3);
}

TEST(BuiltEnvironment, CapturedBackgroundSupportsObjects) {
  const ScratchFolder folder;
  const auto stair = read_obj(folder.write("stair.obj", kStair));
  ASSERT_TRUE(stair) << stair.error().message;
  ASSERT_TRUE(write_asset(folder / "room.ply", mesh_asset(*stair, {0.6f, 0.6f, 0.5f}, 20000)));
  // The surface reconstructed from the kernels lies 0.9 mm below them.
  expect_all_rest_on_their_steps(folder, R"({"asset":"room.ply","up":"+y","scale":1,"collide":true})", 3e-3);
}

// A background in centimetres, with z up, as its file says. The scene file has precedence.
TEST(BuiltEnvironment, CapturedBackgroundHasItsOwnUnitAndAxis) {
  const ScratchFolder folder;
  const auto stair = read_obj(folder.write("stair.obj", kStair));
  ASSERT_TRUE(stair) << stair.error().message;
  const GaussianAsset metric = mesh_asset(*stair, {0.6f, 0.6f, 0.5f}, 20000);
  const Eigen::Quaternionf z_up(
      Eigen::AngleAxisf(static_cast<float>(0.5 * EIGEN_PI), Eigen::Vector3f::UnitX()));
  GaussianAsset in_cm = metric;
  for (size_t i = 0; i < in_cm.size(); ++i) {
    in_cm.positions[i] = 100 * (z_up * metric.positions[i]);
    in_cm.rotations[i] = z_up * metric.rotations[i];
    in_cm.log_scales[i].array() += std::log(100.0f);
  }
  AssetFrame frame;
  frame.up_axis = "z";
  frame.metres_per_unit = 0.01;
  for (const std::string file : {"room.ply", "room.sog"}) {
    SCOPED_TRACE(file);
    ASSERT_TRUE(write_asset(folder / file, in_cm, frame));
    expect_all_rest_on_their_steps(folder, R"({"asset":")" + file + R"(","collide":true})", 3e-3);
  }
  ASSERT_TRUE(write_asset(folder / "metric.ply", metric, frame));
  expect_all_rest_on_their_steps(folder, R"({"asset":"metric.ply","up":"+y","scale":1,"collide":true})",
                                 3e-3);
}

// Without `collide`, the background is only drawn.
TEST(BuiltEnvironment, BackgroundDoesNotCollideByDefault) {
  const ScratchFolder folder;
  const auto stair = read_obj(folder.write("stair.obj", kStair));
  ASSERT_TRUE(stair) << stair.error().message;
  ASSERT_TRUE(write_asset(folder / "room.ply", mesh_asset(*stair, {0.6f, 0.6f, 0.5f}, 20000)));
  auto scene = Scene::load(
      folder.write("s.scene.json", scene_text(R"({"asset":"room.ply","up":"+y","scale":1})")), {});
  ASSERT_TRUE(scene) << scene.error().message;
  for (int tick = 0; tick < 60; ++tick) scene->step();
  for (const BodyState& body : scene->world().bodies()) {
    EXPECT_TRUE(scene->find(body.object_id)->environment || body.world_from_body.position_m.y() < -3.0);
  }
}

TEST(BuiltEnvironment, ErrorsNameAnUnreadableMesh) {
  const ScratchFolder folder;
  folder.write("open.obj", "v 0 0 0\n");
  for (const char* name : {"open.obj", "none.obj"}) {
    const auto scene =
        Scene::load(folder.write("s.scene.json",
                                 scene_text(std::string(R"({"colliders":[{"mesh":")") + name + R"("}]})")),
                    {});
    ASSERT_FALSE(scene) << name;
    EXPECT_NE(scene.error().message.find("environment.colliders[0].mesh"), std::string::npos)
        << scene.error().message;
    EXPECT_NE(scene.error().message.find(name), std::string::npos) << scene.error().message;
  }
}

}  // namespace
}  // namespace livegs
