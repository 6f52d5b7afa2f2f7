// SPDX-License-Identifier: Apache-2.0
// Rooms with objects in them: captured rooms, closed and with a door, and room meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "gaussian/asset_file.h"
#include "geometry/surface/shape_mesh.h"
#include "rates.h"
#include "scene/build/shape_asset.h"
#include "scene/scene.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

constexpr double kWide_m = 4.0, kHigh_m = 2.5;

constexpr double kTable_m = 0.7;  // height of the box in a captured room

void append(GaussianAsset& all, const GaussianAsset& part, size_t i) {
  const size_t k = all.size();
  all.resize(k + 1);
  all.positions[k] = part.positions[i];
  all.rotations[k] = part.rotations[i];
  all.log_scales[k] = part.log_scales[i];
  all.opacity_logits[k] = part.opacity_logits[i];
  all.sh_dc[k] = part.sh_dc[i];
}

// The surface of a room as captured: flat kernels on its six sides, except for a doorway at x > 0, and on a
// box in a corner.
GaussianAsset captured_room(bool door) {
  TriangleMesh box = box_mesh({kWide_m, kHigh_m, kWide_m});
  for (Eigen::Vector3d& vertex : box.vertices_m) vertex.y() += 0.5 * kHigh_m;
  const GaussianAsset closed = mesh_asset(box, {0.7f, 0.7f, 0.6f}, 40000);
  GaussianAsset room;
  for (size_t i = 0; i < closed.size(); ++i) {
    const Eigen::Vector3f& at = closed.positions[i];
    if (door && at.x() > 1.9f && std::abs(at.z()) < 0.45f && at.y() > 0.05f && at.y() < 2.0f) continue;
    append(room, closed, i);
  }
  TriangleMesh table = box_mesh({1.0, kTable_m, 1.0});
  for (Eigen::Vector3d& vertex : table.vertices_m) vertex += Eigen::Vector3d(-1.2, 0.5 * kTable_m, -1.2);
  const GaussianAsset on_table = mesh_asset(table, {0.6f, 0.5f, 0.4f}, 6000);
  for (size_t i = 0; i < on_table.size(); ++i) append(room, on_table, i);
  return room;
}

constexpr const char* kOnTable =
    R"(,{"name":"table box","shape":{"box":{"size_m":[0.2,0.2,0.2]}},"pose":{"position_m":[-1.2,0.9,-1.2]},)"
    R"("physics":{"behavior":"RIGID","mass_kg":1}})";

// A box, a ball and a soft cube of 0.2 m in the middle of the room. Their lowest points start 0.3 m above
// `floor_m`.
std::string things(double floor_m, const std::string& prefix) {
  const std::string y = std::to_string(floor_m + 0.4);
  const auto one = [&](const char* what, const char* shape, const char* x_z, const char* physics) {
    const std::string at = std::string(x_z).replace(std::string(x_z).find('y'), 1, y);
    return R"({"name":")" + prefix + what + R"(","shape":)" + shape + R"(,"pose":{"position_m":[)" + at +
           R"(]},"physics":)" + physics + "}";
  };
  return one("box", R"({"box":{"size_m":[0.2,0.2,0.2]}})", "0.6,y,0", R"({"behavior":"RIGID","mass_kg":1})") +
         "," +
         one("ball", R"({"sphere":{"radius_m":0.1}})", "-0.5,y,0.3", R"({"behavior":"RIGID","mass_kg":1})") +
         "," +
         one("soft", R"({"box":{"size_m":[0.2,0.2,0.2]}})", "0,y,-0.6",
             R"({"behavior":"ELASTIC","density_kg_m3":300,"youngs_modulus_pa":5e4,"damping":0.3})");
}

std::string scene_text(const std::string& environment, const std::string& objects, int rate_hz = 60) {
  return R"({"rate_hz":)" + std::to_string(rate_hz) + R"(,"environment":)" + environment + R"(,"objects":[)" +
         objects + "]}";
}

// After four seconds all objects lie on the floor, the roof or the table, and there are no warnings. Balls
// may have rolled.
void expect_on_floor(Scene& scene, double floor_m, double tolerance_m) {
  for (int tick = 0; tick < 4 * scene.world().settings().rate_hz; ++tick) scene.step();
  for (const BodyState& body : scene.world().bodies()) {
    const SceneObject& object = *scene.find(body.object_id);
    if (object.environment) continue;
    const double height_m = floor_m + (object.name.starts_with("roof")    ? kHigh_m
                                       : object.name.starts_with("table") ? kTable_m
                                                                          : 0.0);
    EXPECT_NEAR(body.world_from_body.position_m.y(), height_m + 0.1, tolerance_m) << object.name;
    EXPECT_LT(std::abs(body.world_from_body.position_m.x()), 0.5 * kWide_m) << object.name;
    EXPECT_LT(std::abs(body.world_from_body.position_m.z()), 0.5 * kWide_m) << object.name;
    EXPECT_TRUE(object.warnings.empty()) << object.name << ": " << object.warnings[0];
  }
}

TEST(Room, CapturedRoomSupportsFloorAndRoof) {
  for (const double rate_hz : kRates_hz)
    for (const bool door : {false, true}) {
      SCOPED_TRACE(::testing::Message() << (door ? "with a door, " : "closed, ") << rate_hz << " Hz");
      const ScratchFolder folder;
      ASSERT_TRUE(write_asset(folder / "room.ply", captured_room(door)));
      const std::string environment = R"({"asset":"room.ply","up":"+y","scale":1,"collide":true})";
      const std::string all = things(0.0, "") + "," + things(kHigh_m, "roof ") + kOnTable;
      auto scene = Scene::load(
          folder.write("room.scene.json", scene_text(environment, all, static_cast<int>(rate_hz))), {});
      ASSERT_TRUE(scene) << scene.error().message;
      expect_on_floor(*scene, 0.0, 0.02);
    }
}

// A room without objects in it is not opened.
TEST(Room, EmptyCapturedRoomSupportsItsRoof) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_asset(folder / "room.ply", captured_room(false)));
  const std::string environment = R"({"asset":"room.ply","up":"+y","scale":1,"collide":true})";
  auto scene =
      Scene::load(folder.write("above.scene.json", scene_text(environment, things(kHigh_m, "roof "))), {});
  ASSERT_TRUE(scene) << scene.error().message;
  expect_on_floor(*scene, 0.0, 0.02);
}

// A box mesh that contains objects is a room, whether its faces point inwards or outwards.
TEST(Room, MeshAroundObjectsIsARoom) {
  for (const bool inwards : {false, true}) {
    SCOPED_TRACE(inwards);
    const TriangleMesh box = box_mesh({kWide_m, kHigh_m, kWide_m});
    std::string obj;
    for (const Eigen::Vector3d& v : box.vertices_m) {
      obj += "v " + std::to_string(v.x()) + " " + std::to_string(v.y()) + " " + std::to_string(v.z()) + "\n";
    }
    for (auto [a, b, c] : box.triangles) {
      if (inwards) std::swap(b, c);
      obj += "f " + std::to_string(a + 1) + " " + std::to_string(b + 1) + " " + std::to_string(c + 1) + "\n";
    }
    const ScratchFolder folder;
    folder.write("room.obj", obj);
    const std::string environment = R"({"colliders":[{"mesh":"room.obj","pose":{"position_m":[0,1.25,0]}}]})";
    auto inside = Scene::load(folder.write("in.scene.json", scene_text(environment, things(0.0, ""))), {});
    ASSERT_TRUE(inside) << inside.error().message;
    expect_on_floor(*inside, 0.0, 3e-3);
    auto above =
        Scene::load(folder.write("above.scene.json", scene_text(environment, things(kHigh_m, "roof "))), {});
    ASSERT_TRUE(above) << above.error().message;
    expect_on_floor(*above, 0.0, 3e-3);
  }
}

TEST(Room, FloorWithoutThicknessSupportsObjects) {
  const ScratchFolder folder;
  folder.write("floor.obj", "v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nf 1 2 3 4\n");  // its face points down
  const std::string environment = R"({"colliders":[{"mesh":"floor.obj"}]})";
  auto scene = Scene::load(folder.write("s.scene.json", scene_text(environment, things(0.0, ""))), {});
  ASSERT_TRUE(scene) << scene.error().message;
  expect_on_floor(*scene, 0.0, 3e-3);
}

TEST(Room, ErrorsNameAMeshWithoutArea) {
  const ScratchFolder folder;
  folder.write("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  const std::string environment = R"({"colliders":[{"mesh":"line.obj"}]})";
  const auto scene = Scene::load(folder.write("s.scene.json", scene_text(environment, things(0.0, ""))), {});
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("environment.colliders[0].mesh: all triangles have zero area"),
            std::string::npos)
      << scene.error().message;
}

// A solid block of kernels that contains an object: there is no room to open.
TEST(Room, WarnsOfObjectsThatStartInASolid) {
  GaussianAsset block;
  for (int i = 0; i < 12 * 12 * 12; ++i) {
    const size_t k = block.size();
    block.resize(k + 1);
    block.positions[k] = 0.08f * Eigen::Vector3f(static_cast<float>(i % 12), static_cast<float>(i / 12 % 12),
                                                 static_cast<float>(i / 144)) -
                         Eigen::Vector3f(0.44f, 0.0f, 0.44f);
    block.rotations[k] = Eigen::Quaternionf::Identity();
    block.log_scales[k] = Eigen::Vector3f::Constant(-4.0f);
    block.opacity_logits[k] = 4.0f;
    block.sh_dc[k].setZero();
  }
  const ScratchFolder folder;
  ASSERT_TRUE(write_asset(folder / "block.ply", block));
  const auto ball = [](const char* name, const char* height) {
    return std::string(R"({"name":")") + name +
           R"(","shape":{"sphere":{"radius_m":0.1}},"pose":{"position_m":[0,)" + height +
           R"(,0]},"physics":{"behavior":"RIGID","mass_kg":1}})";
  };
  const std::string environment = R"({"asset":"block.ply","up":"+y","scale":1,"collide":true})";
  auto scene = Scene::load(
      folder.write("s.scene.json", scene_text(environment, ball("sunk", "0.5") + "," + ball("free", "1.5"))),
      {});
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->find("sunk")->warnings.size(), 1u);
  const std::string& warning = scene->find("sunk")->warnings[0];
  EXPECT_NE(warning.find("starts inside environment.asset"), std::string::npos) << warning;
  EXPECT_TRUE(scene->find("free")->warnings.empty());
}

}  // namespace
}  // namespace livegs
