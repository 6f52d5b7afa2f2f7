// SPDX-License-Identifier: Apache-2.0
#include "viewer/hands/hand_markers.h"

#include <cmath>
#include <limits>

namespace livegs {
namespace {

constexpr uint32_t kFirstId = std::numeric_limits<uint32_t>::max() - 1;
constexpr size_t kRayKernels = 24, kBeads = 10;
constexpr double kRayLength_m = 1.2;
constexpr float kRayWidth_m = 0.0012f, kBall_m = 0.008f, kBead_m = 0.004f;  // standard deviations
const Eigen::Vector3f kRayColour{0.85f, 0.9f, 1.0f}, kForceColour{1.0f, 0.59f, 0.12f};
constexpr float kShBand0 = 0.28209479f;

void add_kernel(GaussianAsset& asset, const Eigen::Vector3f& at, const Eigen::Vector3f& size, float opacity,
                const Eigen::Vector3f& colour) {
  asset.positions.push_back(at);
  asset.log_scales.push_back(size.array().log());
  asset.rotations.push_back(Eigen::Quaternionf::Identity());
  asset.opacity_logits.push_back(std::log(opacity / (1 - opacity)));
  asset.sh_dc.push_back((colour.array() - 0.5f) / kShBand0);
}

// Bodies of the asset: the ray, the ball, and one per bead.
GaussianAsset hand_asset() {
  GaussianAsset asset;
  constexpr double step_m = kRayLength_m / kRayKernels;
  for (size_t i = 0; i < kRayKernels; ++i) {
    const auto share = static_cast<float>(i) / kRayKernels;
    add_kernel(asset, {0, 0, static_cast<float>(-step_m * (static_cast<double>(i) + 0.5))},
               {kRayWidth_m, kRayWidth_m, static_cast<float>(0.6 * step_m)}, 0.7f * (1 - share) + 0.02f,
               kRayColour);
  }
  add_kernel(asset, {0, 0, 0}, Eigen::Vector3f::Constant(kBall_m), 0.95f, kRayColour);
  for (size_t i = 0; i < kBeads; ++i) {
    const float size = i + 1 == kBeads ? 2.5f * kBead_m : kBead_m;  // the tip
    add_kernel(asset, {0, 0, 0}, Eigen::Vector3f::Constant(size), 0.95f, kForceColour);
  }
  return asset;
}

}  // namespace

Result<void> HandMarkers::add_to(SceneView& view) {
  const auto asset = std::make_shared<const GaussianAsset>(hand_asset());
  RestBody rest;
  rest.bodies.resize(2 + kBeads);
  rest.kernel_runs = {{0, kRayKernels}, {1, 1}};
  for (uint32_t i = 0; i < kBeads; ++i) rest.kernel_runs.push_back({2 + i, 1});
  for (uint32_t hand = 0; hand < 2; ++hand) {
    auto bound = bind_object(kFirstId + hand, asset, rest, false);
    if (!bound) return bound.error();
    bound->shape = {};  // marks cast no shadows
    view.add(kFirstId + hand, *std::move(bound));
  }
  return {};
}

bool HandMarkers::is_marker(uint32_t object_id) { return object_id >= kFirstId; }

void HandMarkers::append(const std::array<HandSample, 2>& hands, std::span<const Force> forces,
                         DriverFrame& drivers) {
  for (uint32_t hand = 0; hand < 2; ++hand) {
    if (!hands[hand].active) continue;
    ObjectDrivers& marks = drivers.objects.emplace_back();
    marks.object_id = kFirstId + hand;
    // Without a force the beads are hidden inside the ball.
    marks.poses.assign(2 + kBeads, hands[hand].grip);
    marks.poses[0] = hands[hand].aim;
    for (const Force& force : forces) {
      if (force.hand != hand) continue;
      for (size_t i = 0; i < kBeads; ++i) {
        const double share = static_cast<double>(i + 1) / kBeads;
        marks.poses[2 + i] = {force.point_m + share * force.arrow_m, Eigen::Quaterniond::Identity()};
      }
    }
  }
}

}  // namespace livegs
