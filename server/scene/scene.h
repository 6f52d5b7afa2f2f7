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

// From a scene file, or a folder of assets, to a world that can be stepped and objects that can be drawn.
// Used the same way by the server and by the offline tools.

namespace livegs {

namespace v1 {
class SceneSource;  // livegs/v1/recording.proto
}
class FragileTask;
struct TriangleMesh;

// A scene that runs. One thread owns it. `objects` grows when a ball is shot and shrinks when one is taken
// away; ids are never used twice.
class Scene {
 public:
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;
  ~Scene();
  // `path` is a *.scene.json or a folder of assets. Errors name the file, the field and the remedy.
  static Result<Scene> load(const std::filesystem::path& path, const SceneOptions& options);
  // The same from a parsed file; `folder` is what its paths are relative to.
  static Result<Scene> build(const v1::Scene& file, const std::filesystem::path& folder, std::string name,
                             const SceneOptions& options);
  // The same from what source() said of a scene, with the assets in `folder`; its cuts are told.
  static Result<Scene> build_again(const v1::SceneSource& source, const std::filesystem::path& folder);
  // What this was built from.
  v1::SceneSource source() const;

  // Applies the file's events that are due, then steps the world by one tick.
  void step();

  World& world() { return *world_; }
  const World& world() const { return *world_; }
  const std::string& name() const { return name_; }
  const v1::Scene& file() const { return file_; }
  const std::deque<SceneObject>& objects() const { return objects_; }  // ascending id; addresses stay
  const SceneObject* find(std::string_view name) const;
  const SceneObject* find(uint32_t object_id) const;
  // World bounds of all objects as they started, without the environment.
  const Eigen::AlignedBox3d& bounds_m() const { return bounds_m_; }

  // Shoots a ball. The oldest is taken away when there are more than kMaxBalls.
  const SceneObject& shoot_ball(const Eigen::Vector3d& from_m, const Eigen::Vector3d& velocity_m_s);
  // What every ball of every scene is drawn with. Any thread; the first call makes it.
  static const std::shared_ptr<const GaussianAsset>& ball_asset();
  static constexpr size_t kMaxBalls = 16;

  // A force as the file's events have it, from the next tick on. Precondition: check_force() was content with
  // it. Nothing happens when there is no such object.
  void apply_force(const v1::Event::Force& force);

  // What an object is made of from the next tick on. It goes on as the kind of body it was built as: what of
  // this holds only once the scene is loaded anew is told, a line each (lock_body_type).
  Result<std::vector<std::string>> set_physics(uint32_t object_id, v1::PhysicalParameters physics);
  BodyTypeLock body_type_lock(const SceneObject& object) const;

  // Pieces of these objects, in this order, before the next step; waits for those that are still being made.
  void take_cuts(std::span<const uint32_t> object_ids);

  // Ids of objects that came, went or changed (broke, were cut, had their physics set) since the last call,
  // for clients that are connected.
  struct Changes {
    std::vector<uint32_t> added, removed, changed;
    std::vector<uint32_t> cut;  // those whose pieces were done, in the order in which a step took them
  };
  Changes take_changes();

 private:
  Scene();
  void apply(const v1::Event& event, uint64_t event_id);
  Result<void> take_physics(SceneObject& object, v1::PhysicalParameters physics);  // of the same behaviour
  void note_elastic(SceneObject& drawn) const;  // what its elastic body turned out to be
  // Fragile objects: begins to cut them, takes what is done, and follows those that broke.
  void begin_cut(const SceneObject& drawn);
  void recut(const SceneObject& drawn);  // if it became fragile, or is to have another number of pieces
  void finish_cut(FragileTask& task);
  void apply_fractures();
  void report_recoveries();
  SceneObject& drawn(uint32_t object_id);
  const SceneObject& add_drawn(SceneObject drawn, const Similarity& object_from_asset);

  std::string name_;
  std::filesystem::path folder_;
  SceneOptions options_;
  v1::Scene file_;
  std::unique_ptr<World> world_;
  std::deque<SceneObject> objects_;
  uint32_t next_id_ = 1;
  Eigen::AlignedBox3d bounds_m_;
  size_t next_event_ = 0;
  uint64_t next_force_ = 0;                                    // of apply_force
  std::vector<std::pair<uint64_t, uint64_t>> running_forces_;  // end tick, force id; in the order they began
  std::map<size_t, GrabPath> paths_;                           // by the index of the event
  ScriptedGrabs grabs_;
  std::deque<uint32_t> balls_;  // oldest first
  Changes changes_;
  std::vector<FragileTask> cutting_;
  // Of rigid objects: the surface that is cut and the one that kernels lie on, and what they were last cut
  // into.
  struct Cuttable {
    std::shared_ptr<const TriangleMesh> mesh, fine;
    unsigned pieces = 0;
    std::optional<Eigen::Vector3f> interior_rgb;
  };
  std::map<uint32_t, Cuttable> cuttable_;
};

// What a path means, a scene file or a folder: what is to be built, what its paths are relative to, and what
// it is called.
struct SceneText {
  v1::Scene file;
  std::filesystem::path folder;
  std::string name;
  bool of_file = false;
};
Result<SceneText> read_scene(const std::filesystem::path& path);
// A scene file, checked as far as that goes without its assets. Comments (//, /* */) are allowed.
Result<v1::Scene> read_scene_file(const std::filesystem::path& path);
// A force that a person applies: numbers, at most 1e5 N, for at most 60 s. InvalidArgument names the field.
Result<void> check_force(const v1::Event::Force& force);
// A scene of every asset in a folder, standing in rows on a floor, all AUTO.
Result<v1::Scene> scene_of_folder(const std::filesystem::path& folder);

}  // namespace livegs
