// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/live/room_things.h"

#include <google/protobuf/util/message_differencer.h>
#include <pthread.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/content_hash.h"
#include "core/log.h"
#include "gaussian/asset_file.h"
#include "parts/click/click_cut.h"
#include "parts/click/kernel_on_ray.h"
#include "parts/graph/kernel_tree.h"
#include "parts/room_parts.h"
#include "scene/build/build_cache.h"
#include "scene/environment/environment_frame.h"
#include "scene/values/scene_values.h"
#include "session/support/redact_paths.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr uint16_t kMaxDivisions = 1000;  // of things by rays; each adds a label

struct Placed {
  Pose world_from_object;
  Eigen::Quaterniond rotation;
  double scale = 1.0;

  Vector3d world(const Vector3d& asset) const { return world_from_object * (scale * (rotation * asset)); }
  Vector3d asset_direction(const Vector3d& world) const {
    return rotation.conjugate() * (world_from_object.orientation.conjugate() * world);
  }
  Vector3d asset(const Vector3d& world) const {
    return rotation.conjugate() * (world_from_object.inverse() * world) / scale;
  }
};

Placed placed(const v1::Environment& environment, const AssetFrame& frame) {
  Placed at;
  at.world_from_object = pose_value(environment.pose(), "environment.pose").value();  // checked
  at.rotation = up_value(frame.up_axis, "environment.up").value();
  at.scale = frame.metres_per_unit;
  return at;
}

Result<Vector3d> ray_value(const Numbers& numbers, const char* field) {
  if (numbers.size() != 3)
    return invalid_argument(std::string("rays.") + field + ": must have three numbers");
  const Vector3d value(numbers[0], numbers[1], numbers[2]);
  if (!value.allFinite() || value.cwiseAbs().maxCoeff() > 1e6)
    return invalid_argument(std::string("rays.") + field + ": must be finite and at most 1e6 m");
  return value;
}

Eigen::AlignedBox3d world_box(const Placed& at, const Eigen::AlignedBox3d& box) {
  Eigen::AlignedBox3d all;
  for (int corner = 0; corner < 8; ++corner)
    all.extend(at.world(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner))));
  return all;
}

void set_numbers(Numbers& numbers, const Vector3d& value) {
  numbers.Clear();
  for (const double number : value) numbers.Add(number);
}

void set_pose(v1::PlacedAt& pose, const Vector3d& position_m, const Eigen::Quaterniond& orientation) {
  set_numbers(*pose.mutable_position_m(), position_m);
  const Eigen::Quaterniond q = orientation.normalized();
  pose.clear_orientation();
  for (const double number : {q.w(), q.x(), q.y(), q.z()}) pose.add_orientation(number);
}

bool remove_collider(const v1::Collider& collider, v1::Environment& environment) {
  auto& all = *environment.mutable_colliders();
  for (int i = 0; i < all.size(); ++i) {
    if (!google::protobuf::util::MessageDifferencer::Equals(all[i], collider)) continue;
    all.DeleteSubrange(i, 1);
    return true;
  }
  return false;
}

// Labels for the graph of a room: rays of users do not divide fills and undersides.
std::vector<uint16_t> joined_labels(const LabelledRoom& room) {
  std::vector<uint16_t> label = room.label;
  for (uint16_t& one : label) {
    const KernelKind kind = kind_of(one);
    if (kind != KernelKind::Own) one = kind == KernelKind::Covered ? uint16_t{0} : KernelGraph::kNotJoined;
  }
  return label;
}

}  // namespace

RoomThings::~RoomThings() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

RoomThings::Room RoomThings::room_of(LabelledRoom labelled, std::string labels_file,
                                     std::shared_ptr<const KernelGraph> graph) {
  Room room;
  for (size_t i = 0; i < labelled.label.size(); ++i) {
    const uint16_t label = labelled.label[i];
    if (label == 0 || kind_of(label) != KernelKind::Own) continue;
    Known& thing = room.things[label];
    thing.bounds.extend(labelled.asset.positions[i].cast<double>());
    ++thing.kernels;
  }
  room.labelled = std::move(labelled);
  room.labels_file = std::move(labels_file);
  room.graph = std::move(graph);
  return room;
}

void RoomThings::search(std::stop_token stop, const v1::Environment& environment) {
  const std::string& labels = environment.labels();
  const auto fail = [&](const std::string& reason) {
    log_info("room: %s", reason.c_str());
    std::lock_guard lock(mutex_);
    searching_.reset();
    failed_ = {labels, redact_paths(reason)};
  };
  const auto end = [&](LabelledRoom found) {
    auto graph = std::make_shared<KernelGraph>(
        found.asset, joined_labels(found),
        placed(environment, frame_of(environment)).asset_direction(Vector3d::UnitY()));
    auto room = std::make_shared<Room>(room_of(std::move(found), labels, std::move(graph)));
    log_info("room: %zu things can be taken", room->things.size());
    if (room->things.empty()) return fail("no separate thing was found; nothing can be taken");
    std::lock_guard lock(mutex_);
    searching_.reset();
    rooms_[labels] = std::move(room);
  };
  if (!labels.empty()) {
    auto kept = read_labelled_room(folder_ / labels);
    return kept ? end(std::move(*kept)) : fail(kept.error().message);
  }
  auto file = read_asset(folder_ / environment.asset());
  if (!file) return fail(file.error().message);
  const Placed at = placed(environment, frame_of(environment));
  PartsOptions options;
  options.up = at.asset_direction(Vector3d::UnitY());
  options.stop = stop;
  options.progress = [&](const char*, double fraction) {
    std::lock_guard lock(mutex_);
    progress_ = fraction;
  };
  auto found = find_parts(file->asset, options);
  if (stop.stop_requested()) return;
  if (!found) return fail(found.error().message);
  LabelledRoom room = label_room(file->asset, *found, stop);
  if (stop.stop_requested()) return;
  {
    std::lock_guard lock(mutex_);
    solids_ = room_solids(*found, options.up);
  }
  end(std::move(room));
}

AssetFrame RoomThings::frame_of(const v1::Environment& environment) const {
  const std::string stamp = BuildCache::stamp_of(folder_ / environment.asset());
  std::lock_guard lock(frame_mutex_);
  if (stamp != frame_stamp_) {
    named_frame_ = named_frame(folder_ / environment.asset());
    frame_stamp_ = stamp;
  }
  return environment_frame(environment, named_frame_);
}

v1::RoomParts RoomThings::describe(const v1::Environment& environment) {
  v1::RoomParts message;
  if (environment.asset().empty()) {
    message.set_reason("environment: has no captured room; name its splat as environment.asset");
    return message;
  }
  const std::lock_guard starting(starting_);
  std::unique_lock lock(mutex_);
  if (asset_ != environment.asset() && !searching_) {
    asset_ = environment.asset();
    rooms_.clear();
    solids_.clear();
    failed_.reset();
  }
  const bool own = asset_ == environment.asset();
  const auto known = own ? rooms_.find(environment.labels()) : rooms_.end();
  const bool failed = own && failed_ && failed_->first == environment.labels();
  if (known == rooms_.end() && !searching_ && !failed) {
    searching_ = environment.labels();
    progress_ = 0;
    lock.unlock();
    thread_ = std::jthread([this, environment](const std::stop_token& stop) {
      pthread_setname_np(pthread_self(), "room");
      search(stop, environment);
    });
    message.set_state(v1::RoomParts::PREPARING);
    return message;
  }
  if (known == rooms_.end()) {
    message.set_state(failed ? v1::RoomParts::FAILED : v1::RoomParts::PREPARING);
    message.set_progress(failed ? 0.0 : progress_);
    if (failed) message.set_reason(failed_->second);
    return message;
  }
  message.set_state(v1::RoomParts::READY);
  message.set_progress(1.0);
  const Placed at = placed(environment, frame_of(environment));
  for (const auto& [label, thing] : known->second->things) {
    v1::RoomParts::Part& part = *message.add_parts();
    const Eigen::AlignedBox3d box = world_box(at, thing.bounds);
    part.set_label(label);
    set_numbers(*part.mutable_min_m(), box.min());
    set_numbers(*part.mutable_max_m(), box.max());
    part.set_kernels(thing.kernels);
    part.set_taken(std::count(environment.taken().begin(), environment.taken().end(), label) > 0);
  }
  return message;
}

std::shared_ptr<const RoomThings::Room> RoomThings::room_for(const v1::Environment& environment) const {
  std::lock_guard lock(mutex_);
  const auto known = rooms_.find(environment.labels());
  return asset_ == environment.asset() && known != rooms_.end() ? known->second : nullptr;
}

const RoomThings::Shown& RoomThings::shown(std::shared_ptr<const Room> room,
                                           const v1::Environment& environment) {
  const std::vector<uint32_t> taken(environment.taken().begin(), environment.taken().end());
  if (shown_.room == room && shown_.taken == taken) return shown_;
  shown_.asset = room_without(room->labelled, taken, &shown_.kept);
  shown_.taken = taken;
  shown_.room = std::move(room);
  return shown_;
}

Result<RoomThings::Thing> RoomThings::under(const v1::TakePartRequest& request,
                                            const v1::Environment& environment) {
  const auto room = room_for(environment);
  if (!room)
    return Error{ErrorCode::Unavailable, "room: the search for things is not finished; try again later"};
  if (request.rays_size() < 1 || request.rays_size() > kMaxRays)
    return invalid_argument("rays: must be 1 to 32");
  const Shown& seen = shown(room, environment);
  const Placed at = placed(environment, frame_of(environment));
  const auto own_label = [&](uint32_t kernel) {
    const uint16_t label = room->labelled.label[kernel];
    return kind_of(label) == KernelKind::Own ? label : uint16_t{0};
  };
  std::vector<Click> clicks;
  std::set<uint16_t> labels, divided;
  bool corrected = false;  // by a ray at a kernel of the room
  for (const v1::PickRay& ray : request.rays()) {
    auto from = ray_value(ray.from_m(), "from_m");
    if (!from) return from.error();
    auto towards = ray_value(ray.towards(), "towards");
    if (!towards) return towards.error();
    if (!(towards->norm() > 0.0)) return invalid_argument("rays.towards: is zero; give a direction");
    const Vector3d start = at.asset(*from), direction = at.asset_direction(*towards).normalized();
    const auto hit = kernel_on_ray(seen.asset, start, direction);
    const uint32_t kernel = hit ? seen.kept[*hit] : 0;
    const uint16_t label = hit ? own_label(kernel) : uint16_t{0};
    if (label == 0 && !ray.away() && labels.empty())
      return not_found("rays: hit no thing that can be taken; aim at one");
    if (!hit) continue;
    clicks.push_back({kernel, !ray.away()});
    if (label == 0)
      corrected = corrected || !ray.away();
    else if (!ray.away())
      labels.insert(label);
    else if (labels.contains(label))
      divided.insert(label);
  }
  if (labels.empty()) return not_found("rays: nothing is left to take; aim at a thing");
  Thing thing;
  Eigen::AlignedBox3d box;
  if (corrected || !divided.empty()) {
    std::vector<uint16_t> label(room->labelled.label.size());
    for (uint32_t k = 0; k < label.size(); ++k) label[k] = own_label(k);
    std::vector<uint8_t> still_here(label.size(), 0);  // not those of things that were taken before
    for (const uint32_t k : seen.kept) still_here[k] = 1;
    thing.cut = cut_thing(*room->graph, label, clicks).kernels;
    std::erase_if(thing.cut, [&](uint32_t k) { return still_here[k] == 0; });
    for (const uint32_t kernel : thing.cut) {
      box.extend(room->labelled.asset.positions[kernel].cast<double>());
      if (label[kernel] != 0) labels.insert(label[kernel]);
    }
    if (thing.cut.empty()) return not_found("rays: nothing is left to take; aim at a thing");
    thing.kernels = static_cast<uint32_t>(thing.cut.size());
  }
  for (const uint16_t label : labels) {
    thing.labels.push_back(label);
    if (!thing.cut.empty()) continue;
    thing.kernels += room->things.at(label).kernels;
    box.extend(room->things.at(label).bounds);
  }
  thing.bounds_m = world_box(at, box);
  return thing;
}

uint16_t RoomThings::divide(LabelledRoom& labelled, const Thing& thing) {
  uint16_t taken = 0;
  for (const uint16_t label : labelled.label)
    taken = std::max(taken, static_cast<uint16_t>(label & kThingMask));
  ++taken;
  for (const uint32_t kernel : thing.cut) labelled.label[kernel] = taken;
  std::vector<Eigen::Vector3f> points;
  std::vector<uint16_t> owner;
  const auto concerned = [&](uint16_t label) {
    return label == taken || std::find(thing.labels.begin(), thing.labels.end(), label) != thing.labels.end();
  };
  for (uint32_t k = 0; k < labelled.label.size(); ++k) {
    if (kind_of(labelled.label[k]) != KernelKind::Own || !concerned(labelled.label[k])) continue;
    points.push_back(labelled.asset.positions[k]);
    owner.push_back(labelled.label[k]);
  }
  const KernelTree tree(points);
  std::vector<KernelTree::Neighbour> nearest;
  for (uint32_t k = 0; k < labelled.label.size(); ++k) {
    const KernelKind kind = kind_of(labelled.label[k]);
    if (kind == KernelKind::Own || !concerned(labelled.label[k] & kThingMask)) continue;
    tree.nearest(labelled.asset.positions[k], 1, nearest);
    labelled.label[k] = label_of(kind, owner[nearest[0].index]);
  }
  return taken;
}

Result<RoomThings::Taken> RoomThings::take(const Thing& thing, const v1::Environment& environment) {
  auto room = room_for(environment);
  if (!room)
    return Error{ErrorCode::Unavailable, "room: the search for things is not finished; try again later"};
  const auto before = room;
  uint16_t label = thing.labels.front();
  if (thing.labels.size() > 1 || !thing.cut.empty() || room->labels_file.empty()) {
    LabelledRoom joined = room->labelled;
    if (!thing.cut.empty()) {
      if (room->things.rbegin()->first >= kMaxParts + kMaxDivisions)
        return invalid_argument("room: too many takes; undo some of them");
      label = divide(joined, thing);
    } else {
      for (uint16_t& one : joined.label) {
        const auto own = static_cast<uint16_t>(one & kThingMask);
        if (std::find(thing.labels.begin(), thing.labels.end(), own) != thing.labels.end())
          one = label_of(kind_of(one), label);
      }
    }
    // Equal labels are one file; other files that name it stay valid.
    const std::string hash = content_hash(std::as_bytes(std::span(joined.label))).substr(0, 8);
    const std::string stem = fs::path(environment.asset()).stem().string();
    const std::string name = stem + "-" + hash + ".labels";
    if (auto written = write_labelled_room(folder_ / name, joined); !written) return written.error();
    auto read = read_labelled_room(folder_ / name);  // with the bits that later runs see
    if (!read) return read.error();
    room = std::make_shared<Room>(room_of(std::move(*read), name, before->graph));
    std::lock_guard lock(mutex_);
    rooms_[name] = room;
  }
  GaussianAsset asset = thing_alone(room->labelled, label);
  if (asset.size() == 0) return not_found("room: the thing has no kernels; take another");
  const Placed at = placed(environment, frame_of(environment));
  // The object's frame is at the middle of the thing's bottom.
  const Vector3d up = at.asset_direction(Vector3d::UnitY());
  const Eigen::AlignedBox3d& box = room->things.at(label).bounds;
  Vector3d origin = box.center();
  double lowest = INFINITY;
  for (const Eigen::Vector3f& position : asset.positions)
    lowest = std::min(lowest, up.dot(position.cast<double>()));
  origin += (lowest - up.dot(origin)) * up;
  for (Eigen::Vector3f& position : asset.positions)
    position = (position.cast<double>() - origin).cast<float>();
  const std::string stem = fs::path(room->labels_file).stem().string();
  const std::string file = stem + "-thing-" + std::to_string(label) + ".ply";
  if (auto written = write_asset(folder_ / file, asset); !written) return written.error();

  Taken taken{environment, {}};
  taken.environment.set_labels(room->labels_file);
  collide(*before, taken.environment);
  taken.environment.add_taken(label);
  for (const uint16_t one : thing.labels) {
    if (!remove_collider(box_around(before->things.at(one), environment), taken.environment)) continue;
    const auto rest = one == label ? room->things.end() : room->things.find(one);
    if (rest != room->things.end())
      *taken.environment.add_colliders() = box_around(rest->second, environment);
  }
  v1::Object& object = taken.object;
  object.set_asset(file);
  object.set_scale(at.scale);
  object.set_up(frame_of(environment).up_axis);
  *object.mutable_pose() = environment.pose();
  set_numbers(*object.mutable_pose()->mutable_position_m(), at.world(origin));
  object.set_standing(true);
  object.set_part(label);
  return taken;
}

v1::Collider RoomThings::box_around(const Known& thing, const v1::Environment& environment) const {
  const Placed at = placed(environment, frame_of(environment));
  v1::Collider collider;
  set_numbers(*collider.mutable_box()->mutable_size_m(), at.scale * thing.bounds.sizes());
  set_pose(*collider.mutable_pose(), at.world(thing.bounds.center()),
           at.world_from_object.orientation * at.rotation);
  return collider;
}

void RoomThings::collide(const Room& room, v1::Environment& environment) const {
  const std::vector<RoomSolid> solids = [&] {
    std::lock_guard lock(mutex_);
    return solids_;
  }();
  const bool own = environment.colliders_size() > 0 && !environment.collide();
  if (own || solids.empty()) return;
  environment.clear_collide();
  const Placed at = placed(environment, frame_of(environment));
  const Eigen::Quaterniond world_from_asset = at.world_from_object.orientation * at.rotation;
  for (const RoomSolid& solid : solids) {
    v1::Collider& collider = *environment.add_colliders();
    if (solid.size_m) {
      set_numbers(*collider.mutable_box()->mutable_size_m(), at.scale * *solid.size_m);
      set_pose(*collider.mutable_pose(), at.world(solid.point_m),
               world_from_asset * Eigen::Quaterniond(solid.axes));
    } else {
      set_numbers(*collider.mutable_plane()->mutable_point_m(), at.world(solid.point_m));
      set_numbers(*collider.mutable_plane()->mutable_normal(), world_from_asset * solid.normal);
    }
  }
  for (const auto& [label, thing] : room.things) {
    if (std::count(environment.taken().begin(), environment.taken().end(), label) == 0)
      *environment.add_colliders() = box_around(thing, environment);
  }
}

Result<v1::Environment> RoomThings::put_back(uint32_t label, v1::Environment environment) {
  (void)describe(environment);
  const auto room = room_for(environment);
  if (!room)
    return Error{ErrorCode::Unavailable, "room: the search for things is not finished; try again later"};
  auto& taken = *environment.mutable_taken();
  const auto place = std::find(taken.begin(), taken.end(), label);
  const auto thing =
      label <= kThingMask ? room->things.find(static_cast<uint16_t>(label)) : room->things.end();
  if (place == taken.end() || thing == room->things.end())
    return not_found("room: the thing is not in its labels; undo the step instead");
  taken.erase(place);
  // A room with other colliders than collide() makes has no boxes around its things.
  const auto has_box = [&](const Known& other) {
    const v1::Collider box = box_around(other, environment);
    return std::any_of(environment.colliders().begin(), environment.colliders().end(), [&](const auto& one) {
      return google::protobuf::util::MessageDifferencer::Equals(one, box);
    });
  };
  const bool boxes = std::all_of(room->things.begin(), room->things.end(), [&](const auto& other) {
    return other.first == label || std::find(taken.begin(), taken.end(), other.first) != taken.end() ||
           has_box(other.second);
  });
  if (boxes && !environment.collide()) *environment.add_colliders() = box_around(thing->second, environment);
  return environment;
}

}  // namespace livegs
