// SPDX-License-Identifier: Apache-2.0
#include "render/scene_view.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "core/assert.h"
#include "core/clock.h"
#include "core/log.h"
#include "render/view/pick_kernel.h"
#include "splat/frame_bounds.h"

namespace livegs {
namespace {

bool same_drivers(const ObjectDrivers& a, const ObjectDrivers& b) {
  const auto same_pose = [](const Pose& p, const Pose& q) {
    return p.position_m == q.position_m && p.orientation.coeffs() == q.orientation.coeffs();
  };
  const auto same_turn = [](const Eigen::Quaternionf& p, const Eigen::Quaternionf& q) {
    return p.coeffs() == q.coeffs();
  };
  if (a.kernels || b.kernels) return a.kernels == b.kernels;
  return a.kind == b.kind && a.positions_m == b.positions_m &&
         std::equal(a.poses.begin(), a.poses.end(), b.poses.begin(), b.poses.end(), same_pose) &&
         std::equal(a.rotations.begin(), a.rotations.end(), b.rotations.begin(), b.rotations.end(),
                    same_turn);
}

Result<void> fits(size_t kernels, const RestBody& rest, const ObjectDrivers& drivers) {
  if (!drivers.kernels) return check_drivers(rest, drivers);
  if (const size_t received = drivers.kernels->positions_m.size(); received != kernels)
    return invalid_data(std::to_string(received) + " kernels were received, the object has " +
                        std::to_string(kernels));
  return {};
}

// Whether a ray enters a box: the intervals between each pair of faces overlap.
bool meets(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction,
           const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return false;
  double enters = 0, leaves = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0) {
      if (origin_m[axis] < box.min()[axis] || origin_m[axis] > box.max()[axis]) return false;
      continue;
    }
    const double a = (box.min()[axis] - origin_m[axis]) / direction[axis];
    const double b = (box.max()[axis] - origin_m[axis]) / direction[axis];
    enters = std::max(enters, std::min(a, b));
    leaves = std::min(leaves, std::max(a, b));
  }
  return enters <= leaves;
}

}  // namespace

Result<void> SceneView::add(uint32_t object_id, std::shared_ptr<const GaussianAsset> asset, RestBody rest,
                            bool environment) {
  objects_.erase(object_id);
  return change(object_id, std::move(asset), std::move(rest), environment);
}

Result<void> SceneView::change(uint32_t object_id, std::shared_ptr<const GaussianAsset> asset, RestBody rest,
                               bool environment) {
  if (has(object_id, rest.revision)) return {};
  auto bound = bind_object(object_id, std::move(asset), std::move(rest), environment);
  if (!bound) return bound.error();
  change(object_id, *std::move(bound));
  return {};
}

void SceneView::add(uint32_t object_id, BoundObject object) {
  objects_.erase(object_id);
  change(object_id, std::move(object));
}

void SceneView::change(uint32_t object_id, BoundObject bound) {
  if (has(object_id, bound.rest.revision)) return;
  Object& object = objects_[object_id][bound.rest.revision];
  object.asset = std::move(bound.asset);
  object.rest = std::move(bound.rest);
  object.bindings = std::move(bound.bindings);
  object.reach = std::move(bound.reach);
  object.shape = std::move(bound.shape);
  object.environment = bound.environment;
  object.asset_version = ++last_version_;
}

bool SceneView::has(uint32_t object_id, uint32_t revision) const {
  const auto known = objects_.find(object_id);
  return known != objects_.end() && known->second.contains(revision);
}

void SceneView::refine(uint32_t object_id, BoundObject bound) {
  if (!has(object_id, bound.rest.revision)) return;
  Object& object = objects_.at(object_id).at(bound.rest.revision);
  object.asset = std::move(bound.asset);
  object.rest = std::move(bound.rest);
  object.bindings = std::move(bound.bindings);
  object.reach = std::move(bound.reach);
  object.shape = std::move(bound.shape);
  object.environment = bound.environment;
  object.asset_version = ++last_version_;
  if (object.posed_by) object.posed_version = ++last_version_;
}

const SceneView::Object* SceneView::shown(uint32_t object_id) const {
  const auto found = objects_.find(object_id);
  return found == objects_.end() ? nullptr : &found->second.begin()->second;
}

std::shared_ptr<const GaussianAsset> SceneView::asset(uint32_t object_id) const {
  const Object* object = shown(object_id);
  return object ? object->asset : nullptr;
}

void SceneView::recolour(uint32_t object_id, std::shared_ptr<const GaussianAsset> asset) {
  const auto found = objects_.find(object_id);
  if (found == objects_.end()) return;
  Object& object = found->second.begin()->second;
  LIVEGS_ASSERT(asset->size() == object.asset->size());
  object.asset = std::move(asset);
  object.asset_version = ++last_version_;
}

void SceneView::remove(uint32_t object_id) {
  ++last_version_;
  objects_.erase(object_id);
  std::erase(visible_, object_id);
}

Result<void> SceneView::pose(const DriverFrame& frame) {
  times_.skin_ms = times_.shadow_ms = 0;
  times_.objects_moved = times_.objects_skinned = 0;
  const std::vector<uint32_t> visible_before = std::exchange(visible_, {});
  for (const ObjectDrivers& drivers : frame.objects) {
    const auto found = objects_.find(drivers.object_id);
    if (found == objects_.end()) continue;
    std::map<uint32_t, Object>& revisions = found->second;
    // Shown times ascend, so revisions older than this frame are no longer needed.
    if (const auto newer = revisions.find(drivers.revision);
        newer != revisions.end() && newer != revisions.begin()) {
      revisions.erase(revisions.begin(), newer);
      ++last_version_;
    }
    Object& object = revisions.begin()->second;
    const bool yet_to_come = drivers.revision > revisions.rbegin()->first;
    if (yet_to_come && !object.posed_by) continue;
    if (!yet_to_come && (!object.posed_by || !same_drivers(*object.posed_by, drivers))) {
      if (auto checked = fits(object.asset->size(), object.rest, drivers); !checked) {
        return Error{checked.error().code,
                     "object " + std::to_string(drivers.object_id) + ": " + checked.error().message};
      }
      object.posed_by = drivers;
      object.posed_version = ++last_version_;
      ++times_.objects_moved;
    }
    visible_.push_back(drivers.object_id);
  }
  if (visible_ != visible_before) ++last_version_;
  return {};
}

Result<void> SceneView::prepare(const DriverFrame& frame) {
  if (auto posed = pose(frame); !posed) return posed;
  cast_shadows();
  (void)rendered(*renderer_);
  return {};
}

void SceneView::cast_shadows() {
  shadow_table_ = nullptr;
  if (!draws_shadows_) return;
  const int64_t begun_ns = now_ns();
  std::vector<uint32_t> casting;
  PosedKernels posed;
  for (uint32_t id : visible_) {
    Object& object = objects_.at(id).begin()->second;
    if (object.shape.size() == 0) continue;
    casting.push_back(id);
    if (object.shadow_version == object.posed_version) continue;
    object.shape.pose(object.rest, *object.posed_by, posed);
    shadows_.set(id,
                 {posed.positions_m, posed.covariances_m2, object.shape.weights(), object.shape.bodies()});
    object.shadow_version = object.posed_version;
  }
  shadows_.keep(casting);
  shadow_table_ = &shadows_.table();
  times_.shadow_ms += milliseconds_from_ns(now_ns() - begun_ns);
}

const PosedKernels& SceneView::kernels_of(const Object& object) const {
  if (object.posed_by && object.posed_by->kernels) return *object.posed_by->kernels;
  if (!object.posed_by || object.skinned_version == object.posed_version) return object.kernels;
  const int64_t begun_ns = now_ns();
  skin_kernels(*object.asset, object.rest, object.bindings, *object.posed_by, object.kernels);
  object.skinned_version = object.posed_version;
  ++times_.objects_skinned;
  times_.skin_ms += milliseconds_from_ns(now_ns() - begun_ns);
  return object.kernels;
}

Result<void> SceneView::draw(const DriverFrame& frame, std::span<const Camera> eyes,
                             std::vector<Image>& images) {
  if (auto posed = pose(frame); !posed) return posed;
  return draw(eyes, nullptr, images);
}

Result<void> SceneView::draw(std::span<const Camera> eyes, std::vector<Image>& images) {
  return draw(eyes, nullptr, images);
}

Result<void> SceneView::draw_into(const DriverFrame& frame, std::span<const Camera> eyes,
                                  const DeviceImage& image, std::vector<Image>& images) {
  images.clear();
  if (auto posed = pose(frame); !posed) return posed;
  return draw(eyes, &image, images);
}

std::vector<RenderedObject> SceneView::rendered(const SplatRenderer& renderer) const {
  std::vector<RenderedObject> objects;
  for (uint32_t id : visible_) {
    const Object& object = *shown(id);
    const bool driven = !object.posed_by->kernels;
    const PosedKernels* kernels = driven && renderer.skins(object.rest.kind) ? nullptr : &kernels_of(object);
    objects.push_back({{object.asset.get(), kernels, id},
                       object.posed_version,
                       object.asset_version,
                       driven ? SkinnedBy{&object.rest, &object.bindings, &*object.posed_by} : SkinnedBy{}});
  }
  return objects;
}

DrawnObject SceneView::drawn(uint32_t object_id) const {
  const Object& object = *shown(object_id);
  return {object.asset.get(), &kernels_of(object), object_id};
}

std::vector<DrawnObject> SceneView::drawn_near(const Eigen::AlignedBox3f& box_m) const {
  std::vector<DrawnObject> near;
  for (uint32_t id : visible_) {
    const Object& object = *shown(id);
    if (box_of_kernels(object.reach, *object.posed_by).intersects(box_m)) near.push_back(drawn(id));
  }
  return near;
}

std::optional<DrawnObject> SceneView::drawn_object(uint32_t object_id) const {
  if (std::find(visible_.begin(), visible_.end(), object_id) == visible_.end()) return std::nullopt;
  return drawn(object_id);
}

void SceneView::set_background(const std::optional<Eigen::Vector3f>& rgb) {
  if (rgb == background_rgb_) return;
  background_rgb_ = rgb;
  ++last_version_;
}

RenderOptions SceneView::options_for(std::span<const Camera> eyes) const {
  const Camera& eye = eyes.front();
  RenderOptions options;
  options.background = background_rgb_.value_or(kBackground);
  // Sorting by distance from the point between the eyes is invariant to head rotation, so kernels do not pop,
  // and both eyes share one order. Captures are trained with depth order; the error of either order is in
  // tests/bench/results, order.csv. A single eye uses depth, as `livegs render` does.
  options.order = eyes.size() == 2 ? DepthOrder::Distance : DepthOrder::ViewZ;
  options.min_contribution_px = min_contribution_px_;
  options.shadows = shadow_table_;
  for (uint32_t id : visible_) {
    if (shown(id)->environment) options.environments.push_back(id);
  }
  options.max_radius_px =
      static_cast<float>((min_contribution_px_ > 0 ? 1 : 2) * std::max(eye.width, eye.height));
  return options;
}

Result<void> SceneView::draw_again(SplatRenderer& renderer, std::span<const Camera> eyes,
                                   std::vector<Image>& images) const {
  return renderer.draw(rendered(renderer), eyes, options_for(eyes), images);
}

Result<void> SceneView::draw(std::span<const Camera> eyes, const DeviceImage* image,
                             std::vector<Image>& images) {
  cast_shadows();
  std::vector<RenderedObject> objects = rendered(*renderer_);
  int64_t begun_ns = now_ns();
  const RenderOptions options = options_for(eyes);
  auto done = image ? renderer_->draw_into(objects, eyes, options, *image)
                    : renderer_->draw(objects, eyes, options, images);
  if (image && !done && done.error().code == ErrorCode::Unsupported)
    done = renderer_->draw(objects, eyes, options, images);
  if (!done && !draws_on_cpu_) {
    renderer_ = create_cpu_renderer_instead_of(renderer_->name(), done.error());
    log_warn("%s", renderer_->notice().c_str());
    draws_on_cpu_ = true;
    objects = rendered(*renderer_);
    begun_ns = now_ns();
    done = renderer_->draw(objects, eyes, options, images);
  }
  if (!done) return done;
  times_.raster_ms = milliseconds_from_ns(now_ns() - begun_ns);
  times_.device = renderer_->last_times().device;
  return {};
}

std::vector<Eigen::AlignedBox3d> SceneView::object_boxes() const {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (uint32_t id : visible_) {
    if (shown(id)->environment) continue;
    if (const Eigen::AlignedBox3d box = bounds(id); !box.isEmpty()) boxes.push_back(box);
  }
  return boxes;
}

Eigen::AlignedBox3d SceneView::bounds(uint32_t object_id) const {
  const Object* object = shown(object_id);
  return object ? robust_bounds(kernels_of(*object).positions_m) : Eigen::AlignedBox3d();
}

std::optional<SceneView::Picked> SceneView::pick(const Eigen::Vector3d& origin_m,
                                                 const Eigen::Vector3d& direction) const {
  std::vector<DrawnObject> in_the_way;
  for (uint32_t id : visible_) {
    const Object& object = *shown(id);
    if (meets(origin_m, direction, box_of_kernels(object.reach, *object.posed_by).cast<double>()))
      in_the_way.push_back(drawn(id));
  }
  const auto met = pick_kernel(in_the_way, origin_m, direction);
  if (!met) return std::nullopt;
  const uint32_t id = in_the_way[met->object].object_id;
  const Object& object = *shown(id);
  return Picked{id, object.environment, met->kernel, origin_m + met->distance_m * direction,
                object.rest.object_from_asset * object.asset->positions[met->kernel].cast<double>()};
}

std::optional<size_t> SceneView::nearest_kernel(uint32_t object_id,
                                                const Eigen::Vector3d& rest_point_m) const {
  const Object* object = shown(object_id);
  if (!object || object->asset->size() == 0) return std::nullopt;
  const auto distance = [&](const Eigen::Vector3f& position) {
    return (object->rest.object_from_asset * position.cast<double>() - rest_point_m).squaredNorm();
  };
  const auto& positions = object->asset->positions;
  const auto nearest =
      std::min_element(positions.begin(), positions.end(),
                       [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  return static_cast<size_t>(nearest - positions.begin());
}

std::optional<Eigen::Vector3d> SceneView::kernel_position_m(uint32_t object_id, size_t kernel) const {
  const Object* object = shown(object_id);
  if (!object || kernel >= object->asset->size() || !object->posed_by) return std::nullopt;
  return kernels_of(*object).positions_m[kernel].cast<double>();
}

std::optional<Eigen::Vector3d> SceneView::environment_middle() const {
  for (uint32_t id : visible_) {
    const Object& object = *shown(id);
    if (!object.environment || object.asset->size() == 0) continue;
    const std::vector<Eigen::Vector3f>& positions_m = kernels_of(object).positions_m;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3f& position : positions_m) sum += position.cast<double>();
    return sum / static_cast<double>(positions_m.size());
  }
  return std::nullopt;
}

}  // namespace livegs
