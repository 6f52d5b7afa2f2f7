// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

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

void write_ball(const std::filesystem::path& path, double radius) {
  std::filesystem::create_directories(path.parent_path());
  const auto written = write_asset(path, mesh_asset(sphere_mesh(radius, 3), {0.5f, 0.5f, 0.5f}, 3000));
  ASSERT_TRUE(written) << written.error().message;
}

TEST(SceneFolder, PlacesAssetsApartAboveTheFloor) {
  ScratchFolder folder;
  write_ball(folder / "cup.ply", 0.05);
  write_ball(folder / "cup.spz", 0.05);  // the same stem: skipped
  write_ball(folder / "deep/stone.ply", 0.1);
  write_ball(folder / "room.ply", 2.0);
  folder.write("notes.txt", "not an asset");
  folder.write("broken.ply", "ply\nnonsense");  // skipped with a warning
  auto scene = Scene::load(folder.path(), {});
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

TEST(PlaceAsset, ScaleIsGivenKnownOrGuessed) {
  ScratchFolder folder;
  write_ball(folder / "thing.ply", 0.1);
  write_ball(folder / "thing.spz", 0.1);
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
  EXPECT_EQ(place("thing.ply", "bowl", std::nullopt), std::pair(1.0, false));  // 0.2 m fits a bowl
  const auto [scale, known] = place("big.ply", "mug", std::nullopt);
  EXPECT_FALSE(known);
  EXPECT_NEAR(scale * 100.0, size_prior("mug").best_m, 0.01);  // kernels extend slightly beyond the mesh
}

}  // namespace
}  // namespace livegs
