// SPDX-License-Identifier: Apache-2.0
#include "web/core/live_scene.h"

#include <algorithm>
#include <string>

#include "skin/kernels/skin_rigid_row.h"
#include "skin/skin_kernels.h"
#include "splat/frame_bounds.h"
#include "splat/passes/kernel_looks.h"
#include "splat/project/raster_options.h"
#include "viewer/assets/rest_of_part.h"
#include "wire/rest_body_codec.h"

namespace livegs {
namespace {

bool same_drivers(const ObjectDrivers& a, const ObjectDrivers& b) {
  const auto same_pose = [](const Pose& p, const Pose& q) {
    return p.position_m == q.position_m && p.orientation.coeffs() == q.orientation.coeffs();
  };
  return a.kind == b.kind && a.positions_m == b.positions_m &&
         std::equal(a.poses.begin(), a.poses.end(), b.poses.begin(), b.poses.end(), same_pose);
}

}  // namespace

Result<void> LiveScene::take_asset(uint32_t asset, std::span<const std::byte> bytes) {
  Asset& one = assets_[asset];
  if (one.whole) return {};
  if (auto taken = one.decoder.take(bytes); !taken) return taken;
  one.kernel_count = static_cast<uint32_t>(one.decoder.kernel_count());
  if (one.decoder.complete()) {
    one.whole = std::make_shared<const AssetPart>(one.decoder.part());
    one.decoder = {};
  }
  return {};
}

bool LiveScene::asset_complete(uint32_t asset) const {
  const auto found = assets_.find(asset);
  return found != assets_.end() && found->second.whole;
}

size_t LiveScene::asset_arrived(uint32_t asset) const {
  const auto found = assets_.find(asset);
  return found == assets_.end() ? 0 : found->second.arrived();
}

Result<void> LiveScene::describe(uint32_t id, bool added, bool environment, bool hidden, uint32_t asset,
                                 std::span<const std::byte> rest_body) {
  auto rest = decode_rest_body(rest_body);
  if (!rest) return rest.error();
  if (rest->kind == DriverKind::Particles) return unsupported("the browser client does not draw particles");
  hidden_[id] = hidden;
  const ObjectRevision key{id, rest->revision};
  const auto known = objects_.find(id);
  const bool is_there =
      (known != objects_.end() && known->second.contains(rest->revision)) || waiting_.contains(key);
  if (is_there && !added) return {};
  waiting_[key] = {added, environment, asset, std::make_shared<const RestBody>(*std::move(rest))};
  return {};
}

void LiveScene::remove(uint32_t id) {
  const auto is_its = [id](const auto& one) { return one.first.first == id; };
  std::erase_if(waiting_, is_its);
  std::erase_if(coarse_, is_its);
  objects_.erase(id);
  hidden_.erase(id);
  drawn_changed_ = std::erase(drawn_, id) > 0 || drawn_changed_;
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

Result<void> LiveScene::bind(uint32_t id, const Description& description) {
  const Asset& asset = assets_.at(description.asset);
  const auto part = asset.whole ? asset.whole : std::make_shared<const AssetPart>(asset.decoder.part());
  Object bound;
  bound.environment = description.environment;
  bound.sh_degree = part->asset.sh_degree;
  bound.antialiased = part->asset.antialiased;
  bound.rest = rest_of_part(*description.rest, part->indices);
  auto bindings = bind_kernels(part->asset, bound.rest);
  if (!bindings) return bindings.error();
  bound.bindings = *std::move(bindings);
  bound.unpacked = part;
  const uint32_t revision = description.rest->revision;
  if (description.added) {
    objects_.erase(id);
    std::erase_if(coarse_, [id](const auto& one) { return one.first.first == id; });
  }
  Revisions& revisions = objects_[id];
  if (const auto coarser = revisions.find(revision); coarser != revisions.end()) {
    bound.base = coarser->second.base;
    bound.reserved = coarser->second.reserved;
    if (coarser->second.posed_by) pose(bound, *coarser->second.posed_by);
  } else {
    bound.reserved = std::max(asset.kernel_count, static_cast<uint32_t>(part->asset.size()));
    bound.base = reserve(bound.reserved);
  }
  revisions.insert_or_assign(revision, std::move(bound));
  drawn_changed_ = true;
  return {};
}

Result<bool> LiveScene::bind_arrived() {
  bool any = false;
  Result<bool> failed = false;
  const auto bind_more = [&](std::map<ObjectRevision, Description>& descriptions) {
    for (auto at = descriptions.begin(); at != descriptions.end();) {
      Description description = at->second;
      const ObjectRevision key = at->first;
      const auto asset = assets_.find(description.asset);
      const size_t arrived = asset == assets_.end() ? 0 : asset->second.arrived();
      // Parts double in size, since each part costs as much as it holds.
      if (arrived == 0 || (arrived != SIZE_MAX && arrived / 2 < description.bound) ||
          arrived == description.bound) {
        ++at;
        continue;
      }
      at = descriptions.erase(at);
      if (auto bound = bind(key.first, description); !bound) {
        failed = bound.error();
        continue;
      }
      any = true;
      description.added = false;
      description.bound = arrived;
      if (arrived != SIZE_MAX) coarse_.insert_or_assign(key, std::move(description));
      if (&descriptions == &coarse_) at = coarse_.upper_bound(key);
    }
  };
  bind_more(coarse_);
  bind_more(waiting_);
  return failed ? Result<bool>(any) : failed;
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
  skin_positions(object.rest, object.bindings, object.rows, object.positions_m);
  if (object.environment && object.rest.kind == DriverKind::Rigid) {
    std::vector<RestKernelRow> rest(object.size());
    pack_rest_rows(object.bindings, {}, 0, rest);
    object.posed.resize(rest.size());
    for (size_t k = 0; k < rest.size(); ++k)
      object.posed[k] = skin_rigid_row(rest[k], object.rows.bodies[rest[k].driver]);
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
      for (auto old = revisions.begin(); old != newer; ++old) coarse_.erase({drivers.object_id, old->first});
      revisions.erase(revisions.begin(), newer);
      changed = true;
    }
    Object& object = revisions.begin()->second;
    object.moved = object.unpacked != nullptr;
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

const LiveScene::Object* LiveScene::find(uint32_t id) const {
  const auto found = objects_.find(id);
  return found == objects_.end() || found->second.empty() ? nullptr : &found->second.begin()->second;
}

LiveScene::Packed LiveScene::packed(uint32_t id) {
  Packed packed;
  const auto found = objects_.find(id);
  if (found == objects_.end() || found->second.empty()) return packed;
  Object& object = found->second.begin()->second;
  const auto part = std::exchange(object.unpacked, nullptr);
  if (!part) return packed;
  const GaussianAsset& asset = part->asset;
  packed.rest.resize(asset.size());
  pack_rest_rows(object.bindings, {}, 0, packed.rest);
  const size_t words = sh_row_words(asset);
  packed.bands.resize(asset.size() * words);
  packed.looks.reserve(asset.size());
  for (size_t k = 0; k < asset.size(); ++k) {
    packed.looks.push_back(look_row(asset, k));
    pack_bands(asset, k, std::span(packed.bands).subspan(k * words, words));
  }
  packed.bounds_m = robust_bounds(object.positions_m).cast<float>();
  // From here on, only positions are computed, except for an environment.
  if (!object.environment) object.bindings.rest_covariances_m2 = {};
  return packed;
}

void LiveScene::set_view(const OrderView& view) {
  view_ = view;
  for (auto& [id, revisions] : objects_) {
    for (auto& [revision, object] : revisions) object.keys_stale = true;
  }
}

void LiveScene::update_keys() {
  for (const uint32_t id : drawn_) {
    Object& object = objects_.at(id).begin()->second;
    if (!std::exchange(object.keys_stale, false) && object.keys.size() == object.size()) continue;
    object.keys.resize(object.size());
    if (!object.posed.empty()) {
      for (size_t k = 0; k < object.posed.size(); ++k)
        object.keys[k] = ordered_key(order_depth(view_, object.posed[k], kEnvironmentOrderBias));
      continue;
    }
    const Row3 o = view_.origin_m;
    for (size_t k = 0; k < object.positions_m.size(); ++k) {
      const Eigen::Vector3f& x = object.positions_m[k];
      object.keys[k] = ordered_key(order_depth(view_, Row3{x[0] - o.x, x[1] - o.y, x[2] - o.z}));
    }
  }
}

std::span<const uint32_t> LiveScene::sort() {
  size_t count = 0;
  for (const uint32_t id : drawn_) count += objects_.at(id).begin()->second.keys.size();
  items_.resize(count);
  KeyedIndex* item = items_.data();
  for (const uint32_t id : drawn_) {
    const Object& object = objects_.at(id).begin()->second;
    for (uint32_t k = 0; k < object.keys.size(); ++k) *item++ = {object.keys[k], object.base + k};
  }
  radix_sort(items_, scratch_);
  order_.resize(count);
  for (size_t i = 0; i < count; ++i) order_[i] = items_[i].index;
  return order_;
}

}  // namespace livegs
