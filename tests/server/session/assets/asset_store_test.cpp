// SPDX-License-Identifier: Apache-2.0
// Lifetime of assets while a scene is reset and its objects are cut again.
#include "session/assets/asset_store.h"

#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "common/gaussian/synthetic_asset.h"
#include "scene/build/fragile_object.h"
#include "scene/scene.h"

namespace livegs {
namespace {

// A tough box and two fragile ones on a floor.
Scene fragile_scene(uint32_t first_object_id) {
  v1::Scene file;
  const auto parsed = google::protobuf::util::JsonStringToMessage(R"({
    "environment": { "colliders": [ { "plane": {} } ] },
    "objects": [
      { "name": "tough", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [-0.5, 0.1, 0] },
        "physics": { "behavior": "RIGID", "mass_kg": 1 } },
      { "name": "box", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0, 0.1, 0] },
        "physics": { "behavior": "RIGID", "mass_kg": 1, "fragile": true, "break_impulse_n_s": 2, "fracture_pieces": 8 } },
      { "name": "same", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0.5, 0.1, 0] },
        "physics": { "behavior": "RIGID", "mass_kg": 1, "fragile": true, "break_impulse_n_s": 2, "fracture_pieces": 8 } } ] })",
                                                                  &file);
  EXPECT_TRUE(parsed.ok()) << parsed.message();
  SceneOptions options;
  options.first_object_id = first_object_id;
  auto scene = Scene::build(file, ".", "fragile", options);
  EXPECT_TRUE(scene) << scene.error().message;
  return std::move(*scene);
}

void add_all(const Scene& scene, AssetStore& store) {
  for (const SceneObject& object : scene.objects()) {
    (void)store.add(object.asset);
    if (object.broken) (void)store.add(object.broken->asset);
  }
}

bool has(const AssetStore& store, const std::string& hash) {
  const std::vector<std::string> all = store.hashes();
  return std::find(all.begin(), all.end(), hash) != all.end();
}

TEST(AssetStore, KeepsSmallEditsAsLongAsTheirAsset) {
  AssetStore store;
  auto base = std::make_shared<GaussianAsset>(synthetic_asset(1000, 1, 2));
  auto asset = std::make_shared<GaussianAsset>(*base);
  asset->resize(990);
  const auto other = std::make_shared<GaussianAsset>(synthetic_asset(1000, 1, 3));
  const std::string from = store.add(base)->hash, to = store.add(asset, base)->hash;
  const auto edit = store.find_bytes(to, from);
  ASSERT_TRUE(edit);
  EXPECT_LT(edit->size(), 300u);
  EXPECT_EQ(store.find_bytes(from, to), nullptr) << "made on request only";
  (void)store.add(base, asset);
  EXPECT_NE(store.find_bytes(from, to), nullptr);
  const std::string third = store.add(other, base)->hash;
  EXPECT_NE(store.find_bytes(third, ""), nullptr);
  EXPECT_EQ(store.find_bytes(third, from), nullptr) << "no kernel in common";
  EXPECT_EQ(store.find_bytes(from, from), nullptr);
  asset.reset();
  store.drop_unused({}, 0);
  EXPECT_NE(store.find_bytes(to, from), nullptr) << "clients may still fetch it";
  store.drop_unused({}, kUnusedAssetLifetime_ns);
  EXPECT_EQ(store.find_bytes(to, from), nullptr);
}

TEST(AssetStore, IsUnchangedAfterTenResets) {
  AssetStore store;
  Scene scene = fragile_scene(1);
  add_all(scene, store);
  const std::vector<std::string> first = store.hashes();
  EXPECT_EQ(first.size(), 6u);  // the floor, three boxes and the fragments of two
  for (uint32_t reset = 1; reset <= 10; ++reset) {
    Scene next = fragile_scene((reset << 20) + 1);
    add_all(next, store);
    scene = std::move(next);
    EXPECT_EQ(store.hashes(), first) << "reset " << reset;
    store.drop_unused({}, reset * kUnusedAssetLifetime_ns);
    EXPECT_EQ(store.hashes(), first) << "reset " << reset;
  }
}

TEST(AssetStore, DropsUnusedAssetsAfterTheirLifetime) {
  AssetStore store;
  Scene scene = fragile_scene(1);
  add_all(scene, store);
  const SceneObject& box = *scene.find("box");
  const std::string before = store.add(box.broken->asset)->hash;
  v1::PhysicalParameters edited = box.physics;
  edited.set_fracture_pieces(12);
  const auto set = scene.set_physics(box.id, edited);
  ASSERT_TRUE(set) << set.error().message;
  const std::string after = store.add(box.broken->asset)->hash;
  ASSERT_NE(before, after);

  store.drop_unused({before}, 0);
  store.drop_unused({before}, 2 * kUnusedAssetLifetime_ns);
  EXPECT_TRUE(has(store, before)) << "clients know it";
  const int64_t replaced_ns = 2 * kUnusedAssetLifetime_ns + 1;
  store.drop_unused({after}, replaced_ns);
  store.drop_unused({after}, replaced_ns + kUnusedAssetLifetime_ns - 1);
  EXPECT_TRUE(has(store, before)) << "a client may still be about to fetch it";
  const auto sending = store.find(before);
  store.drop_unused({after}, replaced_ns + kUnusedAssetLifetime_ns);
  EXPECT_FALSE(has(store, before));
  EXPECT_FALSE(store.find(before));
  EXPECT_EQ(sending->hash, before);
  EXPECT_TRUE(has(store, after));
  EXPECT_EQ(store.hashes().size(), 6u);
}

}  // namespace
}  // namespace livegs
