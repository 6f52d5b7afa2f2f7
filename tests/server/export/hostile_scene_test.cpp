// SPDX-License-Identifier: Apache-2.0
// Readers of scenes accept any bytes.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>
#include <utility>

#include "export/gltf_scene.h"
#include "export/usda_scene.h"
#include "server/export/made_up_scene.h"

namespace livegs {
namespace {

using Json = nlohmann::json;

std::vector<std::byte> glb_of(const PortableScene& scene) {
  const auto files = encode_gltf_scene(scene, "");
  EXPECT_TRUE(files);
  auto glb = encode_glb(*files);
  EXPECT_TRUE(glb);
  return std::move(*glb);
}

// An error is one line that names the file.
template <class Read>
void expect_named(const Read& read, const char* name) {
  if (read) return;
  EXPECT_TRUE(read.error().message.starts_with(name)) << read.error().message;
  EXPECT_EQ(read.error().message.find('\n'), std::string::npos) << read.error().message;
}

TEST(HostileScene, TruncatedGlbIsRefused) {
  const std::vector<std::byte> glb = glb_of(made_up_scene(1));
  for (size_t length = 0; length < glb.size(); length += 1 + length / 50) {
    const auto read = decode_gltf_scene(std::span(glb).first(length), {}, "cut.glb");
    EXPECT_FALSE(read) << length;
    expect_named(read, "cut.glb");
  }
}

TEST(HostileScene, ChangedBytesOfAGlbGiveASceneOrAnError) {
  const std::vector<std::byte> glb = glb_of(made_up_scene(2));
  std::mt19937 random(1);
  for (int round = 0; round < 1500; ++round) {
    std::vector<std::byte> changed = glb;
    for (unsigned i = 0; i < 1 + random() % 8; ++i)
      changed[random() % changed.size()] = static_cast<std::byte>(random() % 256);
    expect_named(decode_gltf_scene(changed, {}, "changed.glb"), "changed.glb");
  }
}

void collect_pointers(const Json& json, const Json::json_pointer& at, std::vector<Json::json_pointer>& all) {
  all.push_back(at);
  if (json.is_object()) {
    for (const auto& [key, value] : json.items()) collect_pointers(value, at / key, all);
  } else if (json.is_array()) {
    for (size_t i = 0; i < json.size(); ++i) collect_pointers(json[i], at / i, all);
  }
}

// Valid JSON with one value replaced reaches all checks of indices, lengths and ranges.
TEST(HostileScene, ReplacedValuesGiveASceneOrAnError) {
  const auto files = encode_gltf_scene(made_up_scene(3), "");
  ASSERT_TRUE(files);
  const Json original = Json::parse(files->json);
  std::vector<Json::json_pointer> pointers;
  collect_pointers(original, Json::json_pointer(), pointers);
  const std::vector<Json> values = {nullptr,
                                    -1,
                                    0,
                                    1e300,
                                    99999999,
                                    0.5,
                                    "x",
                                    Json::array(),
                                    Json::object(),
                                    true,
                                    Json::array({1, 2, 3}),
                                    Json::array({Json::object()})};
  std::mt19937 random(2);
  size_t refused = 0;
  size_t tried = 0;
  Json changed = original;
  GltfFiles damaged = *files;
  for (size_t p = 1; p < pointers.size(); p += 1 + random() % 8) {  // the first is the whole document
    const Json before = std::exchange(changed[pointers[p]], values[random() % values.size()]);
    damaged.json = changed.dump();
    changed[pointers[p]] = before;
    const auto glb = encode_glb(damaged);
    ASSERT_TRUE(glb);
    const auto read = decode_gltf_scene(*glb, {}, "replaced.glb");
    expect_named(read, "replaced.glb");
    expect_named(decode_gltf_scene(*glb, {}, "replaced.glb", {.kernels = false}), "replaced.glb");
    refused += read ? 0 : 1;
    ++tried;
  }
  EXPECT_GT(refused, tried / 20) << "the checks are reached";
}

TEST(HostileScene, DeepAndRepeatedDataIsBounded) {
  // Many nodes that share one collider mesh.
  const auto files = encode_gltf_scene(made_up_scene(5), "");
  ASSERT_TRUE(files);
  Json json = Json::parse(files->json);
  Json node;
  for (const Json& one : json["nodes"]) {
    if (one.value("name", "").ends_with("collider") && one.dump().find("\"mesh\"") != std::string::npos)
      node = one;
  }
  ASSERT_TRUE(node.is_object());
  std::vector<std::byte> big(64 * 1024);
  GltfFiles damaged = *files;
  const size_t mesh = node["extensions"]["KHR_physics_rigid_bodies"]["collider"]["geometry"]["mesh"];
  Json& position =
      json["accessors"][json["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"].get<size_t>()];
  json["bufferViews"].push_back(
      {{"buffer", 0}, {"byteOffset", damaged.binary.size()}, {"byteLength", big.size()}});
  position["bufferView"] = json["bufferViews"].size() - 1;
  position["count"] = big.size() / 12;
  damaged.binary.insert(damaged.binary.end(), big.begin(), big.end());
  json["buffers"][0]["byteLength"] = damaged.binary.size();
  for (int i = 0; i < 2000; ++i) {
    json["nodes"].push_back(node);
    json["scenes"][0]["nodes"].push_back(json["nodes"].size() - 1);
  }
  damaged.json = json.dump();
  const auto glb = encode_glb(damaged);
  ASSERT_TRUE(glb);
  const auto read = decode_gltf_scene(*glb, {}, "repeated.glb");
  ASSERT_FALSE(read);
  EXPECT_EQ(
      read.error().message,
      "repeated.glb: repeats its numbers more often than a file of its size may; export the file again");
  // A chain of nested lists where a message is expected.
  const std::string deep(100000, '['), close(100000, ']');
  const std::string text =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"extensions":
      {"LIVEGS_physics":{"behavior":"RIGID","estimates":)" +
      deep + close + "}}}]}";
  EXPECT_FALSE(decode_gltf_scene(std::as_bytes(std::span(text)), {}, "deep.gltf"));
  EXPECT_FALSE(decode_usda_scene("#usda 1.0\n(\n x = " + deep, "deep.usda"));
  std::string prims = "#usda 1.0\n";
  for (int i = 0; i < 100000; ++i) prims += "def \"a\" { ";
  EXPECT_FALSE(decode_usda_scene(prims, "deep.usda"));
}

TEST(HostileScene, CutAndChangedUsdaGivesASceneOrAnError) {
  const std::string text = encode_usda_scene(made_up_scene(4));
  for (size_t length = 0; length + 2 < text.size(); length += 1 + length / 200) {
    const auto read = decode_usda_scene(text.substr(0, length), "cut.usda");
    if (length > text.find("\n{")) EXPECT_FALSE(read) << length;  // the head alone is a stage without prims
    expect_named(read, "cut.usda");
  }
  std::mt19937 random(3);
  static constexpr char kLetters[] = "{}[]()\"'<>@=:,.#-0123456789eEinfdc \n\\x/*\xff";
  for (int round = 0; round < 1500; ++round) {
    std::string changed = text;
    for (unsigned i = 0; i < 1 + random() % 4; ++i)
      changed[random() % changed.size()] = kLetters[random() % (sizeof kLetters - 1)];
    expect_named(decode_usda_scene(changed, "changed.usda"), "changed.usda");
  }
}

TEST(HostileScene, ErrorsNameTheEntry) {
  const auto files = encode_gltf_scene(made_up_scene(1), "");
  ASSERT_TRUE(files);
  const auto message = [&](const std::string& pointer, const Json& value) {
    Json json = Json::parse(files->json);
    json[Json::json_pointer(pointer)] = value;
    GltfFiles damaged = *files;
    damaged.json = json.dump();
    const auto glb = encode_glb(damaged);
    const auto read = decode_gltf_scene(*glb, {}, "bad.glb");
    return read ? std::string("none") : read.error().message;
  };
  EXPECT_EQ(message("/nodes/0/rotation", Json({0, 0, 0, 0})),
            "bad.glb: nodes[0] has no valid rotation; export the file again");
  EXPECT_EQ(message("/nodes/0/extensions/LIVEGS_physics/behavior", "LIQUID"),
            "bad.glb: nodes[0] has an unknown LIVEGS_physics.behavior; export the file again");
  EXPECT_EQ(message("/scenes/0/nodes/0", 4000), "bad.glb: refers to an entry of nodes that does not exist");
  EXPECT_EQ(message("/extensions/LIVEGS_physics/gravity_m_s2", Json({0, "down", 0})),
            "bad.glb: LIVEGS_physics has no valid gravity_m_s2; export the file again");
}

}  // namespace
}  // namespace livegs
