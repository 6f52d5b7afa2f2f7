// SPDX-License-Identifier: Apache-2.0
// The document that is written: valid glTF, and the values where the extensions put them.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "export/gltf_scene.h"
#include "export/usda_scene.h"
#include "gaussian/asset_file.h"
#include "scratch_folder.h"
#include "server/export/gltf_structure.h"
#include "server/export/made_up_scene.h"
#include "server/export/scene_difference.h"

namespace livegs {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Json = nlohmann::json;

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

TEST(GltfScene, DocumentsOfRandomScenesAreValid) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    for (const bool spz : {false, true}) {
      const auto files = encode_gltf_scene(made_up_scene(seed), spz ? "scene.bin" : "", {spz});
      ASSERT_TRUE(files) << files.error().message;
      EXPECT_EQ(joined(gltf_violations(*files)), "") << "seed " << seed << (spz ? ", spz" : "");
    }
  }
}

TEST(GltfScene, AnEmptySceneIsValid) {
  const auto files = encode_gltf_scene({}, "");
  ASSERT_TRUE(files);
  EXPECT_EQ(joined(gltf_violations(*files)), "");
  const auto glb = encode_glb(*files);
  ASSERT_TRUE(glb);
  const auto back = decode_gltf_scene(*glb, {}, "empty.glb");
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_TRUE(back->bodies.empty());
}

TEST(GltfScene, StructureCheckFindsDamage) {
  const auto files = encode_gltf_scene(made_up_scene(3), "");
  ASSERT_TRUE(files);
  const auto violations = [&](const std::string& pointer, const Json& value) {
    GltfFiles damaged = *files;
    Json json = Json::parse(damaged.json);
    json[Json::json_pointer(pointer)] = value;
    damaged.json = json.dump();
    return gltf_violations(damaged).size();
  };
  EXPECT_GT(violations("/bufferViews/1/byteOffset", 2), 0u);
  EXPECT_GT(violations("/accessors/0/count", 1), 0u);
  EXPECT_GT(violations("/accessors/0/min/0", -99), 0u);
  EXPECT_GT(violations("/scenes/0/nodes/0", 99999), 0u);
  EXPECT_GT(violations("/extensionsUsed/0", "OTHER"), 0u);
}

// A chunk of a .glb begins and ends at a multiple of four bytes, and the header has the length.
TEST(GltfScene, GlbHasAlignedChunks) {
  const auto files = encode_gltf_scene(made_up_scene(2), "");
  ASSERT_TRUE(files);
  const auto glb = encode_glb(*files);
  ASSERT_TRUE(glb);
  const auto word = [&](size_t offset) {
    uint32_t value;
    std::memcpy(&value, glb->data() + offset, 4);
    return value;
  };
  EXPECT_EQ(word(8), glb->size());
  const size_t json_bytes = word(12);
  EXPECT_EQ(json_bytes % 4, 0u);
  EXPECT_EQ(word(20 + json_bytes) % 4, 0u);
  EXPECT_EQ(28 + json_bytes + word(20 + json_bytes), glb->size());
  EXPECT_GE(word(20 + json_bytes), files->binary.size());
}

// Velocities are in the space of the node, the inertia is turned from its principal axes to the node.
TEST(GltfScene, MotionIsInTheSpaceOfTheNode) {
  PortableScene scene;
  PortableBody& body = scene.bodies.emplace_back();
  body.name = "box";
  body.behavior = v1::Physics::RIGID;
  body.world_from_object.orientation = Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitY()));
  body.velocity_m_s = {1, 0, 0};
  body.mass_kg = 2;
  body.inertia_kg_m2 = {0.1, 0.2, 0.3};
  const auto files = encode_gltf_scene(scene, "");
  ASSERT_TRUE(files);
  const Json motion =
      Json::parse(files->json)["nodes"][0]["extensions"]["KHR_physics_rigid_bodies"]["motion"];
  EXPECT_EQ(motion["mass"], 2);
  // The node's z axis is the world's x axis.
  EXPECT_NEAR(motion["linearVelocity"][0].get<double>(), 0, 1e-15);
  EXPECT_NEAR(motion["linearVelocity"][2].get<double>(), 1, 1e-15);
  EXPECT_EQ(motion["inertiaDiagonal"], Json({0.1, 0.2, 0.3}));
}

// A hinge leaves its x axis free; both frames of the joint are at one place in the world.
TEST(GltfScene, FramesOfAJointCoincide) {
  PortableScene scene = made_up_scene(5);
  ASSERT_FALSE(scene.joints.empty());
  const auto files = encode_gltf_scene(scene, "");
  ASSERT_TRUE(files);
  const Json json = Json::parse(files->json);
  std::vector<int> parent(json["nodes"].size(), -1);
  for (size_t i = 0; i < parent.size(); ++i) {
    for (const Json& child : json["nodes"][i].value("children", Json::array()))
      parent[child.get<size_t>()] = static_cast<int>(i);
  }
  const auto world_from = [&](size_t node) {
    Pose pose;
    for (int i = static_cast<int>(node); i >= 0; i = parent[static_cast<size_t>(i)]) {
      const Json& one = json["nodes"][static_cast<size_t>(i)];
      Pose own;
      if (one.contains("translation"))
        own.position_m = Vector3d(one["translation"][0].get<double>(), one["translation"][1].get<double>(),
                                  one["translation"][2].get<double>());
      if (one.contains("rotation"))
        own.orientation = Quaterniond(one["rotation"][3].get<double>(), one["rotation"][0].get<double>(),
                                      one["rotation"][1].get<double>(), one["rotation"][2].get<double>());
      pose = own * pose;
    }
    return pose;
  };
  size_t joints = 0;
  for (size_t i = 0; i < parent.size(); ++i) {
    const Json own =
        json["nodes"][i].value("extensions", Json::object()).value("KHR_physics_rigid_bodies", Json());
    if (!own.is_object() || !own.contains("joint")) continue;
    ++joints;
    const Pose a = world_from(i), b = world_from(own["joint"]["connectedNode"].get<size_t>());
    EXPECT_LT((a.position_m - b.position_m).norm(), 1e-12);
    EXPECT_LT(a.orientation.angularDistance(b.orientation), 1e-7);
  }
  EXPECT_EQ(joints, scene.joints.size());
}

// The reader of assets takes the kernels of all bodies, at their places in the world.
TEST(GltfScene, KernelsAreReadAsAnAsset) {
  PortableScene scene = made_up_scene(4);
  scene.animation.reset();
  size_t kernels = 0;
  for (const PortableBody& body : scene.bodies) kernels += body.kernel_count;
  const auto files = encode_gltf_scene(scene, "");
  ASSERT_TRUE(files);
  const auto glb = encode_glb(*files);
  ASSERT_TRUE(glb);
  const auto file = decode_asset(*glb, "scene.glb");
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_EQ(file->asset.size(), kernels);
  // The asset is turned half about x from the world.
  const PortableBody& body = scene.bodies[0];
  for (size_t i = 0; i < body.kernel_count; ++i) {
    const Vector3d world =
        body.world_from_object * (body.object_from_asset * body.asset->positions[i].cast<double>());
    const Vector3d read = file->asset.positions[i].cast<double>();
    EXPECT_LT((world - Vector3d(read.x(), -read.y(), -read.z())).norm(), 1e-5);
    EXPECT_NEAR(file->asset.opacity_logits[i], body.asset->opacity_logits[i], 1e-3);
    EXPECT_LT((file->asset.sh_dc[i] - body.asset->sh_dc[i]).norm(), 1e-6f);
    const float scale = static_cast<float>(std::log(body.object_from_asset.scale));
    EXPECT_LT(
        (file->asset.log_scales[i].array() - scale - body.asset->log_scales[i].array()).abs().maxCoeff(),
        1e-5f);
  }
}

// Positions, scales, orientations, opacities, colours and harmonics of every degree.
TEST(GltfScene, SpzKeepsKernelsWithinItsStep) {
  std::set<int> degrees;
  for (const uint64_t seed : {6, 7, 8}) {
    PortableScene scene = made_up_scene(seed);
    const auto files = encode_gltf_scene(scene, "", {true});
    ASSERT_TRUE(files);
    const auto glb = encode_glb(*files);
    ASSERT_TRUE(glb);
    const auto back = decode_gltf_scene(*glb, {}, "scene.glb");
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(scene_difference(scene, *back, 1e-6, 1e-5, kSpzSteps), "");
    for (const PortableBody& body : scene.bodies) degrees.insert(body.asset->sh_degree);
    // The asset of a single body, as the reader of assets sees it: turned half about x from the world.
    scene.animation.reset();
    scene.bodies.resize(1);
    scene.joints.clear();
    scene.bodies[0].world_from_object = {};
    scene.bodies[0].object_from_asset = {1, Quaterniond(0, 1, 0, 0), Vector3d::Zero()};
    const auto single = encode_gltf_scene(scene, "", {true});
    ASSERT_TRUE(single);
    const auto bytes = encode_glb(*single);
    ASSERT_TRUE(bytes);
    const auto file = decode_asset(*bytes, "scene.glb");
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(kernel_difference(*scene.bodies[0].asset, file->asset, kSpzSteps), "");
  }
  EXPECT_EQ(degrees, std::set<int>({0, 1, 2, 3}));
}

// A scene whose kernels are counted has all else that it has with them.
TEST(GltfScene, KernelsAreCountedByTheirAccessors) {
  for (const bool spz : {false, true}) {
    const PortableScene scene = made_up_scene(6);
    const auto files = encode_gltf_scene(scene, "", {spz});
    ASSERT_TRUE(files);
    const auto glb = encode_glb(*files);
    ASSERT_TRUE(glb);
    const auto decoded = decode_gltf_scene(*glb, {}, "scene.glb");
    ASSERT_TRUE(decoded) << decoded.error().message;
    auto counted = decode_gltf_scene(*glb, {}, "scene.glb", {.kernels = false});
    ASSERT_TRUE(counted) << counted.error().message;
    ASSERT_EQ(counted->bodies.size(), scene.bodies.size());
    for (size_t i = 0; i < scene.bodies.size(); ++i) {
      EXPECT_GT(counted->bodies[i].kernel_count, 0u);
      EXPECT_EQ(counted->bodies[i].kernel_count, decoded->bodies[i].kernel_count) << scene.bodies[i].name;
      EXPECT_FALSE(counted->bodies[i].asset);
      counted->bodies[i].asset = decoded->bodies[i].asset;
    }
    EXPECT_EQ(scene_difference(*decoded, *counted, 1e-12, 1e-12), "");
    EXPECT_EQ(joined(counted->notes), joined(decoded->notes));
  }
}

// Kernels that cannot be decoded do not prevent their count; one that the file cannot hold is refused.
TEST(GltfScene, CountedKernelsAreNotDecoded) {
  for (const bool spz : {false, true}) {
    auto files = encode_gltf_scene(made_up_scene(6), "", {spz});
    ASSERT_TRUE(files);
    Json json = Json::parse(files->json);
    for (Json& mesh : json["meshes"]) {
      for (Json& primitive : mesh["primitives"]) {
        Json& extensions = primitive["extensions"];
        if (!extensions.is_object() || !extensions.contains("KHR_gaussian_splatting")) continue;
        if (!spz) {
          primitive["attributes"].erase("KHR_gaussian_splatting:ROTATION");
          continue;
        }
        const size_t view = extensions["KHR_gaussian_splatting"]["extensions"]
                                      ["KHR_gaussian_splatting_compression_spz_2"]["bufferView"];
        const size_t at = json["bufferViews"][view].value("byteOffset", size_t{0});
        files->binary[at] ^= std::byte{0xff};  // no gzip any more
      }
    }
    files->json = json.dump();
    const auto glb = encode_glb(*files);
    ASSERT_TRUE(glb);
    EXPECT_FALSE(decode_gltf_scene(*glb, {}, "bad.glb"));
    const auto counted = decode_gltf_scene(*glb, {}, "bad.glb", {.kernels = false});
    ASSERT_TRUE(counted) << counted.error().message;
    const PortableScene scene = made_up_scene(6);
    for (size_t i = 0; i < scene.bodies.size(); ++i)
      EXPECT_EQ(counted->bodies[i].kernel_count, scene.bodies[i].kernel_count);

    for (Json& accessor : json["accessors"]) accessor["count"] = 4000000000000000000;
    files->json = json.dump();
    const auto huge = encode_glb(*files);
    ASSERT_TRUE(huge);
    const auto refused = decode_gltf_scene(*huge, {}, "huge.glb", {.kernels = false});
    ASSERT_FALSE(refused);
    EXPECT_TRUE(refused.error().message.starts_with("huge.glb: ")) << refused.error().message;
  }
}

// Each body of a mixed scene keeps its own mark; as one asset, all kernels have it, and a note says so.
TEST(GltfScene, AntialiasedMarkIsOfTheMesh) {
  PortableScene scene;
  const GaussianAsset plain = *made_up_scene(1).bodies[0].asset;
  for (const bool marked : {true, false, true, false}) {
    PortableBody& body = scene.bodies.emplace_back();
    body.name = std::to_string(scene.bodies.size());
    body.drawn_only = true;
    GaussianAsset asset = plain;
    asset.antialiased = marked;
    body.kernel_count = asset.size();
    body.asset = std::make_shared<const GaussianAsset>(std::move(asset));
  }
  for (const bool spz : {false, true}) {
    const auto files = encode_gltf_scene(scene, "", {spz});
    ASSERT_TRUE(files);
    EXPECT_EQ(joined(gltf_violations(*files)), "");
    const auto glb = encode_glb(*files);
    ASSERT_TRUE(glb);
    const auto back = decode_gltf_scene(*glb, {}, "mixed.glb");
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(scene_difference(scene, *back, 1e-6, 1e-5, spz ? kSpzSteps : KernelSteps{}), "") << spz;
    const auto file = decode_asset(*glb, "mixed.glb");
    ASSERT_TRUE(file);
    EXPECT_TRUE(file->asset.antialiased);
    ASSERT_EQ(file->notes.size(), 1u);
    EXPECT_NE(file->notes[0].find("antialiased"), std::string::npos) << file->notes[0];
  }
  const auto stage = decode_usda_scene(encode_usda_scene(scene), "mixed.usda");
  ASSERT_TRUE(stage) << stage.error().message;
  EXPECT_EQ(scene_difference(scene, *stage, 1e-6, 1e-6), "");
  EXPECT_EQ(Json::parse(encode_gltf_scene(scene, "")->json)["meshes"].size(), 2u);
}

// A body that a recording adds is not drawn without the animation.
TEST(GltfScene, LaterBodiesAreLeftOutOfTheAsset) {
  PortableScene scene;
  for (const char* name : {"box", "ball"}) {
    PortableBody& body = scene.bodies.emplace_back();
    body.name = name;
    body.drawn_only = true;
    body.asset = made_up_scene(1).bodies[0].asset;
    body.kernel_count = body.asset->size();
  }
  scene.animation = PortableAnimation{{0, 0.1, 0.2}, {{1, 1, {Pose{}, Pose{}}, {}}}};
  const auto files = encode_gltf_scene(scene, "");
  ASSERT_TRUE(files);
  EXPECT_EQ(joined(gltf_violations(*files)), "");
  const auto glb = encode_glb(*files);
  ASSERT_TRUE(glb);
  const auto file = decode_asset(*glb, "scene.glb");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->asset.size(), scene.bodies[0].kernel_count);
}

// Equal assets are stored once.
TEST(GltfScene, EqualAssetsShareAMesh) {
  PortableScene scene;
  const GaussianAsset asset = *made_up_scene(1).bodies[0].asset;
  for (int i = 0; i < 3; ++i) {
    PortableBody& body = scene.bodies.emplace_back();
    body.name = std::to_string(i);
    body.drawn_only = true;
    body.asset = std::make_shared<const GaussianAsset>(asset);
    body.kernel_count = asset.size();
  }
  const auto files = encode_gltf_scene(scene, "");
  ASSERT_TRUE(files);
  EXPECT_EQ(Json::parse(files->json)["meshes"].size(), 1u);
}

// A document of other programs: no LIVEGS_physics, colliders on the node of the body, mesh by node.
TEST(GltfScene, ReadsPhysicsOfOtherPrograms) {
  const std::string text = R"({
    "asset": { "version": "2.0" }, "scene": 0, "scenes": [ { "nodes": [ 0, 1 ] } ],
    "extensions": {
      "KHR_implicit_shapes": { "shapes": [ { "type": "box", "box": { "size": [1, 2, 3] } },
                                           { "type": "plane", "plane": {} } ] },
      "KHR_physics_rigid_bodies": {
        "physicsMaterials": [ { "staticFriction": 0.9, "dynamicFriction": 0.7, "restitution": 0.1 } ],
        "physicsJoints": [ { "limits": [ { "linearAxes": [0, 1, 2], "min": 0, "max": 0 },
                                         { "angularAxes": [0, 1], "min": 0, "max": 0 } ] } ] } },
    "nodes": [
      { "name": "crate", "translation": [0, 1, 0], "children": [ 2 ], "extensions": { "KHR_physics_rigid_bodies": {
          "motion": { "mass": 5 }, "collider": { "geometry": { "shape": 0 }, "physicsMaterial": 0 } } } },
      { "name": "floor", "extensions": { "KHR_physics_rigid_bodies": { "collider": { "geometry": { "shape": 1 } } } },
        "children": [ 3 ] },
      { "translation": [0.5, 0, 0], "extensions": { "KHR_physics_rigid_bodies": {
          "joint": { "connectedNode": 3, "joint": 0 } } } },
      { "translation": [0.5, 1, 0] } ] })";
  const auto scene = decode_gltf_scene(std::as_bytes(std::span(text)), {}, "crate.gltf");
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->bodies.size(), 1u);
  EXPECT_EQ(scene->bodies[0].mass_kg, 5);
  EXPECT_EQ(scene->bodies[0].friction, 0.7);
  ASSERT_EQ(scene->bodies[0].shapes.size(), 1u);
  EXPECT_EQ(scene->bodies[0].shapes[0].size_m, Vector3d(1, 2, 3));
  ASSERT_EQ(scene->fixed.size(), 1u);
  EXPECT_EQ(scene->fixed[0].kind, PortableShape::Kind::Plane);
  ASSERT_EQ(scene->joints.size(), 1u);
  EXPECT_TRUE(scene->joints[0].hinge);
  EXPECT_FALSE(scene->joints[0].other);
  EXPECT_LT((scene->joints[0].axis - Vector3d::UnitZ()).norm(), 1e-12);
}

TEST(GltfScene, WritesTheBinaryNextToTheDocument) {
  ScratchFolder folder;
  const PortableScene scene = made_up_scene(7);
  const auto written = write_gltf_scene(folder / "a b.gltf", scene);
  ASSERT_TRUE(written) << written.error().message;
  ASSERT_EQ(written->size(), 2u);
  EXPECT_EQ((*written)[1].filename(), "a b.bin");
  const auto back = read_gltf_scene(folder / "a b.gltf");
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->bodies.size(), scene.bodies.size());
  EXPECT_TRUE(read_asset(folder / "a b.gltf"));
}

}  // namespace
}  // namespace livegs
