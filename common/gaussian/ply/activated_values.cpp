// SPDX-License-Identifier: Apache-2.0
#include "gaussian/ply/activated_values.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "gaussian/opacity.h"

namespace livegs {
namespace {

// Fewest kernels of which anything can be concluded.
constexpr size_t kMinKernels = 32;
// Median kernel, one standard deviation, relative to the side of the box of the middle half of the positions.
// Wider: the object is a blur, so these are not logarithms. Narrower: kernels form a shape.
constexpr double kBlur = 0.5;
constexpr double kShape = 0.25;

struct Evidence {
  bool scales_fit = true;     // all finite scales are at least 0
  bool opacities_fit = true;  // all opacities are within 0..1
  bool blurred_as_logs = false, shaped_as_deviations = false;
};

double quantile(std::vector<float>& values, double share) {
  const auto at = values.begin() + static_cast<ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Evidence evidence_of(const GaussianAsset& asset) {
  Evidence evidence;
  std::vector<float> widest;
  std::vector<float> along[3];
  for (size_t i = 0; i < asset.size(); ++i) {
    const Eigen::Vector3f& scale = asset.log_scales[i];
    if (!scale.allFinite() || !asset.positions[i].allFinite()) continue;
    evidence.scales_fit &= scale.minCoeff() >= 0;
    evidence.opacities_fit &= asset.opacity_logits[i] >= 0 && asset.opacity_logits[i] <= 1;
    widest.push_back(scale.maxCoeff());
    for (int axis = 0; axis < 3; ++axis) along[axis].push_back(asset.positions[i][axis]);
  }
  if (widest.size() < kMinKernels) return {false, false, false, false};
  double side = 0;
  for (std::vector<float>& values : along)
    side = std::max(side, quantile(values, 0.75) - quantile(values, 0.25));
  const double scale = quantile(widest, 0.5);
  evidence.blurred_as_logs = std::exp(scale) >= kBlur * side;
  evidence.shaped_as_deviations = scale < kShape * side;
  return evidence;
}

}  // namespace

Result<void> convert_activated(AssetFile& file, const ReadOptions& options, std::string_view name) {
  using Activated = ReadOptions::Activated;
  if (options.activated == Activated::No) return {};
  GaussianAsset& asset = file.asset;
  Evidence evidence = evidence_of(asset);
  if (options.activated == Activated::Yes) {
    // The caller has chosen activated values, so a few kernels suffice.
    evidence.scales_fit = evidence.opacities_fit = true;
    for (size_t i = 0; i < asset.size(); ++i) {
      evidence.scales_fit &= !(asset.log_scales[i].minCoeff() < 0);
      evidence.opacities_fit &= !(asset.opacity_logits[i] < 0) && !(asset.opacity_logits[i] > 1);
    }
    if (!evidence.scales_fit && !evidence.opacities_fit) {
      return invalid_argument(std::string(name) +
                              ": has scales below 0 and opacities outside 0 to 1, so they are not activated; "
                              "read it without --activated");
    }
  } else {
    const bool certain = evidence.scales_fit && evidence.blurred_as_logs && evidence.shaped_as_deviations;
    if (!certain) {
      if (evidence.scales_fit && evidence.opacities_fit) {
        file.notes.push_back(
            "scales are all above 0 and opacities within 0 to 1: they may be activated values, not "
            "logarithms "
            "and logits; if so, read it with --activated");
      }
      return {};
    }
    file.notes.push_back(std::string("scales are read as standard deviations") +
                         (evidence.opacities_fit ? " and opacities as 0 to 1" : "") +
                         " (activated values): as logarithms they would blur the whole object");
  }
  for (size_t i = 0; i < asset.size(); ++i) {
    // A deviation of 0 becomes -inf here, a value that establish_invariants repairs.
    if (evidence.scales_fit) asset.log_scales[i] = asset.log_scales[i].array().log();
    if (evidence.opacities_fit) {
      const float opacity = asset.opacity_logits[i];
      asset.opacity_logits[i] = std::log(opacity / (1 - opacity));  // infinite for 0 and 1: repaired as well
    }
  }
  return {};
}

}  // namespace livegs
