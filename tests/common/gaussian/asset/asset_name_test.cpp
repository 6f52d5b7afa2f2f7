// SPDX-License-Identifier: Apache-2.0
#include "gaussian/asset_name.h"

#include <gtest/gtest.h>

#include "core/text/path_ending.h"

namespace livegs {
namespace {

TEST(AssetName, EndingsAreKnownInAnyLetterCase) {
  for (const auto& [name, ending] :
       {std::pair("a.ply", ".ply"), std::pair("SCAN.PLY", ".ply"), std::pair("x/Vase.Spz", ".spz"),
        std::pair("a.Compressed.Ply", ".compressed.ply"), std::pair("cup.SPLAT", ".splat"),
        std::pair("m.GLB", ".glb"), std::pair("m.glTF", ".gltf"), std::pair("s.SoG", ".sog"),
        std::pair("Grüße.PLY", ".ply")})
    EXPECT_EQ(asset_ending(name), ending) << name;
  for (const char* name : {"", "ply", ".ply", "x/.spz", "a.ply.txt", "a.obj", "a.scene.json", "folder.ply/"})
    EXPECT_FALSE(asset_ending(name)) << name;
}

TEST(AssetName, StemsLoseEndingsAndIndexes) {
  EXPECT_EQ(asset_stem("a/Vase.SPZ"), "a/Vase");
  EXPECT_EQ(asset_stem("a/vase.compressed.ply"), "a/vase");
  EXPECT_EQ(asset_stem("a/ball/lod-meta.json"), "a/ball");
  EXPECT_EQ(asset_stem("a/ball/META.json"), "a/ball");
  EXPECT_EQ(asset_stem("a/ball"), "a/ball");
  EXPECT_TRUE(is_asset_index("Lod-Meta.JSON"));
  EXPECT_FALSE(is_asset_index("room.scene.json"));
}

TEST(AssetName, HasEndingIgnoresTheCase) {
  EXPECT_TRUE(has_ending("Room.SCENE.json", ".scene.json"));
  EXPECT_FALSE(has_ending("json", ".scene.json"));
  EXPECT_EQ(lower_case("ÄB-9"), "Äb-9");
}

}  // namespace
}  // namespace livegs
