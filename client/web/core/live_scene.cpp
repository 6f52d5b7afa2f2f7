// SPDX-License-Identifier: Apache-2.0
#include "web/core/live_scene.h"

#include <algorithm>
#include <string>

#include "skin/kernels/skin_rigid_row.h"
#include "skin/skin_kernels.h"
#include "splat/frame_bounds.h"
#include "web/core/depth_keys.h"
#include "wire/rest_body_codec.h"

namespace livegs {
namespace {

// Kernels whose positions give the bounds of an object.
constexpr size_t kBoundsSample = 4096;

bool same_drivers(const ObjectDrivers& a, const ObjectDrivers& b) {
  const auto same_pose = [](const Pose& p, const Pose& q) {
    return p.position_m == q.position_m && p.orientation.coeffs() == q.orientation.coeffs();
  };
  return a.kind == b.kind && a.positions_m == b.positions_m &&
         std::equal(a.poses.begin(), a.poses.end(), b.poses.begin(), b.poses.end(), same_pose);
}

}  // namespace

Result<bool> LiveScene::describe(uint32_t description, uint32_t id, bool added, bool environment, bool hidden,
                                 std::span<const std::byte> rest_body) {
  auto rest = decode_rest_body(rest_body);
  if (!rest) return rest.error();
  if (rest->kind == DriverKind::Particles)
    return unsupported("particles cannot be drawn in a browser; use livegs-client");
  hidden_[id] = hidden;
  const auto same = [&](const auto& one) {
    return one.second.id == id && one.second.rest.revision == rest->revision;
  };
  const auto known = std::find_if(descriptions_.begin(), descriptions_.end(), same);
  if (!added && known != descriptions_.end()) return false;
  if (added) std::erase_if(descriptions_, [id](const auto& one) { return one.second.id == id; });
  // An environment is rigid; an elastic one is ordered as any object is.
  const bool biased = environment && rest->kind == DriverKind::Rigid;
  descriptions_[description] = {id, added, biased, false, *std::move(rest)};
  return true;
}

void LiveScene::remove(uint32_t id) {
  std::erase_if(descriptions_, [id](const auto& one) { return one.second.id == id; });
  objects_.erase(id);
  hidden_.erase(id);
  drawn_changed_ = std::erase(drawn_, id) > 0 || drawn_changed_;
}

size_t LiveScene::waiting() const {
  return static_cast<size_t>(std::count_if(descriptions_.begin(), descriptions_.end(),
                                           [](const auto& one) { return !one.second.bound; }));
}

// The lowest free range of indices.
uint32_t LiveScene::reserve(uint32_t kernels) const {
  std::vector<std::pair<uint32_t, uint32_t>> used;
  for (const auto& [id, revisions] : objects_) {
    for (const auto& [revision, object] : revisions)
      used.push_back({object.base, object.base + object.reserved});
  }
  std::sort(used.begin(), used.end());
  uint32_t base = 0;
  for (const auto& [begin, end] : used) {
    if (begin - base >= kernels) break;
    base = end;
  }
  return base;
}

void LiveScene::begin_bound(uint32_t description, uint32_t reserved) {
  bound_ = {};
  bound_.description = description;
  bound_.reserved = reserved;
  const auto found = descriptions_.find(description);
  bound_.environment = found != descriptions_.end() && found->second.environment;
}

void LiveScene::take_rows(std::span<const RestKernelRow> rows) {
  for (const RestKernelRow& row : rows) bound_.kernels.push_back({row.driver, row.at_x, row.at_y, row.at_z});
  if (bound_.environment) bound_.rows_at_rest.insert(bound_.rows_at_rest.end(), rows.begin(), rows.end());
}

void LiveScene::bind_failed(uint32_t description) { descriptions_.erase(description); }

Result<bool> LiveScene::end_bound(std::span<const NodeGradientTerm> node_terms,
                                  std::span<const uint32_t> node_terms_begin) {
  Object bound = std::exchange(bound_, {});
  const auto found = descriptions_.find(bound.description);
  if (found == descriptions_.end()) return false;
  Description& description = found->second;
  const RestBody& rest = description.rest;
  const bool lattice = rest.kind == DriverKind::Lattice;
  const size_t drivers = lattice ? rest.cells.size() : rest.bodies.size(),
               nodes = rest.node_coordinates.size();
  const auto names_driver = [&](const PlacedKernel& kernel) { return kernel.driver < drivers; };
  if (!std::all_of(bound.kernels.begin(), bound.kernels.end(), names_driver))
    return invalid_data("bound kernels: a kernel has no driver");
  if (lattice && (node_terms_begin.size() != nodes + 1 || node_terms_begin.front() != 0 ||
                  node_terms_begin.back() != node_terms.size() ||
                  !std::is_sorted(node_terms_begin.begin(), node_terms_begin.end()) ||
                  !std::all_of(node_terms.begin(), node_terms.end(), [&](const NodeGradientTerm& term) {
                    return term.neighbour < nodes && term.axis < 3;
                  })))
    return invalid_data("bound kernels: the terms of the nodes do not fit the lattice");
  bound.rest = rest;
  bound.bindings.kind = rest.kind;
  bound.bindings.node_terms.assign(node_terms.begin(), node_terms.end());
  bound.bindings.node_terms_begin.assign(node_terms_begin.begin(), node_terms_begin.end());
  if (lattice) bound.outside = kernels_outside(bound.kernels);
  const uint32_t id = description.id;
  if (std::exchange(description.added, false)) objects_.erase(id);
  description.bound = true;
  Revisions& revisions = objects_[id];
  bound.reserved = std::max(bound.reserved, static_cast<uint32_t>(bound.size()));
  const auto coarser = revisions.find(rest.revision);
  if (coarser != revisions.end() && coarser->second.reserved >= bound.reserved) {
    bound.base = coarser->second.base;
    bound.reserved = coarser->second.reserved;
  } else {
    bound.base = reserve(bound.reserved);
  }
  if (coarser != revisions.end() && coarser->second.posed_by) pose(bound, *coarser->second.posed_by);
  revisions.insert_or_assign(rest.revision, std::move(bound));
  drawn_changed_ = true;
  return true;
}

Result<void> LiveScene::take_frame(std::span<const std::byte> bytes, int64_t received_ns) {
  auto drivers = reader_.read(bytes);
  if (!drivers) return drivers.error();
  playout_.add({std::make_shared<const DriverFrame>(*std::move(drivers)), received_ns});
  return {};
}

void LiveScene::pose(Object& object, const ObjectDrivers& drivers) {
  object.posed_by = drivers;
  object.rows = pack_driver_rows(object.rest, object.bindings, drivers);
  skin_positions(object.rest, object.kernels, object.outside, object.rows, object.positions);
  if (object.environment) {
    for (std::vector<float>& column : object.covariances_m2) column.resize(object.size());
    for (size_t k = 0; k < object.size(); ++k) {
      const RestKernelRow& rest = object.rows_at_rest[k];
      const PosedKernelRow posed = skin_rigid_row(rest, object.rows.bodies[rest.driver]);
      const float s[6] = {posed.sxx_m2, posed.sxy_m2, posed.sxz_m2, posed.syy_m2, posed.syz_m2, posed.szz_m2};
      for (size_t i = 0; i < 6; ++i) object.covariances_m2[i][k] = s[i];
    }
  }
  object.moved = object.keys_stale = true;
}

bool LiveScene::play(int64_t now_ns) {
  const auto frame = playout_.at(now_ns, now_ns);
  if (!frame) return false;
  bool changed = std::exchange(drawn_changed_, false);
  const std::vector<uint32_t> drawn_before = std::exchange(drawn_, {});
  for (const ObjectDrivers& drivers : frame->objects) {
    const auto found = objects_.find(drivers.object_id);
    if (found == objects_.end() || found->second.empty() || hidden_[drivers.object_id]) continue;
    Revisions& revisions = found->second;
    // Shown times ascend, so revisions older than this frame are no longer needed.
    if (const auto newer = revisions.find(drivers.revision);
        newer != revisions.end() && newer != revisions.begin()) {
      for (auto old = revisions.begin(); old != newer; ++old) descriptions_.erase(old->second.description);
      revisions.erase(revisions.begin(), newer);
      changed = true;
    }
    Object& object = revisions.begin()->second;
    object.moved = object.fresh;
    const bool yet_to_come = drivers.revision > revisions.rbegin()->first;
    if (yet_to_come && !object.posed_by) continue;
    if (!yet_to_come && (!object.posed_by || !same_drivers(*object.posed_by, drivers))) {
      if (check_drivers(object.rest, drivers)) {
        pose(object, drivers);
      } else if (!object.posed_by) {
        continue;
      }
    }
    changed = changed || object.moved;
    drawn_.push_back(drivers.object_id);
  }
  return changed || drawn_ != drawn_before;
}

LiveScene::Object* LiveScene::shown(uint32_t id) {
  const auto found = objects_.find(id);
  return found == objects_.end() || found->second.empty() ? nullptr : &found->second.begin()->second;
}
const LiveScene::Object* LiveScene::find(uint32_t id) const {
  return const_cast<LiveScene*>(this)->shown(id);
}

Eigen::AlignedBox3f LiveScene::bounds_m(uint32_t id) const {
  std::vector<Eigen::Vector3f> sample;
  if (const Object* object = find(id)) {
    const KernelPositions& at = object->positions;
    for (size_t k = 0; k < at.size(); k += 1 + at.size() / kBoundsSample)
      sample.push_back({at.x_m[k], at.y_m[k], at.z_m[k]});
  }
  return robust_bounds(sample).cast<float>();
}

void LiveScene::kernels_sent(uint32_t id) {
  if (Object* object = shown(id)) object->fresh = false;
}

void LiveScene::set_view(const OrderView& view) {
  view_ = view;
  for (auto& [id, revisions] : objects_) {
    for (auto& [revision, object] : revisions) object.keys_stale = true;
  }
}

void LiveScene::update_keys() {
  for (const uint32_t id : drawn_) {
    Object& object = *shown(id);
    if (!std::exchange(object.keys_stale, false) && object.keys.size() == object.size()) continue;
    object.keys.resize(object.size());
    fill_depth_keys(view_, object.positions, object.environment ? &object.covariances_m2 : nullptr,
                    object.keys);
  }
}

std::span<const uint32_t> LiveScene::sort() {
  std::vector<KeyRun> runs;
  for (const uint32_t id : drawn_) runs.push_back({shown(id)->keys, shown(id)->base});
  return order_.sort(runs);
}

}  // namespace livegs
