// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <utility>

#include "core/log.h"
#include "core/parallel_for.h"
#include "geometry/surface/shape_mesh.h"
#include "scene/build/add_joints.h"
#include "scene/build/build_cache.h"
#include "scene/build/build_object.h"
#include "scene/build/elastic_report.h"
#include "scene/build/fracture_warning.h"
#include "scene/build/fragile_object.h"
#include "scene/build/mass_ratio_warning.h"
#include "scene/build/shape_asset.h"
#include "scene/build/share_elastic_budget.h"
#include "scene/check/check_object.h"
#include "scene/check/check_scene.h"
#include "scene/check/sidecar_paths.h"
#include "scene/environment/environment.h"
#include "scene/values/scene_values.h"

namespace livegs {
namespace {

// The ball that is shot: a rubber ball 60 mm in diameter.
constexpr double kBallRadius_m = 0.03;
constexpr double kBallMass_kg = 0.1;
const Eigen::Vector3f kBallRgb(0.85f, 0.25f, 0.2f);

// Marks the force ids of events in the scene file. Hands and tools use ids without this bit.
constexpr uint64_t kEventForceBit = uint64_t{1} << 63;
constexpr uint64_t kPersonForceBit = uint64_t{1} << 62;  // marks the force ids of apply_force

constexpr int kMaxRecoveryWarnings = 3;  // per object
constexpr double kMaxForce_n = 1e5, kMaxForceDuration_s = 60;

// Converts a list that was checked to have three numbers.
Eigen::Vector3d vector_of(const Numbers& numbers) {
  return vector_value(numbers, Eigen::Vector3d::Zero(), "").value();
}

Result<WorldSettings> world_settings(const v1::Scene& file, const SceneOptions& options) {
  WorldSettings settings;
  auto gravity = vector_value(file.gravity_m_s2(), settings.gravity_m_s2, "gravity_m_s2");
  if (!gravity) return gravity.error();
  settings.gravity_m_s2 = *gravity;
  settings.rate_hz = options.rate_hz.value_or(file.has_rate_hz() ? file.rate_hz() : settings.rate_hz);
  settings.substeps = options.substeps.value_or(file.has_substeps() ? file.substeps() : settings.substeps);
  if (const int least = min_substeps(settings.rate_hz); settings.substeps < least) {
    log_warn("scene: %d substeps per tick at %.3g Hz are too few for contact, so %d are used; raise substeps",
             settings.substeps, settings.rate_hz, least);
    settings.substeps = least;
  }
  if (file.has_elastic_budget_ms())
    settings.elastic_node_substeps = file.elastic_budget_ms() / kNodeSubstep_ms;
  settings.make_elastic = options.make_elastic;
  settings.sleep = options.sleep;
  return settings;
}

// Returns the given sidecar of an object; null: read it from disk.
const v1::PhysicsFile* sidecar_of(const SceneOptions& options, const v1::Object& object, int index) {
  static const v1::PhysicsFile kNone;
  if (!options.sidecars) return nullptr;
  const auto found = options.sidecars->find(object_name(object, index));
  return found == options.sidecars->end() ? &kNone : &found->second;
}

Result<BuiltObject> build_one(BuildCache* cache, BuildCache& own, const v1::Object& object,
                              const std::filesystem::path& folder, int index, const WorldSettings& settings,
                              const ObjectSidecar& sidecar) {
  const std::string field = "objects[" + std::to_string(index) + "]";
  return cache ? build_cached_object(*cache, object, folder, index, field, settings, sidecar)
               : build_object(object, folder, index, field, settings, sidecar, &own);
}

void log_built(const BuiltObject& built) {
  const SceneObject& drawn = built.drawn;
  const v1::PhysicalParameters& physics = drawn.physics;
  log_info("%s: %zu kernels, %s of %s, %.3g kg, %.0f ms%s%s", drawn.name.c_str(), drawn.asset->size(),
           v1::Physics::Behavior_Name(physics.behavior()).c_str(), physics.material().c_str(), drawn.mass_kg,
           built.build_ms, drawn.surface_note.empty() ? "" : "; ", drawn.surface_note.c_str());
}

// A cut, and the data whose addresses are in its key.
struct KeptCut {
  FragileObject pieces;
  std::vector<std::shared_ptr<const void>> inputs;
};

// Removes the numeric id that the World puts before its messages. The caller adds the object's name.
std::string without_id(const std::string& message, uint32_t object_id) {
  const std::string by_id = "object " + std::to_string(object_id) + ": ";
  return message.starts_with(by_id) ? message.substr(by_id.size()) : message;
}

// Logs the properties of a body that are known once it is in the world.
void log_notes(const SceneObject& drawn) {
  if (drawn.elastic) log_info("%s: %s", drawn.name.c_str(), accuracy_line(*drawn.elastic).c_str());
  const double alone_kg = drawn.physics.mass_kg().best();
  if (drawn.elastic && std::abs(drawn.mass_kg - alone_kg) > 1e-3 * alone_kg) {
    log_info("%s: %.3g kg with its regions", drawn.name.c_str(), drawn.mass_kg);
  }
  for (const std::string& warning : drawn.all_warnings()) {
    if (warning != drawn.surface_note) log_warn("%s: %s", drawn.name.c_str(), warning.c_str());
  }
}

}  // namespace

Scene::Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;
Scene::~Scene() = default;

Result<Scene> Scene::load(const std::filesystem::path& path, const SceneOptions& options) {
  auto text = read_scene(path, options.drop);
  if (!text) return text.error();
  auto scene = build(text->file, text->folder, text->name, options);
  if (!scene && text->of_file) return Error{scene.error().code, text->name + ": " + scene.error().message};
  return scene;
}

Result<Scene> Scene::build(const v1::Scene& file, const std::filesystem::path& folder, std::string name,
                           const SceneOptions& options) {
  if (auto checked = check_scene(file); !checked) return checked.error();
  auto settings = world_settings(file, options);
  if (!settings) return settings.error();
  Scene scene;
  scene.next_id_ = options.first_object_id;
  scene.name_ = std::move(name);
  scene.folder_ = folder;
  scene.options_ = options;
  scene.file_ = file;
  std::stable_sort(scene.file_.mutable_events()->begin(), scene.file_.mutable_events()->end(),
                   [](const v1::Event& a, const v1::Event& b) { return a.time_s() < b.time_s(); });
  scene.built_file_ = scene.file_;
  scene.world_ = std::make_unique<World>(*settings);

  // Objects are independent, so they are built in parallel. The results are added in the file's order.
  const auto count = static_cast<size_t>(file.objects_size());
  const std::vector<std::filesystem::path> kept_in = sidecar_paths(file, folder, scene.name_);
  std::vector<std::optional<Result<BuiltObject>>> built(count);
  BuildCache own;      // of this scene, without a cache
  std::mutex telling;  // serialises the calls of options.built
  parallel_for(count, 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const int index = static_cast<int>(i);
      built[i] = build_one(options.cache.get(), own, file.objects(index), folder, index, *settings,
                           {kept_in[i], sidecar_of(options, file.objects(index), index)});
      if (!*built[i]) continue;
      log_built(**built[i]);
      if (!options.built) continue;
      std::lock_guard lock(telling);
      options.built((*built[i])->drawn);
    }
  });
  for (size_t i = 0; i < count; ++i) {
    const int index = static_cast<int>(i);
    if (!*built[i]) return of_object(built[i]->error(), object_name(file.objects(index), index));
  }

  share_elastic_budget(built, *settings);
  scene.bounds_m_ = built_bounds(built);
  auto environment = build_environment(options.cache.get(), file.environment(), folder, built);
  if (!environment) return environment.error();
  if (auto added = scene.add_environment(**environment); !added) return added.error();
  std::vector<uint32_t> standing;  // a static object that is added wakes all others
  for (auto& object : built) {
    const auto id = scene.add_built(**object);
    if (!id) return id.error();
    if (scene.standing_.at(*id)) standing.push_back(*id);
  }
  scene.settle(standing);
  if (options.wait_for_pieces) {
    for (FragileTask& task : scene.cutting_) scene.finish_cut(task);
    scene.cutting_.clear();
  }
  const auto by_name = [&](const std::string& object) { return scene.find(std::string_view(object)); };
  if (auto added = add_joints(file, by_name, *scene.world_); !added) return added.error();
  for (int i = 0; i < scene.file_.events_size(); ++i) {
    const v1::Event& event = scene.file_.events(i);
    if (!event.has_grab() && !event.has_pull()) continue;
    auto path = read_grab_path(folder / (event.has_grab() ? event.grab().path() : event.pull().path()));
    if (!path) return path.error();
    scene.paths_[static_cast<size_t>(i)] = std::move(*path);
  }
  scene.report_mass_ratios();
  scene.changes_ = {};
  return scene;
}

Result<void> Scene::add_environment(const BuiltEnvironment& environment) {
  environment_id_.reset();
  if (environment.asset) {
    SceneObject drawn;
    drawn.id = next_id_++;
    drawn.name = "environment";
    drawn.environment = true;
    drawn.asset = environment.asset;
    if (auto added = world_->add_static(drawn.id, environment.world_from_object); !added) return added;
    environment_id_ = drawn.id;
    add_drawn(std::move(drawn), environment.object_from_asset);
  }
  for (const Collider& collider : environment.colliders) world_->add_collider(collider);
  return {};
}

Result<uint32_t> Scene::add_built(BuiltObject& one) {
  one.drawn.id = next_id_++;
  Result<void> added;
  if (auto* fixed = std::get_if<StaticBodyDescription>(&one.body)) {
    world_->add_collider({fixed->shape, fixed->world_from_object, fixed->friction, fixed->restitution},
                         one.drawn.id);
    added = world_->add_static(one.drawn.id, fixed->world_from_object);
  } else if (auto* rigid = std::get_if<RigidBodyDescription>(&one.body)) {
    rigid->object_id = one.drawn.id;
    added = world_->add_rigid(*rigid);
  } else {
    auto& elastic = std::get<ElasticBodyDescription>(one.body);
    elastic.object_id = one.drawn.id;
    added = world_->add_elastic(elastic);
  }
  if (!added) return of_object(added.error(), one.drawn.name);
  standing_[one.drawn.id] = one.standing;
  const Similarity object_from_asset = one.object_from_asset;
  note_elastic(one.drawn);
  const SceneObject& drawn = add_drawn(std::move(one.drawn), object_from_asset);
  if (const auto* rigid = std::get_if<RigidBodyDescription>(&one.body)) {
    cuttable_[drawn.id] = {one.cut_mesh, one.fine_mesh, 0, {}};
    if (rigid->material.fragile && options_.cut_fragile) begin_cut(drawn);
  }
  log_notes(objects_.back());
  return drawn.id;
}

void Scene::note_elastic(SceneObject& drawn) const {
  const ElasticBody* body = world_->elastic_body(drawn.id);
  if (!body) return;
  drawn.elastic = body->accuracy();
  drawn.elastic->sag *= world_->settings().gravity_m_s2.norm() / 9.81;
  drawn.mass_kg = body->mass_kg();
}

const SceneObject& Scene::add_drawn(SceneObject drawn, const Similarity& object_from_asset) {
  drawn.rest = world_->rest_body(drawn.id);
  drawn.rest.object_from_asset = object_from_asset;
  changes_.added.push_back(drawn.id);
  objects_.push_back(std::move(drawn));
  return objects_.back();
}

SceneObject& Scene::drawn(uint32_t object_id) { return const_cast<SceneObject&>(*find(object_id)); }

void Scene::begin_cut(const SceneObject& object) {
  const Material& material = *world_->material(object.id);
  Fragility fragility;
  fragility.break_impulse_n_s = material.break_impulse_n_s;
  fragility.drop_height_m = drop_height_m(material, world_->settings().gravity_m_s2.norm());
  drawn(object.id).fragility = fragility;
  FragileOptions options;
  options.object_from_asset = object.rest.object_from_asset;
  options.pieces.seed = cut_seed(object);
  Cuttable& cuttable = cuttable_.at(object.id);
  cuttable.pieces = material.fracture_pieces;
  cuttable.interior_rgb = material.interior_rgb;
  options.pieces.piece_count = material.fracture_pieces;
  options.interior_rgb = material.interior_rgb;
  if (cuttable.fine != cuttable.mesh) options.fine_mesh = cuttable.fine;
  std::erase_if(cutting_, [&](const FragileTask& task) { return task.object_id() == object.id; });
  const std::string& key = cut_keys_[object.id] = cut_key(object);
  if (const auto before = options_.cache ? options_.cache->find<KeptCut>(key) : nullptr)
    cutting_.emplace_back(object.id, before->pieces);
  else
    cutting_.emplace_back(object.id, *cuttable.mesh, material.fill, object.asset, options);
}

// Everything that the cut of an object is made from. A mesh is known by its address, which the cache keeps
// alive.
std::string Scene::cut_key(const SceneObject& object) const {
  const Cuttable& cuttable = cuttable_.at(object.id);
  const Material& material = *world_->material(object.id);
  std::array<char, 200> key{};
  const Eigen::Vector3f inside = cuttable.interior_rgb.value_or(Eigen::Vector3f::Constant(-1));
  std::snprintf(key.data(), key.size(), "cut %p %p %p %u %d %llu %.9g %.9g %.9g",
                static_cast<const void*>(cuttable.mesh.get()), static_cast<const void*>(cuttable.fine.get()),
                static_cast<const void*>(object.asset.get()), cuttable.pieces,
                static_cast<int>(material.fill), static_cast<unsigned long long>(cut_seed(object)),
                static_cast<double>(inside.x()), static_cast<double>(inside.y()),
                static_cast<double>(inside.z()));
  return key.data();
}

// By the object's place in the scene, so that a reloaded scene with new ids has the same pieces.
uint64_t Scene::cut_seed(const SceneObject& object) const {
  for (int i = 0; i < file_.objects_size(); ++i) {
    if (object_name(file_.objects(i), i) != object.name) continue;
    return options_.seed + static_cast<uint64_t>(i) + (environment_id_ ? 2 : 1);
  }
  return options_.seed;
}

void Scene::recut(const SceneObject& object) {
  const Material& material = *world_->material(object.id);
  const auto cuttable = cuttable_.find(object.id);
  if (cuttable == cuttable_.end() || !material.fragile || world_->revision(object.id) > 0) return;
  const bool same_inside = cuttable->second.interior_rgb == material.interior_rgb;
  if (cuttable->second.pieces == material.fracture_pieces && same_inside) return;
  begin_cut(object);
  if (!options_.wait_for_pieces) return;
  finish_cut(cutting_.back());
  cutting_.pop_back();
}

void Scene::finish_cut(FragileTask& task) {
  SceneObject& object = drawn(task.object_id());
  auto fragile = task.take();
  if (fragile && options_.cache) {
    const Cuttable& cuttable = cuttable_.at(object.id);
    const auto kept =
        std::make_shared<const KeptCut>(KeptCut{*fragile, {cuttable.mesh, cuttable.fine, object.asset}});
    options_.cache->keep(cut_keys_.at(object.id), kept,
                         BuildCache::kKernelBytes * fragile->broken->asset->size());
  }
  if (world_->revision(object.id) > 0) return;  // the object broke into its previous pieces
  const auto set = fragile ? world_->set_pieces(object.id, fragile->pieces) : Result<void>(fragile.error());
  if (!set) {
    object.warnings.push_back("cannot break: " + without_id(set.error().message, object.id));
    log_warn("%s: %s", object.name.c_str(), object.warnings.back().c_str());
    return;
  }
  object.broken = fragile->broken;
  object.fragility->pieces = static_cast<uint32_t>(fragile->pieces->pieces.size());
  changes_.changed.push_back(object.id);
  log_info("%s: fragile, %u pieces with %zu kernels, breaks at %.3g N s (a drop of %.2f m), %.0f ms",
           object.name.c_str(), object.fragility->pieces, object.broken->asset->size(),
           object.fragility->break_impulse_n_s, object.fragility->drop_height_m, fragile->prepared_ms);
}

void Scene::apply_fractures() {
  for (SceneObject& object : objects_) {
    if (!object.broken || world_->revision(object.id) == object.rest.revision) continue;
    const Similarity object_from_asset = object.rest.object_from_asset;
    object.rest = world_->rest_body(object.id);
    object.rest.object_from_asset = object_from_asset;
    object.rest.kernel_runs = kernel_runs(*object.broken, world_->piece_bodies(object.id));
    object.asset = object.broken->asset;
    object.fragility->bodies = static_cast<uint32_t>(object.rest.bodies.size());
    changes_.changed.push_back(object.id);
  }
}

void Scene::report_recoveries() {
  for (SceneObject& object : objects_) {
    if (!object.elastic) continue;
    const ElasticBody* body = world_->elastic_body(object.id);
    const int times = body ? body->recovery_count() : 0;
    if (times == std::exchange(object.elastic->recovery_count, times) || times > kMaxRecoveryWarnings)
      continue;
    changes_.changed.push_back(object.id);
    log_warn(
        "%s: simulation diverged and was reset to the rest shape; check for motion larger than the object "
        "per frame, or raise substeps",
        object.name.c_str());
  }
}

void Scene::report_mass_ratios() {
  for (const uint32_t id : update_mass_ratio_warnings(objects_, file_.joints(), world_->settings())) {
    const SceneObject& object = *find(id);
    changes_.changed.push_back(id);
    if (!object.mass_ratio_warning.empty())
      log_warn("%s: %s", object.name.c_str(), object.mass_ratio_warning.c_str());
  }
}

void Scene::take_cuts(std::span<const uint32_t> object_ids) {
  for (const uint32_t id : object_ids) {
    for (FragileTask& task : cutting_) {
      if (task.object_id() == id && !task.taken()) finish_cut(task);
    }
  }
  std::erase_if(cutting_, [](const FragileTask& task) { return task.taken(); });
}

void Scene::step() {
  std::vector<uint32_t> done;
  for (const FragileTask& task : cutting_) {
    if (!options_.recorded_cuts && task.ready()) done.push_back(task.object_id());
  }
  take_cuts(done);
  changes_.cut.insert(changes_.cut.end(), done.begin(), done.end());
  const uint64_t tick = world_->tick();
  const double rate_hz = world_->settings().rate_hz;
  for (; next_event_ < static_cast<size_t>(file_.events_size()); ++next_event_) {
    const v1::Event& event = file_.events(static_cast<int>(next_event_));
    // An event takes effect in the first tick that starts at or after its time.
    if (static_cast<double>(tick) < std::ceil(event.time_s() * rate_hz - 1e-6)) break;
    apply(event, next_event_);
  }
  grabs_.move(*world_, static_cast<double>(world_->tick()) / rate_hz);
  move_carried();
  world_->step();
  apply_fractures();
  report_recoveries();
}

Result<void> Scene::take_physics(SceneObject& object, v1::PhysicalParameters physics) {
  // An object that is not fragile any more may have no break impulse. Its pieces keep the strength that they
  // were cut with.
  if (object.fragility && !physics.fragile() && !physics.has_break_impulse_n_s()) {
    *physics.mutable_break_impulse_n_s() = object.physics.break_impulse_n_s();
  }
  if (auto set = world_->set_material(object.id, to_material(physics)); !set) return set;
  if (const auto why = fracture_warning(physics); why && !object.physics.fragile()) {
    object.warnings.push_back("physics." + *why);
    log_warn("%s: %s", object.name.c_str(), object.warnings.back().c_str());
  }
  object.physics = std::move(physics);
  object.mass_kg = object.physics.mass_kg().best();
  note_elastic(object);
  report_mass_ratios();
  if (object.fragility) {
    const Material& material = *world_->material(object.id);
    object.fragility->break_impulse_n_s = material.break_impulse_n_s;
    object.fragility->drop_height_m = drop_height_m(material, world_->settings().gravity_m_s2.norm());
  }
  changes_.changed.push_back(object.id);
  recut(object);
  return {};
}

BodyTypeLock Scene::body_type_lock(const SceneObject& object) const {
  return {object.physics.behavior(), object.fragility || cuttable_.contains(object.id), object.built_parts};
}

Result<std::vector<std::string>> Scene::set_physics(uint32_t object_id, v1::PhysicalParameters physics) {
  const Material* present = world_->material(object_id);
  if (!present || !find(object_id))
    return not_found("object " + std::to_string(object_id) + ": does not exist");
  SceneObject& object = drawn(object_id);
  std::vector<std::string> later = lock_body_type(body_type_lock(object), physics);
  if (auto taken = take_physics(object, std::move(physics)); !taken) return taken.error();
  return later;
}

Result<void> check_force(const v1::Event::Force& force) {
  for (const auto& [field, numbers] :
       {std::pair("force.point_m", &force.point_m()), {"force.force_n", &force.force_n()}}) {
    if (numbers->size() != 3) return invalid_argument(std::string(field) + ": must have three numbers");
    auto value = vector_value(*numbers, Eigen::Vector3d::Zero(), field);
    if (!value) return value.error();
    if (!(value->norm() <= kMaxForce_n)) {
      return invalid_argument(std::string(field) + ": is too large; use at most 1e5 (N or m)");
    }
  }
  if (!(force.duration_s() > 0 && force.duration_s() <= kMaxForceDuration_s)) {
    return invalid_argument("force.duration_s: must be above 0 and at most 60");
  }
  return {};
}

void Scene::apply_force(const v1::Event::Force& force) {
  const SceneObject* object = find(force.object());
  if (!object) return;
  const uint64_t force_id = kPersonForceBit | next_force_++;
  world_->set_force(force_id, object->id, {vector_of(force.point_m()), vector_of(force.force_n())},
                    force.duration_s());
}

void Scene::apply(const v1::Event& event, uint64_t event_id) {
  // An edit may have taken the object away.
  const auto target = [&](const std::string& name) {
    const SceneObject* object = find_in_file(name);
    if (!object)
      log_warn("event at %.3f s: skipped, since object \"%s\" was removed; remove the event too, or undo",
               event.time_s(), name.c_str());
    return object;
  };
  switch (event.action_case()) {
    case v1::Event::kForce: {
      const v1::Event::Force& force = event.force();
      if (const SceneObject* object = target(force.object()))
        world_->set_force(kEventForceBit | event_id, object->id,
                          {vector_of(force.point_m()), vector_of(force.force_n())}, force.duration_s());
      break;
    }
    case v1::Event::kBall:
      shoot_ball(vector_of(event.ball().from_m()), vector_of(event.ball().velocity_m_s()));
      break;
    case v1::Event::kSetPhysics: {
      const SceneObject* found = target(event.set_physics().object());
      if (!found) break;
      SceneObject* const object = &drawn(found->id);
      auto merged = merge_scene_physics(object->physics, event.set_physics().physics(), *object->facts);
      if (!merged) {
        log_warn("%s: set_physics at %.3f s: %s", object->name.c_str(), event.time_s(),
                 merged.error().message.c_str());
        break;
      }
      if (auto set = take_physics(*object, std::move(*merged)); !set) {
        log_warn("%s: set_physics at %.3f s: %s", object->name.c_str(), event.time_s(),
                 set.error().message.c_str());
      }
      break;
    }
    case v1::Event::kReleaseRegion: {
      const SceneObject* object = target(event.release_region().object());
      if (!object) break;
      if (auto released = world_->release_region(object->id, event.release_region().region()); !released) {
        log_warn("%s: release_region at %.3f s: %s", object->name.c_str(), event.time_s(),
                 released.error().message.c_str());
      }
      break;
    }
    case v1::Event::kBreak: {
      const SceneObject* object = target(event.break_().object());
      if (!object) break;
      if (auto broken = world_->break_object(object->id, vector_of(event.break_().point_m())); !broken) {
        log_warn("%s: break at %.3f s: %s", object->name.c_str(), event.time_s(),
                 without_id(broken.error().message, object->id).c_str());
      }
      break;
    }
    case v1::Event::kGrab: {
      const SceneObject* object = target(event.grab().object());
      if (!object) break;
      const double now_s = static_cast<double>(world_->tick()) / world_->settings().rate_hz;
      auto grabbed = grabs_.begin(*world_, kEventForceBit | event_id, object->id,
                                  vector_of(event.grab().point_m()), paths_.at(event_id), now_s);
      if (!grabbed) {
        log_warn("%s: grab at %.3f s: %s", object->name.c_str(), event.time_s(),
                 grabbed.error().message.c_str());
      }
      break;
    }
    case v1::Event::kPull: {
      const SceneObject* object = target(event.pull().object());
      if (!object) break;
      const double now_s = static_cast<double>(world_->tick()) / world_->settings().rate_hz;
      grabs_.begin_pull(*world_, kEventForceBit | event_id, object->id, vector_of(event.pull().point_m()),
                        paths_.at(event_id), now_s);
      break;
    }
    case v1::Event::ACTION_NOT_SET:
      break;
  }
}

const SceneObject* Scene::find(std::string_view name) const {
  const auto found =
      std::find_if(objects_.begin(), objects_.end(), [&](const auto& one) { return one.name == name; });
  return found == objects_.end() ? nullptr : &*found;
}

const SceneObject* Scene::find_in_file(std::string_view name) const {
  const auto found = std::find_if(objects_.begin(), objects_.end(),
                                  [&](const auto& one) { return one.name == name && one.facts; });
  return found == objects_.end() ? nullptr : &*found;
}

const SceneObject* Scene::find(uint32_t object_id) const {
  const auto found = std::lower_bound(objects_.begin(), objects_.end(), object_id,
                                      [](const SceneObject& one, uint32_t id) { return one.id < id; });
  return found == objects_.end() || found->id != object_id ? nullptr : &*found;
}

const std::shared_ptr<const GaussianAsset>& Scene::ball_asset() {
  static const std::shared_ptr<const GaussianAsset> asset =
      std::make_shared<GaussianAsset>(mesh_asset(sphere_mesh(kBallRadius_m, 3), kBallRgb, 1500));
  return asset;
}

const SceneObject& Scene::shoot_ball(const Eigen::Vector3d& from_m, const Eigen::Vector3d& velocity_m_s) {
  if (balls_.size() == kMaxBalls) {
    const uint32_t oldest = balls_.front();
    balls_.pop_front();
    world_->remove(oldest);
    std::erase_if(objects_, [&](const SceneObject& one) { return one.id == oldest; });
    changes_.removed.push_back(oldest);
  }
  SceneObject drawn;
  drawn.id = next_id_++;
  drawn.name = "ball " + std::to_string(drawn.id);
  drawn.asset = ball_asset();
  drawn.mass_kg = kBallMass_kg;
  drawn.physics.set_label("ball");
  drawn.physics.set_material("rubber");
  drawn.physics.set_behavior(v1::Physics::RIGID);
  BallDescription ball;
  ball.object_id = drawn.id;
  ball.position_m = from_m;
  ball.velocity_m_s = velocity_m_s;
  ball.radius_m = kBallRadius_m;
  ball.mass_kg = kBallMass_kg;
  const auto added = world_->add_ball(ball);
  if (!added) log_error("ball: %s", added.error().message.c_str());
  balls_.push_back(drawn.id);
  return add_drawn(std::move(drawn), Similarity{});
}

Scene::Changes Scene::take_changes() { return std::exchange(changes_, {}); }

}  // namespace livegs
