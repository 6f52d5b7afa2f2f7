// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/live/scene_author.h"

#include <fcntl.h>
#include <google/protobuf/util/message_differencer.h>
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "analysis/gate/answer.h"
#include "analysis/knowledge/tables.h"
#include "analysis/physics_file.h"
#include "core/log.h"
#include "core/text/path_ending.h"
#include "core/text/shown_text.h"
#include "gaussian/asset_file.h"
#include "gaussian/asset_name.h"
#include "scene/build/build_cache.h"
#include "scene/build/build_object.h"
#include "scene/check/check_object.h"
#include "scene/check/check_scene.h"
#include "scene/check/sidecar_paths.h"
#include "scene/environment/environment.h"
#include "scene/values/scene_values.h"
#include "session/support/redact_paths.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;
using google::protobuf::util::MessageDifferencer;

constexpr double kMaxDrop_m = 100.0;  // an object farther above the floor is not dropped
constexpr int kMaxAssetDepth = 3;     // subfolder levels that are listed
constexpr size_t kMaxListedAssets = 2000;

bool is_splat_file(const fs::path& path) { return is_asset_index(path) || asset_ending(path.string()); }

// Points of the body's surface, object frame.
std::vector<Eigen::Vector3d> surface_points(const BuiltObject& built) {
  if (const auto* rigid = std::get_if<RigidBodyDescription>(&built.body)) return rigid->mesh.vertices_m;
  if (const auto* elastic = std::get_if<ElasticBodyDescription>(&built.body))
    return elastic->particles.positions_m;
  return built.body_points_m;
}

class FileUpload final : public AuthorControl::Upload {
 public:
  FileUpload(fs::path folder, std::string name) : folder_(std::move(folder)), name_(std::move(name)) {}

  Result<void> add(std::span<const std::byte> bytes) override {
    if (bytes_.size() + bytes.size() > SceneAuthor::kMaxUploadBytes)
      return Error{ErrorCode::TooLarge, name_ + ": is larger than 1 GiB; copy it to the scene's folder"};
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return {};
  }

  Result<std::string> finish() override {
    if (auto asset = decode_asset(bytes_, name_); !asset) return asset.error();
    const fs::path wanted(name_);
    for (int number = 1; number < 1000; ++number) {
      const std::string name =
          number == 1 ? name_
                      : wanted.stem().string() + "-" + std::to_string(number) + wanted.extension().string();
      std::error_code error;
      if (fs::exists(folder_ / name, error)) {
        const auto present = read_file(folder_ / name, SceneAuthor::kMaxUploadBytes);
        if (present && *present == bytes_) return name;
        continue;
      }
      if (auto written = write_file_atomically(folder_ / name, bytes_); !written) return written.error();
      log_info("asset: %s received, %.1f MB", name.c_str(), static_cast<double>(bytes_.size()) * 1e-6);
      return name;
    }
    return Error{ErrorCode::TooLarge, name_ + ": the folder has too many files of this name; rename it"};
  }

 private:
  fs::path folder_;
  std::string name_;
  std::vector<std::byte> bytes_;
};

}  // namespace

SceneAuthor::SceneAuthor(SceneDocument document, const SceneOptions& options, SimulationLoop& loop,
                         AnalysisController& analysis)
    : options_(options),
      loop_(loop),
      analysis_(analysis),
      things_(document.folder()),
      document_(std::move(document)) {
  show_revision();
  thread_ = std::jthread([this](std::stop_token stop) { run(stop); });
}

SceneAuthor::~SceneAuthor() {
  thread_.request_stop();
  thread_.join();
}

void SceneAuthor::run(std::stop_token stop) {
  pthread_setname_np(pthread_self(), "author");
  for (;;) {
    std::function<void()> task;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, stop, [&] { return !tasks_.empty(); });
      if (tasks_.empty()) return;  // every edit that was accepted is answered
      task = std::move(tasks_.front());
      tasks_.pop_front();
    }
    std::lock_guard editing(editing_);
    task();
  }
}

bool SceneAuthor::post(std::function<void()> task) {
  {
    std::lock_guard lock(mutex_);
    if (tasks_.size() >= kMaxWaiting) return false;
    tasks_.push_back(std::move(task));
  }
  changed_.notify_one();
  return true;
}

namespace {
Error too_many_edits() {
  return {ErrorCode::TooLarge, "edit: 64 edits are waiting, the maximum; try again later"};
}
}  // namespace

void SceneAuthor::edit(v1::EditSceneRequest request, Answer<v1::EditSceneReply> answer) {
  if (!post([this, request = std::move(request), answer] { answer(edited(request)); }))
    answer(too_many_edits());
}

void SceneAuthor::undo(bool redo, Answer<v1::EditSceneReply> answer) {
  if (!post([this, redo, answer] { answer(undone(redo)); })) answer(too_many_edits());
}

void SceneAuthor::save(v1::SaveSceneRequest request, Answer<v1::SaveSceneReply> answer) {
  const auto task = [this, request = std::move(request), answer] {
    Result<std::string> saved = [&] {
      std::lock_guard lock(document_mutex_);
      return document_.save(request.file(), request.replace());
    }();
    if (!saved) return answer(saved.error());
    show_revision();
    log_info("scene: saved as %s", saved->c_str());
    v1::SaveSceneReply reply;
    reply.set_file(*saved);
    answer(std::move(reply));
  };
  if (!post(task)) answer(too_many_edits());
}

Result<BuiltObject> SceneAuthor::built(const v1::Scene& scene, int index, v1::PhysicsFile* sidecar) const {
  const std::vector<fs::path> kept_in = sidecar_paths(scene, document_.folder(), document_.name());
  const fs::path& path = kept_in[static_cast<size_t>(index)];
  v1::PhysicsFile kept;
  if (!path.empty()) {
    auto file = read_physics_file(path);
    if (!file) return file.error();
    kept = std::move(*file);
  }
  const std::string field = "objects[" + std::to_string(index) + "]";
  auto object = build_cached_object(*options_.cache, scene.objects(index), document_.folder(), index, field,
                                    loop_.world_settings(), {path, &kept});
  if (sidecar) *sidecar = std::move(kept);
  if (!object) return of_object(object.error(), object_name(scene.objects(index), index));
  return object;
}

Result<ObjectMeasures> SceneAuthor::measure(const v1::Object& object) const {
  if (auto checked = check_object(object, "object"); !checked)
    return of_object(checked.error(), object.name());
  v1::Scene with = document_.scene();
  int index = 0;
  while (index < with.objects_size() && with.objects(index).name() != object.name()) ++index;
  *(index < with.objects_size() ? with.mutable_objects(index) : with.add_objects()) = object;
  auto object_built = built(with, index, nullptr);
  if (!object_built) return object_built.error();
  ObjectMeasures measures;
  measures.longest_side_m = object_built->drawn.facts->mesh.size_m.maxCoeff();
  measures.scale = object_built->object_from_asset.scale;
  const Pose pose = body_pose(object, object_built->drawn.lift_m);
  std::vector<Eigen::Vector3d> points = surface_points(*object_built);
  const v1::Scene& scene = document_.scene();
  const auto gravity = vector_value(scene.gravity_m_s2(), Eigen::Vector3d(0, -9.81, 0), "gravity_m_s2");
  if (!gravity) return gravity.error();
  const Eigen::Vector3d origin = pose_value(object.pose(), "pose").value().position_m;  // checked by built()
  const Eigen::Vector3d up = -gravity->normalized();
  measures.bottom_m = INFINITY;
  for (Eigen::Vector3d& point : points) {
    point = pose * point;
    measures.bottom_m = std::min(measures.bottom_m, up.dot(point - origin));
  }
  const bool answered = loop_.query([&, name = object.name()](const Scene& scene) {
    const SceneObject* present = scene.find_in_file(name);
    measures.way_down_m = scene.world().distance_down_m(
        points, present ? std::optional(present->id) : std::nullopt, kMaxDrop_m);
  });
  if (!answered)
    return Error{ErrorCode::Unavailable, "edit: the simulation did not respond in time; try again"};
  return measures;
}

// A renamed object keeps the values that were stored under its name.
void SceneAuthor::keep_sidecars(const v1::Scene& before, const v1::Scene& after,
                                const Renames& renames) const {
  const auto path_of = [&](const v1::Scene& scene, const std::string& name) {
    const std::vector<fs::path> paths = sidecar_paths(scene, document_.folder(), document_.name());
    for (int i = 0; i < scene.objects_size(); ++i) {
      if (object_name(scene.objects(i), i) == name) return paths[static_cast<size_t>(i)];
    }
    return fs::path();
  };
  for (const auto& [from, to] : renames) {
    const fs::path was = path_of(before, from), is = path_of(after, to);
    std::error_code error;
    if (was.empty() || is.empty() || was == is || !fs::exists(was, error) || fs::exists(is, error)) continue;
    if (!fs::copy_file(was, is, error))
      log_warn("%s: its values could not be kept under the new name: %s", to.c_str(),
               error.message().c_str());
  }
}

Result<void> SceneAuthor::build_environment_of(const v1::Scene& scene) const {
  std::vector<std::optional<Result<BuiltObject>>> objects;
  for (int i = 0; i < scene.objects_size(); ++i) {
    objects.emplace_back(built(scene, i, nullptr));
    if (!*objects.back()) return objects.back()->error();
  }
  auto made = build_environment(options_.cache.get(), scene.environment(), document_.folder(), objects);
  if (!made) return made.error();
  keep_environment(*options_.cache, scene.environment(), document_.folder(), *std::move(made));
  return {};
}

Result<std::vector<std::string>> SceneAuthor::apply(const v1::Scene& before, const v1::Scene& after,
                                                    const Renames& renames) {
  keep_sidecars(before, after, renames);
  std::vector<std::string> warnings, gone;
  std::vector<v1::SceneChange> changes;
  std::vector<BuiltObject> fresh;
  if (!MessageDifferencer::Equals(before.environment(), after.environment())) {
    if (auto made = build_environment_of(after); !made) return made.error();
    *changes.emplace_back().mutable_environment() = after.environment();
  }
  for (v1::SceneChange::Edit& edit : edits_between(before, after, renames)) {
    if (edit.has_after()) {
      int index = 0;
      while (object_name(after.objects(index), index) != edit.after().name()) ++index;
      auto object = built(after, index, edit.mutable_sidecar());
      if (!object) return object.error();
      if (edit.sidecar().ByteSizeLong() == 0) edit.clear_sidecar();
      for (const std::string& warning : object->drawn.warnings)
        warnings.push_back(edit.after().name() + ": " + redact_paths(warning));
      fresh.push_back(std::move(*object));
    }
    if (!edit.object().empty()) gone.push_back(edit.object());
    *changes.emplace_back().mutable_edit() = std::move(edit);
  }
  analysis_.change(gone, fresh);
  loop_.post(std::move(changes));
  return warnings;
}

namespace {

// Fields of an object's physics, if a request does nothing but clear values that the scene does not state:
// they were set by hand and are kept in the sidecar.
std::vector<std::string> cleared_edits(const v1::EditSceneRequest& request, const v1::Scene& scene) {
  static const std::string kPhysics = "physics.";
  if (request.objects_size() != 1 || request.has_bookmarks() || request.has_background()) return {};
  const v1::ObjectEdit& edit = request.objects(0);
  if (edit.object().empty() || edit.remove() || edit.drop() || edit.has_longest_side_m()) return {};
  const auto object = std::find_if(scene.objects().begin(), scene.objects().end(),
                                   [&](const v1::Object& one) { return one.name() == edit.object(); });
  if (object == scene.objects().end() || object->locked()) return {};
  std::vector<std::string> fields;
  for (const std::string& path : edit.fields()) {
    const auto* field = path.starts_with(kPhysics)
                            ? v1::Physics::descriptor()->FindFieldByName(path.substr(kPhysics.size()))
                            : nullptr;
    if (!field || !(field->has_presence() || field->is_repeated())) return {};
    const auto states = [field](const v1::Physics& physics) {
      const auto& reflection = *v1::Physics::GetReflection();
      return field->is_repeated() ? reflection.FieldSize(physics, field) > 0
                                  : reflection.HasField(physics, field);
    };
    if (states(edit.value().physics()) || states(object->physics())) return {};
    fields.push_back(field->name());
  }
  return fields;
}

}  // namespace

Result<v1::EditSceneReply> SceneAuthor::restored(const std::string& object,
                                                 std::span<const std::string> fields) {
  auto physics = analysis_.restore_estimate(object, fields);
  if (!physics) return physics.error();
  v1::EditSceneReply reply;
  reply.add_objects(object);
  *reply.mutable_warnings() = physics->warnings();
  const std::string not_kept = commit_physics("return to the estimate of", object);
  if (!not_kept.empty()) reply.add_warnings(redact_paths(not_kept));
  reply.set_revision(document_.revision());
  log_info("scene: return to the estimate of %s", object.c_str());
  return reply;
}

Result<v1::EditSceneReply> SceneAuthor::edited(const v1::EditSceneRequest& request) {
  if (const auto fields = cleared_edits(request, document_.scene()); !fields.empty())
    return restored(request.objects(0).object(), fields);
  v1::EditSceneReply reply;
  std::vector<std::string> names;
  auto step = document_.prepare(
      request, [this](const v1::Object& object) { return measure(object); }, names);
  if (!step) return step.error();
  auto warnings = done(std::move(*step));
  if (!warnings) return warnings.error();
  reply.set_revision(document_.revision());
  for (std::string& name : names) reply.add_objects(std::move(name));
  for (std::string& warning : *warnings) reply.add_warnings(std::move(warning));
  return reply;
}

Result<std::vector<std::string>> SceneAuthor::done(SceneDocument::Step step) {
  auto warnings = apply(step.before, step.after, step.renames);
  if (!warnings) return warnings;
  log_info("scene: %s", step.title.c_str());
  {
    std::lock_guard lock(document_mutex_);
    const std::string not_kept = document_.commit(std::move(step));
    if (!not_kept.empty()) warnings->push_back(redact_paths(not_kept));
  }
  show_revision();
  return warnings;
}

v1::RoomParts SceneAuthor::room_parts() {
  const v1::Environment environment = [&] {
    std::lock_guard lock(document_mutex_);
    return document_.scene().environment();
  }();
  return things_.describe(environment);
}

void SceneAuthor::take_part(v1::TakePartRequest request, Answer<v1::TakePartReply> answer) {
  if (!post([this, request = std::move(request), answer] { answer(taken(request)); }))
    answer(too_many_edits());
}

void SceneAuthor::put_back(const std::string& object, Answer<v1::EditSceneReply> answer) {
  if (!post([this, object, answer] { answer(returned(object)); })) answer(too_many_edits());
}

Result<v1::TakePartReply> SceneAuthor::taken(const v1::TakePartRequest& request) {
  const v1::Environment& environment = document_.scene().environment();
  (void)things_.describe(environment);  // begins the search at the first call
  auto thing = things_.under(request, environment);
  if (!thing) return thing.error();
  v1::TakePartReply reply;
  reply.set_kernels(thing->kernels);
  for (const double number : thing->bounds_m.min()) reply.add_min_m(number);
  for (const double number : thing->bounds_m.max()) reply.add_max_m(number);
  if (request.preview()) return reply;
  auto out = things_.take(*thing, environment);
  if (!out) return out.error();
  v1::EditSceneRequest added;
  *added.add_objects()->mutable_value() = out->object;
  added.mutable_objects(0)->mutable_value()->set_name(request.name().empty() ? "thing 1" : request.name());
  std::vector<std::string> names;
  auto step = document_.prepare(
      added, [this](const v1::Object& object) { return measure(object); }, names);
  if (!step) return step.error();
  *step->after.mutable_environment() = out->environment;
  if (auto checked = check_scene(step->after); !checked) return checked.error();
  step->title = "take " + shown_text(names.front(), 60);
  auto warnings = done(std::move(*step));
  if (!warnings) return warnings.error();
  reply.set_object(names.front());
  reply.set_revision(document_.revision());
  for (std::string& warning : *warnings) reply.add_warnings(std::move(warning));
  return reply;
}

Result<v1::EditSceneReply> SceneAuthor::returned(const std::string& object) {
  const auto& objects = document_.scene().objects();
  const auto found = std::find_if(objects.begin(), objects.end(),
                                  [&](const v1::Object& one) { return one.name() == object; });
  if (found == objects.end())
    return not_found("object: \"" + shown_text(object, 80) + "\" is not in the scene; name one that is");
  if (found->part() == 0)
    return invalid_argument("object \"" + shown_text(object, 80) +
                            "\": was not taken from the room; delete it instead");
  v1::EditSceneRequest gone;
  gone.add_objects()->set_object(object);
  gone.mutable_objects(0)->set_remove(true);
  const uint32_t part = found->part();
  std::vector<std::string> names;
  auto step = document_.prepare(
      gone, [this](const v1::Object& one) { return measure(one); }, names);
  if (!step) return step.error();
  auto environment = things_.put_back(part, step->after.environment());
  if (!environment) return environment.error();
  *step->after.mutable_environment() = *std::move(environment);
  step->title = "put back " + shown_text(object, 60);
  auto warnings = done(std::move(*step));
  if (!warnings) return warnings.error();
  v1::EditSceneReply reply;
  reply.add_objects(object);
  reply.set_revision(document_.revision());
  for (std::string& warning : *warnings) reply.add_warnings(std::move(warning));
  return reply;
}

Result<v1::EditSceneReply> SceneAuthor::undone(bool redo) {
  const SceneDocument::Step* step = document_.next(redo);
  if (!step) return not_found(redo ? "redo: there is nothing to redo" : "undo: there is nothing to undo");
  v1::EditSceneReply reply;
  std::vector<std::string> warnings;
  if (!step->physics_object.empty()) {
    auto physics = analysis_.undo_physics(step->physics_object, redo);
    if (physics) {
      warnings.assign(physics->warnings().begin(), physics->warnings().end());
      reply.add_objects(step->physics_object);
    } else if (physics.error().code == ErrorCode::NotFound) {  // taken back another way, or the object is new
      warnings.push_back(step->physics_object + ": these values were already reverted");
    } else {
      return physics.error();
    }
  } else {
    Renames back;
    for (const auto& [from, to] : step->renames) back.emplace_back(to, from);
    auto applied =
        redo ? apply(step->before, step->after, step->renames) : apply(step->after, step->before, back);
    if (!applied) return applied.error();
    warnings = std::move(*applied);
  }
  log_info("scene: %s %s", redo ? "redo" : "undo", step->title.c_str());
  {
    std::lock_guard lock(document_mutex_);
    const std::string not_kept = document_.take(redo);
    if (!not_kept.empty()) warnings.push_back(redact_paths(not_kept));
    reply.set_revision(document_.revision());
  }
  show_revision();
  for (std::string& warning : warnings) reply.add_warnings(std::move(warning));
  return reply;
}

void SceneAuthor::note_physics(const std::string& object) {
  (void)post([this, object] { (void)commit_physics("edit values of", object); });
}

std::string SceneAuthor::commit_physics(const std::string& title, const std::string& object) {
  std::string not_kept;
  {
    std::lock_guard lock(document_mutex_);
    not_kept = document_.commit(
        {title + " " + shown_text(object, 60), document_.scene(), document_.scene(), {}, object});
  }
  show_revision();
  return not_kept;
}

Result<void> SceneAuthor::carry(const v1::CarryObjectRequest& request) {
  if (request.has_pose()) {
    if (auto pose = pose_value(request.pose(), "pose"); !pose) return pose.error();
  }
  {
    std::lock_guard lock(document_mutex_);
    const auto& objects = document_.scene().objects();
    const auto found = std::find_if(objects.begin(), objects.end(),
                                    [&](const v1::Object& one) { return one.name() == request.object(); });
    if (found == objects.end())
      return not_found("object: \"" + shown_text(request.object(), 80) +
                       "\" is not in the scene; name one that is");
    if (found->locked())
      return invalid_argument("object \"" + found->name() + "\": is locked; unlock it first");
  }
  v1::SceneChange change;
  change.mutable_carry()->set_object(request.object());
  if (request.has_pose()) *change.mutable_carry()->mutable_pose() = request.pose();
  loop_.post(std::move(change));
  return {};
}

v1::SceneDocument SceneAuthor::document() {
  v1::SceneDocument message;
  std::lock_guard lock(document_mutex_);
  document_.describe(message);
  return message;
}

v1::ListAssetsReply SceneAuthor::assets() {
  v1::ListAssetsReply reply;
  const fs::path& folder = document_.folder();  // constant
  std::vector<std::pair<std::string, uint64_t>> found;
  std::vector<std::string> streams;
  std::error_code error;
  auto walk = fs::recursive_directory_iterator(folder.empty() ? fs::path(".") : folder,
                                               fs::directory_options::skip_permission_denied, error);
  for (; !error && walk != fs::recursive_directory_iterator() && found.size() < kMaxListedAssets;
       walk.increment(error)) {
    if (walk.depth() >= kMaxAssetDepth) walk.disable_recursion_pending();
    std::error_code ignored;
    if (!walk->is_regular_file(ignored) || !is_splat_file(walk->path())) continue;
    fs::path path = fs::relative(walk->path(), folder.empty() ? fs::path(".") : folder, ignored);
    const bool streamed = lower_case(path.filename().string()) == "lod-meta.json";
    if (is_asset_index(path)) path = path.parent_path();
    if (streamed) streams.push_back(path.string() + "/");
    if (path.empty()) continue;  // the scene's own folder
    found.emplace_back(path.string(), walk->file_size(ignored));
  }
  std::erase_if(found, [&](const auto& one) {  // the chunks of a streamed asset
    return std::any_of(streams.begin(), streams.end(),
                       [&](const std::string& above) { return one.first.starts_with(above); });
  });
  std::sort(found.begin(), found.end());
  for (const auto& [path, bytes] : found) {
    v1::ListAssetsReply::Asset& asset = *reply.add_assets();
    asset.set_path(path);
    asset.set_bytes(bytes);
  }
  for (const ObjectRow& row : object_table()) reply.add_labels(row.label);
  for (const MaterialRow& row : material_table()) reply.add_materials(row.name);
  return reply;
}

Result<std::unique_ptr<AuthorControl::Upload>> SceneAuthor::upload(const std::string& name) {
  const bool plain = !name.empty() && name.size() <= 120 && name.front() != '.' &&
                     std::all_of(name.begin(), name.end(), [](unsigned char letter) {
                       return letter >= 32 && letter != 127 && letter != '/' && letter != '\\';
                     });
  if (!plain || is_asset_index(name) || !is_splat_file(name))
    return invalid_argument("name: \"" + shown_text(name, 80) +
                            "\" is not a splat file; give a plain name ending in " + kAssetEndings);
  return std::unique_ptr<Upload>(std::make_unique<FileUpload>(document_.folder(), name));
}

void SceneAuthor::show_revision() {
  std::lock_guard lock(document_mutex_);
  loop_.set_edit_revision(document_.revision());
}

Result<Scene> SceneAuthor::build(uint32_t first_object_id) {
  std::unique_lock editing(editing_);
  SceneOptions again = options_;
  again.first_object_id = first_object_id;
  if (!document_.unsaved() && document_.changed_on_disk()) {
    auto file = read_scene_file(document_.folder() / document_.file());
    if (!file) return file.error();
    std::lock_guard lock(document_mutex_);
    document_.reload(std::move(*file));
  }
  show_revision();
  auto scene = Scene::build(document_.scene(), document_.folder(), document_.name(), again);
  if (scene) resetting_ = std::move(editing);
  return scene;
}

void SceneAuthor::installed() { resetting_ = {}; }

}  // namespace livegs
