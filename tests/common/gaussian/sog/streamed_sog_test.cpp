// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "common/gaussian/asset/expect_invariants.h"
#include "common/gaussian/differences.h"
#include "common/gaussian/synthetic_asset.h"
#include "core/file.h"
#include "gaussian/asset_file.h"
#include "gaussian/sog/sog_files.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kSogFiles[] = {"meta.json",   "means_l.webp", "means_u.webp",       "quats.webp",
                                     "scales.webp", "sh0.webp",     "shN_centroids.webp", "shN_labels.webp"};

class StreamedSog : public testing::Test {
 protected:
  // Writes a chunk as an unbundled .sog.
  void write_chunk(const std::string& name, const GaussianAsset& asset) {
    const auto bundle = encode_sog(asset);
    ASSERT_TRUE(bundle);
    const auto files = open_sog_bundle(*bundle, name);
    ASSERT_TRUE(files);
    fs::create_directories(folder_ / name);
    for (const char* file : kSogFiles) {
      const auto bytes = (*files)->read(file);
      if (bytes) {
        ASSERT_TRUE(write_file_atomically(folder_ / name / file, *bytes));
      }
    }
  }
  Json leaf(std::initializer_list<std::array<size_t, 4>> levels) {  // level, file, offset, count
    Json lods;
    for (const auto& [level, file, offset, count] : levels)
      lods[std::to_string(level)] = {{"file", file}, {"offset", offset}, {"count", count}};
    return {{"bound", Json::object()}, {"lods", lods}};
  }
  void write_index(const Json& json) {
    ASSERT_TRUE(write_file_atomically(folder_ / "lod-meta.json", json.dump()));
  }
  // Two fine chunks, the second of degree 1, and a coarse one for both leaves.
  Json usual() {
    first_ = synthetic_asset(120, 0, 90);
    second_ = synthetic_asset(150, 1, 91);
    write_chunk("0_0", first_);
    write_chunk("0_1", second_);
    write_chunk("1_0", synthetic_asset(40, 0, 92));
    return {
        {"version", 1},
        {"lodLevels", 2},
        {"environment", nullptr},
        {"filenames", {"0_0/meta.json", "0_1/meta.json", "1_0/meta.json"}},
        {"tree",
         {{"children", {leaf({{0, 0, 0, 120}, {1, 2, 0, 20}}), leaf({{1, 2, 20, 20}, {0, 1, 0, 150}})}}}}};
  }

  const ScratchFolder folder_;
  GaussianAsset first_, second_;
};

TEST_F(StreamedSog, FinestLevelIsOneObject) {
  write_index(usual());
  for (const fs::path& path : {folder_.path(), folder_ / "lod-meta.json"}) {
    const auto file = read_asset(path);
    ASSERT_TRUE(file) << file.error().message;
    ASSERT_EQ(file->asset.size(), 270u);
    EXPECT_EQ(file->asset.sh_degree, 1);
    expect_invariants(file->asset, "streamed");
    EXPECT_EQ(file->format, AssetFormat::Sog);
    EXPECT_EQ(file->notes.size(), 1u);
    GaussianAsset both = first_;
    both.sh_rest.assign(360, Eigen::Vector3f::Zero());
    both.sh_degree = 1;
    both.resize(270);
    for (size_t i = 0; i < 150; ++i) {
      both.positions[120 + i] = second_.positions[i];
      both.log_scales[120 + i] = second_.log_scales[i];
      both.rotations[120 + i] = second_.rotations[i];
      both.opacity_logits[120 + i] = second_.opacity_logits[i];
      both.sh_dc[120 + i] = second_.sh_dc[i];
      for (size_t k = 0; k < 3; ++k) both.sh_rest[3 * (120 + i) + k] = second_.sh_rest[3 * i + k];
    }
    const auto partner = match_by_position(both, file->asset, 1e-3f);
    ASSERT_EQ(partner.size(), 270u);
    EXPECT_LE(differences(both, file->asset, partner).sh1, 0.02f);
  }
}

// Leaves that lack the finest level are drawn at their own finest; parts of a chunk are taken as ranges.
TEST_F(StreamedSog, LeavesUseTheirOwnFinestLevel) {
  Json index = usual();
  index["tree"]["children"] = {leaf({{1, 2, 0, 20}}), leaf({{0, 1, 100, 50}, {1, 2, 20, 20}}),
                               leaf({{0, 1, 120, 30}})};
  index["environment"] = "env/meta.json";
  write_index(index);
  const auto file = read_asset(folder_.path());
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->asset.size(), 70u);  // 20 and 50; a kernel that two leaves name is there once
  EXPECT_EQ(file->notes.size(), 2u);
}

TEST_F(StreamedSog, BundledChunksAreRead) {
  Json index = usual();
  ASSERT_TRUE(write_file_atomically(folder_ / "a.SOG", *encode_sog(first_)));
  index["filenames"] = {"a.SOG", "0_1/meta.json", "1_0/meta.json"};
  write_index(index);
  const auto file = read_asset(folder_ / "lod-meta.json");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->asset.size(), 270u);
}

TEST_F(StreamedSog, DamagedIndexesAreRefusedInOneLine) {
  const Json good = usual();
  const auto refused = [&](const std::function<void(Json&)>& change, const std::string& reason) {
    Json json = good;
    change(json);
    write_index(json);
    const auto file = read_asset(folder_.path());
    ASSERT_FALSE(file) << reason;
    EXPECT_NE(file.error().message.find(reason), std::string::npos) << file.error().message;
    EXPECT_EQ(file.error().message.find('\n'), std::string::npos);
  };
  refused([](Json& j) { j.erase("filenames"); }, "filenames");
  refused([](Json& j) { j["filenames"][0] = "../x/meta.json"; }, "below the folder");
  refused([](Json& j) { j["filenames"][0] = "/etc/meta.json"; }, "below the folder");
  refused([](Json& j) { j["filenames"][1] = j["filenames"][0]; }, "repeats");
  refused([](Json& j) { j["filenames"][1] = "0_0/./meta.json"; }, "repeats");
  refused([](Json& j) { j["filenames"][0] = "0_0/me\nta.json"; }, "below the folder");
  refused([](Json& j) { j["filenames"][0] = "gone/meta.json"; }, "gone");
  refused([](Json& j) { j.erase("tree"); }, "tree");
  refused([](Json& j) { j["tree"] = Json::object(); }, "no level");
  refused([](Json& j) { j["tree"]["children"][0]["lods"]["0"]["file"] = 9; }, "file or count");
  refused([](Json& j) { j["tree"]["children"][0]["lods"]["0"]["count"] = 121; }, "beyond the 120");
  refused([](Json& j) { j["tree"]["children"][0]["lods"]["0"]["offset"] = UINT64_MAX; }, "beyond the 120");
  refused([](Json& j) { j["tree"]["children"][0]["lods"]["0"]["count"] = -1; }, "file or count");
  refused([](Json& j) { j["tree"]["children"][0]["lods"]["fine"] = 1; }, "whole number");
  refused([](Json& j) { j["tree"]["children"][0] = 3; }, "not an object");
  std::string nest;
  while (nest.size() < 1000000) nest += "{\"children\":[";
  ASSERT_TRUE(write_file_atomically(folder_ / "lod-meta.json", nest));
  EXPECT_FALSE(read_asset(folder_.path()));
  // Mutations of the text: an asset or one line.
  const std::string text = good.dump();
  uint32_t state = 1;
  for (int i = 0; i < 300; ++i) {
    std::string changed = text;
    for (int k = 0; k < 3; ++k) {
      state = state * 1664525 + 1013904223;
      changed[(state >> 8) % changed.size()] = static_cast<char>(32 + state % 95);
    }
    ASSERT_TRUE(write_file_atomically(folder_ / "lod-meta.json", changed));
    const auto file = read_asset(folder_.path());
    if (file) {
      expect_invariants(file->asset, changed);
    } else {
      EXPECT_EQ(file.error().message.find('\n'), std::string::npos) << file.error().message;
    }
  }
}

}  // namespace
}  // namespace livegs
