// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/views/coverage_mask.h"

#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

constexpr float kMaskShDc = 0.28209479f;  // Y_00

// Copies every `step`-th kernel for drawing.
void paint(const DrawnObject& object, size_t step, float value, GaussianAsset& asset, PosedKernels& kernels) {
  const size_t count = (object.asset->size() + step - 1) / step;
  asset.positions.resize(count);
  asset.opacity_logits.resize(count);
  asset.sh_dc.assign(count, Eigen::Vector3f::Constant((value - 0.5f) / kMaskShDc));
  asset.antialiased = object.asset->antialiased;
  for (size_t i = 0; i < count; ++i) asset.opacity_logits[i] = object.asset->opacity_logits[i * step];
  if (step == 1) return;
  kernels.resize(count);
  for (size_t i = 0; i < count; ++i) {
    kernels.positions_m[i] = object.kernels->positions_m[i * step];
    kernels.world_from_asset[i] = object.kernels->world_from_asset[i * step];
    kernels.covariances_m2[i] = object.kernels->covariances_m2[i * step];
    for (float& value_m2 : kernels.covariances_m2[i]) value_m2 *= static_cast<float>(step);
  }
}

}  // namespace

CoverageMaskScene::CoverageMaskScene(std::span<const DrawnObject> scene, uint32_t target_id,
                                     size_t target_kernels, size_t other_kernels) {
  size_t targets = 0, others = 0;
  for (const DrawnObject& object : scene) {
    (object.object_id == target_id ? targets : others) += object.asset->size();
  }
  const auto step_of = [](size_t count, size_t most) {
    return std::max<size_t>(1, (count + most / 2) / most);
  };
  const size_t target_step = targets > target_kernels ? step_of(targets, target_kernels) : 1;
  const size_t other_step = others > other_kernels ? step_of(others, other_kernels) : 1;
  for (const DrawnObject& object : scene) {
    if (object.asset->size() == 0) continue;
    const bool is_target = object.object_id == target_id;
    const size_t step = is_target ? target_step : other_step;
    Member member;
    member.own = object;
    GaussianAsset& asset = assets_.emplace_back();
    PosedKernels& kernels = kernels_.emplace_back();
    paint(object, step, is_target ? 1.0f : 0.0f, asset, kernels);
    member.painted = {&asset, step == 1 ? object.kernels : &kernels, object.object_id};
    // Centres extended by three standard deviations of the widest kernel.
    Eigen::AlignedBox3d bounds;
    float widest_m2 = 0;
    for (size_t i = 0; i < object.kernels->positions_m.size(); ++i) {
      if (!object.kernels->positions_m[i].allFinite()) continue;
      bounds.extend(object.kernels->positions_m[i].cast<double>());
      const Symmetric3f& s = object.kernels->covariances_m2[i];
      widest_m2 = std::max(widest_m2, s[0] + s[3] + s[5]);
    }
    if (bounds.isEmpty()) continue;
    member.centre_m = bounds.center();
    member.radius_m = 0.5 * bounds.sizes().norm() +
                      3.0 * std::sqrt(static_cast<double>(widest_m2) * static_cast<double>(step));
    if (is_target) target_.push_back(member.painted);
    members_.push_back(member);
  }
}

// True if the bounding sphere intersects the camera frustum.
bool CoverageMaskScene::sees(const Camera& camera, const Member& member) const {
  const Eigen::Vector3d place = camera.world_from_camera.inverse() * member.centre_m;
  if (-place.z() < -member.radius_m) return false;
  const auto outside = [&](double across, double edge_px, double focal_px) {
    const double slope = edge_px / focal_px;  // of the side plane
    return (across - slope * -place.z()) / std::hypot(1.0, slope) > member.radius_m;
  };
  return !outside(place.x(), camera.width - camera.centre_x_px, camera.focal_x_px) &&
         !outside(-place.x(), camera.centre_x_px, camera.focal_x_px) &&
         !outside(-place.y(), camera.height - camera.centre_y_px, camera.focal_y_px) &&
         !outside(place.y(), camera.centre_y_px, camera.focal_y_px);
}

std::vector<DrawnObject> CoverageMaskScene::seen_by(const Camera& camera) const {
  std::vector<DrawnObject> seen;
  for (const Member& member : members_) {
    if (sees(camera, member)) seen.push_back(member.painted);
  }
  return seen;
}

std::vector<DrawnObject> CoverageMaskScene::coloured_seen_by(const Camera& camera) const {
  std::vector<DrawnObject> seen;
  for (const Member& member : members_) {
    if (sees(camera, member)) seen.push_back(member.own);
  }
  return seen;
}

}  // namespace livegs
