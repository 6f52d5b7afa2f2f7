// SPDX-License-Identifier: Apache-2.0
// A recording of a running scene as animation of the exported one.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "core/content_hash.h"
#include "export/collect_recording.h"
#include "export/collect_scene.h"
#include "export/gltf_scene.h"
#include "export/usda_scene.h"
#include "gaussian/asset_file.h"
#include "gaussian/progressive_asset.h"
#include "recording/recording_writer.h"
#include "scene/build/fragile_object.h"
#include "scene/scene.h"
#include "scratch_folder.h"
#include "server/export/gltf_structure.h"
#include "server/export/scene_difference.h"
#include "wire/rest_body_codec.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

constexpr double kGrid_m = 1e-3;  // of a recorded position; the streams are coded on a grid

// A block that breaks on the floor, a soft cube that falls, a box, and a ball that is shot at 0.2 s.
constexpr const char* kScene = R"({
  "rate_hz": 60,
  "environment": { "colliders": [ { "plane": {} } ] },
  "objects": [
    { "name": "cup", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0, 0.5, 0] },
      "physics": { "behavior": "RIGID", "mass_kg": 1, "fragile": true, "break_impulse_n_s": 1, "fracture_pieces": 4 } },
    { "name": "cube", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } },
      "pose": { "position_m": [1, 0.3, 0], "orientation": [0.9238795, 0, 0.3826834, 0] },
      "physics": { "behavior": "ELASTIC", "density_kg_m3": 300, "youngs_modulus_pa": 2e4 } },
    { "name": "box", "shape": { "box": { "size_m": [0.1, 0.1, 0.1] } }, "pose": { "position_m": [-1, 0.05, 0] },
      "physics": { "behavior": "RIGID", "mass_kg": 1 } } ],
  "events": [ { "time_s": 0.2, "ball": { "from_m": [-2, 0.05, 0], "velocity_m_s": [5, 0, 0] } } ] })";

struct Recorded {
  std::map<std::string, Vector3d> last_centre_m;  // of the whole objects: rest point zero in the world
  std::vector<Eigen::Vector3f> last_nodes_m;      // of the cube
  uint64_t broken_at = 0;                         // tick
  size_t broken_kernels = 0;
  size_t ticks = 0;
};

// Runs the scene for `ticks` and records it, as the server does.
Recorded record(const std::filesystem::path& scene_path, const std::filesystem::path& path, size_t ticks,
                bool with_assets) {
  Recorded seen;
  auto scene = Scene::load(scene_path, {});
  EXPECT_TRUE(scene) << scene.error().message;
  v1::RecordingStart start;
  start.set_rate_hz(60);
  *start.mutable_scene() = scene->source();
  auto writer = RecordingWriter::create(path, start);
  EXPECT_TRUE(writer);
  std::set<std::string> stored;
  const auto describe = [&](const SceneObject& object) {
    v1::ObjectDescription description;
    description.set_object_id(object.id);
    description.set_name(object.name);
    description.set_environment(object.environment);
    const std::string hash = content_hash(encode_ply(*object.asset));
    description.set_asset_hash(hash);
    const auto rest = encode_rest_body(object.rest);
    description.set_rest_body(rest.data(), rest.size());
    if (with_assets && stored.insert(hash).second)
      EXPECT_TRUE(writer->add_asset(hash, encode_progressive(*object.asset)));
    return description;
  };
  for (uint64_t tick = 1; tick <= ticks; ++tick) {
    const auto event = [&](const auto& fill) {
      v1::SessionEvent one;
      fill(one);
      EXPECT_TRUE(writer->add_event(tick, one));
    };
    if (tick == 1) {
      for (const SceneObject& object : scene->objects())
        event([&](v1::SessionEvent& one) { *one.mutable_object_added() = describe(object); });
      scene->take_changes();
    }
    scene->step();
    const Scene::Changes changes = scene->take_changes();
    for (const uint32_t id : changes.added)
      event([&](v1::SessionEvent& one) { *one.mutable_object_added() = describe(*scene->find(id)); });
    for (const uint32_t id : changes.changed) {
      const SceneObject& object = *scene->find(id);
      if (object.rest.revision > 0 && seen.broken_at == 0) {
        seen.broken_at = tick;
        seen.broken_kernels = object.asset->size();
      }
      event([&](v1::SessionEvent& one) { *one.mutable_object_changed() = describe(object); });
    }
    DriverFrame frame = scene->world().drivers();
    frame.tick = tick;
    frame.simulated_ns = static_cast<int64_t>(tick) * 1'000'000'000 / 60;
    RecordingWriter::Tick one;
    one.tick = tick;
    one.drivers = &frame;
    EXPECT_TRUE(writer->add_tick(std::move(one)));
    if (tick == ticks) {
      for (const ObjectDrivers& object : frame.objects) {
        if (object.object_id == scene->find(std::string_view("cube"))->id)
          seen.last_nodes_m = object.positions_m;
      }
    }
  }
  EXPECT_TRUE(writer->finish());
  for (const char* name : {"cube", "box"})
    seen.last_centre_m[name] =
        scene->world().world_point(scene->find(std::string_view(name))->id, Vector3d::Zero());
  seen.ticks = ticks;
  return seen;
}

const PortableTrack* track_of(const PortableScene& scene, const std::string& name) {
  for (const PortableTrack& track : scene.animation->tracks) {
    if (scene.bodies[track.body].name == name) return &track;
  }
  return nullptr;
}

TEST(RecordedMotion, BecomesTracksOfTheBodies) {
  ScratchFolder folder;
  const auto path = folder.write("fall.scene.json", kScene);
  const Recorded seen = record(path, folder / "take.lvgrec", 60, true);
  ASSERT_GT(seen.broken_at, 1u) << "the cup breaks";
  auto scene = collect_scene(path);
  ASSERT_TRUE(scene) << scene.error().message;
  const size_t bodies = scene->bodies.size();
  const auto added = collect_recording(folder / "take.lvgrec", *scene);
  ASSERT_TRUE(added) << added.error().message;
  ASSERT_TRUE(scene->animation);
  EXPECT_EQ(scene->animation->times_s.size(), seen.ticks);
  EXPECT_NEAR(scene->animation->times_s[1], 1.0 / 60, 1e-6);

  const PortableTrack* box = track_of(*scene, "box");
  ASSERT_TRUE(box);
  ASSERT_EQ(box->world_from_object.size(), seen.ticks);
  EXPECT_LT((box->world_from_object.back().position_m - seen.last_centre_m.at("box")).norm(), kGrid_m);
  EXPECT_GT((box->world_from_object.back().position_m - box->world_from_object[0].position_m).norm(), 0.01)
      << "the ball pushes the box";

  const PortableTrack* cube = track_of(*scene, "cube");
  ASSERT_TRUE(cube);
  ASSERT_EQ(cube->nodes_m.size(), seen.ticks);
  ASSERT_EQ(cube->nodes_m.back().size(), seen.last_nodes_m.size());
  for (size_t i = 0; i < seen.last_nodes_m.size(); ++i)
    ASSERT_LT((cube->nodes_m.back()[i] - seen.last_nodes_m[i]).norm(), static_cast<float>(kGrid_m));
  // The nearest rigid motion follows the middle of the cube.
  EXPECT_LT((cube->world_from_object.back().position_m - seen.last_centre_m.at("cube")).norm(), 0.02);

  const PortableTrack* cup = track_of(*scene, "cup");
  ASSERT_TRUE(cup);
  EXPECT_EQ(cup->world_from_object.size(), seen.broken_at - 1) << "the whole cup exists until it breaks";
  size_t fragments = 0, fragment_kernels = 0, others = 0;
  for (size_t i = bodies; i < scene->bodies.size(); ++i) {
    const PortableBody& body = scene->bodies[i];
    EXPECT_TRUE(body.drawn_only);
    const PortableTrack* track = track_of(*scene, body.name);
    ASSERT_TRUE(track) << body.name;
    EXPECT_EQ(track->first_key + track->world_from_object.size(), seen.ticks);
    if (body.name.find("fragment") == std::string::npos) {
      ++others;
      continue;
    }
    ++fragments;
    fragment_kernels += body.kernel_count;
    EXPECT_EQ(track->first_key, seen.broken_at - 1);
  }
  EXPECT_GE(fragments, 2u);
  EXPECT_EQ(fragment_kernels, seen.broken_kernels);
  EXPECT_EQ(others, 1u) << "the ball";

  // Both formats keep the motion.
  const auto files = encode_gltf_scene(*scene, "");
  ASSERT_TRUE(files);
  for (const std::string& violation : gltf_violations(*files)) ADD_FAILURE() << violation;
  const auto glb = encode_glb(*files);
  ASSERT_TRUE(glb);
  const auto from_gltf = decode_gltf_scene(*glb, {}, "take.glb");
  ASSERT_TRUE(from_gltf) << from_gltf.error().message;
  EXPECT_EQ(scene_difference(*scene, *from_gltf, 1e-6, 1e-5), "");
  const auto from_usd = decode_usda_scene(encode_usda_scene(*scene), "take.usda");
  ASSERT_TRUE(from_usd) << from_usd.error().message;
  EXPECT_EQ(scene_difference(*scene, *from_usd, 1e-6, 1e-6), "");
}

TEST(RecordedMotion, ErrorsNameTheRemedyAndKeepTheScene) {
  ScratchFolder folder;
  const auto path = folder.write("fall.scene.json", kScene);
  record(path, folder / "bare.lvgrec", 40, false);
  auto scene = collect_scene(path);
  ASSERT_TRUE(scene) << scene.error().message;
  const auto bare = collect_recording(folder / "bare.lvgrec", *scene);
  ASSERT_FALSE(bare) << "the ball has an asset of its own";
  EXPECT_NE(bare.error().message.find("record with assets (--record-assets)"), std::string::npos)
      << bare.error().message;
  EXPECT_FALSE(scene->animation);
  PortableScene other = *scene;
  for (PortableBody& body : other.bodies) {
    if (body.name == "cube") body.elastic.reset();
  }
  record(path, folder / "take.lvgrec", 5, true);
  const auto wrong = collect_recording(folder / "take.lvgrec", other);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("is not the body of the scene"), std::string::npos);
  EXPECT_FALSE(collect_recording(folder / "none.lvgrec", other));
}

}  // namespace
}  // namespace livegs
