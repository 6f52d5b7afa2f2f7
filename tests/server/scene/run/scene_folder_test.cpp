// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "analysis/estimate.h"
#include "analysis/knowledge/name_match.h"
#include "gaussian/asset_file.h"
#include "geometry/surface/shape_mesh.h"
#include "scene/build/place_asset.h"
#include "scene/build/shape_asset.h"
#include "scene/scene.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

void write_ball(const std::filesystem::path& path, double radius, const AssetFrame& frame = {}) {
  std::filesystem::create_directories(path.parent_path());
  const auto written = write_asset(path, mesh_asset(sphere_mesh(radius, 3), {0.5f, 0.5f, 0.5f}, 3000), frame);
  ASSERT_TRUE(written) << written.error().message;
}

// A pedestal with a bumpy, leaning underside of haze, as captures have it; sizes in metres.
void write_statue(const std::filesystem::path& path, unsigned seed, double scale) {
  std::mt19937 random(seed);
  const auto uniform = [&] { return static_cast<double>(random() % 10000) / 10000.0; };
  TriangleMesh mesh = cylinder_mesh(0.06 * scale, 0.4 * scale);
  GaussianAsset asset = mesh_asset(mesh, {0.7f, 0.7f, 0.6f}, 6000);
  const double slope = 0.3 * (uniform() - 0.5), phase = 6.0 * uniform();
  for (auto& position : asset.positions) {
    // The asset's up axis is -y.
    if (position.y() < 0.17 * scale) continue;
    const double across = position.x() * std::cos(phase) + position.z() * std::sin(phase);
    position.y() += static_cast<float>(slope * across + 0.004 * scale * uniform());
  }
  ASSERT_TRUE(write_asset(path, asset));
}

double tilt_deg(const Pose& from, const Pose& to) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitY();
  const double cosine = (from.orientation * up).dot(to.orientation * up);
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / M_PI;
}

// Things stand as they were captured, also while nothing may sleep, and fall over when they are pushed.
TEST(SceneFolder, CapturesStandUntilTheyArePushed) {
  ScratchFolder folder;
  constexpr unsigned kCount = 6;
  for (unsigned seed = 1; seed <= kCount; ++seed)
    write_statue(folder / ("statue" + std::to_string(seed) + ".ply"), seed, 1.0);
  for (const bool sleep : {true, false}) {
    SceneOptions options;
    options.sleep = sleep;
    auto scene = Scene::load(folder.path(), options);
    ASSERT_TRUE(scene) << scene.error().message;
    const auto statues = [&] {  // without the floor
      std::vector<BodyState> bodies = scene->world().bodies();
      std::erase_if(bodies, [&](const BodyState& body) { return scene->find(body.object_id)->environment; });
      return bodies;
    };
    const std::vector<BodyState> start = statues();
    ASSERT_EQ(start.size(), kCount);
    for (const BodyState& body : start) EXPECT_EQ(body.asleep, sleep);
    EXPECT_NEAR(scene->bounds_m().min().y(), 0.0, 0.03);
    for (int i = 0; i < 20 * 90; ++i) scene->step();
    const std::vector<BodyState> end = statues();
    for (size_t i = 0; i < end.size(); ++i) {
      const Eigen::Vector3d moved = end[i].world_from_body.position_m - start[i].world_from_body.position_m;
      EXPECT_LT(moved.norm(), 0.002) << i;
      EXPECT_LT(tilt_deg(start[i].world_from_body, end[i].world_from_body), 2.0) << i;
    }
    for (const BodyState& body : end) {
      v1::Event::Force push;
      push.set_object(scene->find(body.object_id)->name);
      for (const double x : {0.5 * body.mass_kg * 9.81, 0.0, 0.0}) push.add_force_n(x);
      for (const double x : {0.0, 0.19, 0.0}) push.add_point_m(x);
      push.set_duration_s(1.0);
      scene->apply_force(push);
    }
    for (int i = 0; i < 3 * 90; ++i) scene->step();
    // Stone may break when it falls: the height of the pieces counts.
    std::map<uint32_t, double> mass_kg, height_kg_m;
    for (const BodyState& body : statues()) {
      mass_kg[body.object_id] += body.mass_kg;
      height_kg_m[body.object_id] += body.mass_kg * body.world_from_body.position_m.y();
    }
    for (const BodyState& body : start) {
      const uint32_t id = body.object_id;
      EXPECT_LT(height_kg_m[id] / mass_kg[id], 0.5 * body.world_from_body.position_m.y()) << id;
    }
  }
}

// Assets of unknown names in one folder keep the ratio of their sizes, also where one of them is too large to
// be in metres.
TEST(SceneFolder, AssetsOfOneFolderHaveOneScale) {
  ScratchFolder folder;
  write_ball(folder / "thing_a.ply", 0.5);
  write_ball(folder / "thing_b.ply", 5.0);
  auto scene = Scene::load(folder.path(), {});
  ASSERT_TRUE(scene) << scene.error().message;
  const auto side_m = [&](const char* name) { return scene->find(name)->physics.longest_side_m().best(); };
  EXPECT_NEAR(side_m("thing_b") / side_m("thing_a"), 10.0, 0.5);
  EXPECT_NEAR(side_m("thing_b"), kDefaultSize_m, 0.05);
}

TEST(SceneFolder, DropsAssetsOntoTheFloor) {
  ScratchFolder folder;
  write_ball(folder / "cup.ply", 0.05);
  write_ball(folder / "cup.spz", 0.05);  // the same stem: skipped
  write_ball(folder / "deep/stone.ply", 0.1);
  write_ball(folder / "room.ply", 2.0);
  folder.write("notes.txt", "not an asset");
  folder.write("broken.ply", "ply\nnonsense");  // skipped with a warning
  SceneOptions options;
  options.drop = true;
  auto scene = Scene::load(folder.path(), options);
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->objects().size(), 3u);
  EXPECT_TRUE(scene->objects()[0].environment);
  EXPECT_NE(scene->find("cup"), nullptr);
  EXPECT_NE(scene->find("stone"), nullptr);
  EXPECT_GT(scene->bounds_m().min().y(),
            0.05);  // balls are not slender: they start half of kDropHeight_m above the floor
  std::vector<double> xs;
  for (const BodyState& body : scene->world().bodies()) {
    if (body.object_id != scene->objects()[0].id) xs.push_back(body.world_from_body.position_m.x());
  }
  ASSERT_EQ(xs.size(), 2u);
  EXPECT_GT(std::abs(xs[0] - xs[1]), 0.15 + 0.2);
}

TEST(SceneFolder, ErrorOfAnEmptyFolderListsFormats) {
  ScratchFolder folder;
  const auto scene = Scene::load(folder.path(), {});
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find(".ply"), std::string::npos);
}

TEST(SceneFolder, EndingsAreInAnyLetterCase) {
  ScratchFolder folder;
  for (const char* name : {"SCAN.PLY", "Vase.Spz", "cup.SPLAT", "x/Bowl.SOG", "y/Jar.Compressed.ply"})
    write_ball(folder / name, 0.1);
  auto scene = Scene::load(folder.path(), {});
  ASSERT_TRUE(scene) << scene.error().message;
  std::set<std::string> names;
  for (const SceneObject& object : scene->objects()) {
    if (!object.environment) names.insert(object.name);
  }
  EXPECT_EQ(names, (std::set<std::string>{"SCAN", "Vase", "cup", "Bowl", "Jar"}));
}

TEST(SceneFolder, OneFileIsASceneOfOneObject) {
  ScratchFolder folder;
  write_ball(folder / "room of mugs.PLY", 0.1);
  write_ball(folder / "other.ply", 0.1);
  auto scene = Scene::load(folder / "room of mugs.PLY", {});
  ASSERT_TRUE(scene) << scene.error().message;
  size_t things = 0;
  for (const SceneObject& object : scene->objects()) things += !object.environment;
  EXPECT_EQ(things, 1u);
  EXPECT_FALSE(Scene::load(folder / "absent.ply", {}));
}

// A box whose long side is along `axis`: the axis that a file names stands upright.
TEST(PlaceAsset, AxisOfTheFileIsUp) {
  ScratchFolder folder;
  const std::map<std::string, Eigen::Vector3d> sizes = {
      {"z", {0.1, 0.1, 0.4}}, {"-z", {0.1, 0.1, 0.4}}, {"x", {0.4, 0.1, 0.1}}, {"y", {0.1, 0.4, 0.1}}};
  for (const auto& [axis, size_m] : sizes) {
    AssetFrame frame;
    frame.up_axis = axis;
    const auto asset = mesh_asset(box_mesh(size_m), {0.5f, 0.5f, 0.5f}, 3000);
    ASSERT_TRUE(write_asset(folder / "box.ply", asset, frame));
    for (const std::string given : {"", "x"}) {
      auto placed = place_asset(folder / "box.ply", "box", 1.0, given, "test");
      ASSERT_TRUE(placed) << placed.error().message;
      EXPECT_TRUE(placed->up_known);
      Eigen::AlignedBox3d bounds;
      for (const Eigen::Vector3d& point : placed->body_points_m) bounds.extend(point);
      const double expected_m = given.empty() || axis == "x" ? 0.4 : 0.1;  // the option overrides the file
      EXPECT_NEAR(bounds.sizes().y(), expected_m, 0.03) << axis << given;
    }
  }
}

TEST(PlaceAsset, ScaleIsGivenKnownOrGuessed) {
  ScratchFolder folder;
  write_ball(folder / "thing.ply", 0.1);
  AssetFrame metric, inches;
  metric.metres_per_unit = 1;
  inches.metres_per_unit = 0.0254;
  write_ball(folder / "thing.spz", 0.1, metric);
  write_ball(folder / "guess.spz", 0.1);
  write_ball(folder / "inches.ply", 4, inches);
  write_ball(folder / "tower.spz", 50.0, metric);
  write_ball(folder / "big.ply", 50.0);
  const auto place = [&](const char* file, const char* name, std::optional<double> scale) {
    auto placed = place_asset(folder / file, name, scale, "", "test");
    EXPECT_TRUE(placed) << placed.error().message;
    return std::pair(placed->object_from_asset.scale, placed->scale_known);
  };
  EXPECT_EQ(place("thing.ply", "thing", 2.0), std::pair(2.0, true));
  EXPECT_EQ(place("thing.spz", "thing", std::nullopt), std::pair(1.0, true));  // .spz is metric
  EXPECT_EQ(place("thing.ply", "thing", std::nullopt),
            std::pair(1.0, false));  // 0.2 m fits a household object
  EXPECT_EQ(place("guess.spz", "thing", std::nullopt), std::pair(1.0, false));  // converted without a unit
  EXPECT_EQ(place("inches.ply", "thing", std::nullopt), std::pair(0.0254, true));
  EXPECT_FALSE(place("tower.spz", "mug", std::nullopt).second);  // no mug is 100 m wide
  EXPECT_TRUE(place("tower.spz", "thing", std::nullopt).second);
  EXPECT_EQ(place("thing.ply", "bowl", std::nullopt), std::pair(1.0, false));  // 0.2 m fits a bowl
  const auto [scale, known] = place("big.ply", "mug", std::nullopt);
  EXPECT_FALSE(known);
  EXPECT_NEAR(scale * 100.0, size_prior("mug").best_m, 0.01);  // kernels extend slightly beyond the mesh
}

}  // namespace
}  // namespace livegs
