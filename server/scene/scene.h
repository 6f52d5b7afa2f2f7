// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "livegs/v1/scene.pb.h"
#include "physics/world.h"
#include "scene/build/body_type_lock.h"
#include "scene/run/scripted_grabs.h"
#include "scene/scene_object.h"
#include "skin/rest_body.h"

// Builds a world that can be stepped and objects that can be drawn from a scene file or a folder of assets.
// Used by the server and by the offline tools.

namespace livegs {

namespace v1 {
class SceneSource;  // livegs/v1/recording.proto
class SceneChange_Edit;
class SceneChange_Carry;
class SceneChange;
}  // namespace v1
struct BuiltEnvironment;
struct BuiltObject;
class FragileTask;
struct TriangleMesh;

// A running scene. Owned by one thread. `objects` grows when a ball is shot and shrinks when one is removed.
// Ids are never reused.
class Scene {
 public:
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;
  ~Scene();
  // `path` is a *.scene.json or a folder of assets. Errors name the file, the field and the remedy.
  static Result<Scene> load(const std::filesystem::path& path, const SceneOptions& options);
  // Builds a scene from a parsed file. Its paths are relative to `folder`.
  static Result<Scene> build(const v1::Scene& file, const std::filesystem::path& folder, std::string name,
                             const SceneOptions& options);
  // Rebuilds a scene from the result of source(), with the assets in `folder`. Cuts are applied by
  // take_cuts() only.
  static Result<Scene> build_again(const v1::SceneSource& source, const std::filesystem::path& folder);
  // Returns the input that this scene was built from.
  v1::SceneSource source() const;

  // Applies the file's events that are due, then advances the world by one tick.
  void step();

  World& world() { return *world_; }
  const World& world() const { return *world_; }
  const std::string& name() const { return name_; }
  const v1::Scene& file() const { return file_; }
  const std::deque<SceneObject>& objects() const { return objects_; }  // sorted by id; addresses are stable
  const SceneObject* find(std::string_view name) const;
  const SceneObject* find(uint32_t object_id) const;
  // An object of the scene file; balls and the environment may have any name.
  const SceneObject* find_in_file(std::string_view name) const;
  // World bounds of all objects in their initial poses, without the environment.
  const Eigen::AlignedBox3d& bounds_m() const { return bounds_m_; }

  // Shoots a ball. Removes the oldest one if there are more than kMaxBalls.
  const SceneObject& shoot_ball(const Eigen::Vector3d& from_m, const Eigen::Vector3d& velocity_m_s);
  // Returns the asset of all balls. Any thread; created by the first call.
  static const std::shared_ptr<const GaussianAsset>& ball_asset();
  static constexpr size_t kMaxBalls = 16;

  // Applies a force event from the next tick on. Precondition: check_force() accepted it. Has no effect if
  // the object does not exist.
  void apply_force(const v1::Event::Force& force);

  // Sets the physical parameters of an object from the next tick on. The body type stays the same. Returns
  // one line for each change that takes effect only after the scene is reloaded (lock_body_type).
  Result<std::vector<std::string>> set_physics(uint32_t object_id, v1::PhysicalParameters physics);
  BodyTypeLock body_type_lock(const SceneObject& object) const;

  // Adds, removes or changes one object as an author edited it. A moved object keeps its id; one that has to
  // be built again gets a new one. Built from the cache, or on this thread. After an error nothing has
  // changed.
  Result<void> edit(const v1::SceneChange_Edit& edit);
  // Replaces the environment: its asset, colliders and labels. Bodies on it wake up. Built from the cache
  // (keep_environment), or on this thread. It is built around the objects as they are after the edits among
  // `later`, the changes that follow in the same tick, so that a repeated run builds what the author's thread
  // built. After an error nothing has changed.
  Result<void> replace_environment(const v1::Environment& environment,
                                   std::span<const v1::SceneChange> later = {});
  // Moves an object towards a pose, at most kMaxCarrySpeed_m_s fast, until it is released or half a second
  // has passed. It pushes obstacles away. Without pose: releases it.
  void carry(const v1::SceneChange_Carry& carry);
  void place_carried();  // at once, while the scene is halted
  static constexpr double kMaxCarrySpeed_m_s = 3.0;

  // Applies the cuts of these objects, in this order, before the next step. Blocks until they are ready.
  void take_cuts(std::span<const uint32_t> object_ids);

  // Ids of objects that were added, removed or changed (broken, cut, new parameters) since the last call.
  // Used to update connected clients.
  struct Changes {
    std::vector<uint32_t> added, removed, changed;
    std::vector<uint32_t> cut;  // objects whose pieces became ready, in the order that step() applied them
  };
  Changes take_changes();

 private:
  Scene();
  void apply(const v1::Event& event, uint64_t event_id);
  Result<void> take_physics(SceneObject& object,
                            v1::PhysicalParameters physics);  // requires the same behaviour
  void note_elastic(SceneObject& drawn) const;  // sets the stiffness report and mass of its elastic body
  // Fragile objects: starts cuts, applies finished ones, and updates objects that broke.
  void begin_cut(const SceneObject& drawn);
  void recut(const SceneObject& drawn);  // if the object became fragile or its number of pieces changed
  void finish_cut(FragileTask& task);
  void apply_fractures();
  void report_recoveries();
  void report_mass_ratios();  // after a body was added, removed or given another mass
  SceneObject& drawn(uint32_t object_id);
  Result<uint32_t> add_built(BuiltObject& one);  // returns its id
  Result<void> add_environment(const BuiltEnvironment& environment);
  void remove_object(uint32_t object_id);
  Pose pose_of(uint32_t object_id) const;               // of the object's frame
  Eigen::Vector3d centre_of(uint32_t object_id) const;  // at rest, object frame
  void move_carried();
  // Puts standing objects to sleep that have something to stand on.
  void settle(std::span<const uint32_t> standing);
  std::string cut_key(const SceneObject& object) const;
  uint64_t cut_seed(const SceneObject& object) const;
  const SceneObject& add_drawn(SceneObject drawn, const Similarity& object_from_asset);

  std::string name_;
  std::filesystem::path folder_;
  SceneOptions options_;
  v1::Scene built_file_;  // as built
  v1::Scene file_;        // with the edits since
  std::unique_ptr<World> world_;
  std::deque<SceneObject> objects_;
  uint32_t next_id_ = 1;
  std::optional<uint32_t> environment_id_;  // of the drawn environment
  Eigen::AlignedBox3d bounds_m_;
  size_t next_event_ = 0;
  uint64_t next_force_ = 0;           // counter of apply_force
  std::map<size_t, GrabPath> paths_;  // by event index
  ScriptedGrabs grabs_;
  std::deque<uint32_t> balls_;  // oldest first
  Changes changes_;
  std::vector<FragileTask> cutting_;
  // Rigid objects: the surface that is cut, the surface that the kernels lie on, and the settings of the last
  // cut.
  struct Cuttable {
    std::shared_ptr<const TriangleMesh> mesh, fine;
    unsigned pieces = 0;
    std::optional<Eigen::Vector3f> interior_rgb;
  };
  std::map<uint32_t, Cuttable> cuttable_;
  std::map<uint32_t, bool> standing_;         // BuiltObject::standing of the file's objects
  std::map<uint32_t, std::string> cut_keys_;  // cut_key() of the running cuts
  struct Carried {
    Pose at, target;
    uint64_t until_tick = 0;
  };
  std::map<uint32_t, Carried> carried_;
};

// The scene that a path stands for, a scene file or a folder: its contents, base folder and name.
struct SceneText {
  v1::Scene file;
  std::filesystem::path folder;
  std::string name;
  bool of_file = false;
};
// `drop`: as SceneOptions::drop.
Result<SceneText> read_scene(const std::filesystem::path& path, bool drop = false);
// An empty scene with a floor: `path` is a folder, or a *.scene.json that does not exist yet.
Result<SceneText> new_scene(const std::filesystem::path& path);
// Reads and checks a scene file without opening its assets. Comments (//, /* */) are allowed.
Result<v1::Scene> read_scene_file(const std::filesystem::path& path);
// Checks a force from a user: finite, at most 1e5 N, for at most 60 s. InvalidArgument names the field.
Result<void> check_force(const v1::Event::Force& force);
// Makes a scene of all assets in a folder, in rows on a floor. All objects are AUTO. They stand on the floor,
// or with `drop` fall onto it from a small height.
Result<v1::Scene> scene_of_folder(const std::filesystem::path& folder, bool drop = false);

}  // namespace livegs
