// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <iterator>

#include "analysis/estimate.h"
#include "gaussian/opacity.h"

namespace livegs {
namespace {

// Most kernels of a sample. Larger: captures of millions of kernels take longer to divide, up to 0.1 s per
// 100000; smaller: pictures of the parts get holes.
constexpr size_t kMaxSampledKernels = 100'000;
// A kernel counts at most this many times the median one: haze and floaters are large.
constexpr float kMaxWeightRatio = 20;

// Least opacity of a kernel that counts: fainter ones are haze and have the colours of what is behind them.
constexpr float kMinSampledOpacity = 0.35f;

// Visible area of a flat kernel: the product of its two larger axes.
double visible_area(const Eigen::Vector3f& log_scales) {
  Eigen::Array3d scale = log_scales.cast<double>().array().exp();
  std::sort(scale.data(), scale.data() + 3);
  return scale[1] * scale[2];
}

struct HueSaturation {
  float hue_rad, saturation;
};

HueSaturation hue_saturation(const Eigen::Vector3f& rgb) {
  const float high = rgb.maxCoeff(), low = rgb.minCoeff(), range = high - low;
  if (range <= 0.0f) return {0.0f, 0.0f};
  constexpr float kSixth = 1.04719755f;
  float hue = 0.0f;
  if (high == rgb.x())
    hue = (rgb.y() - rgb.z()) / range;
  else if (high == rgb.y())
    hue = 2.0f + (rgb.z() - rgb.x()) / range;
  else
    hue = 4.0f + (rgb.x() - rgb.y()) / range;
  return {hue * kSixth, range / std::max(high, 1e-6f)};
}

Eigen::Vector3f base_rgb(const Eigen::Vector3f& sh_dc) {
  return (sh_dc.array() * kShBand0 + 0.5f).cwiseMax(0.0f).cwiseMin(1.0f).matrix();
}

}  // namespace

AppearanceFacts appearance_facts(const GaussianAsset& asset) {
  AppearanceFacts facts;
  double weight_sum = 0, opacity_sum = 0, saturation_sum = 0, gloss_sum = 0, cosine = 0, sine = 0,
         hue_weight = 0;
  Eigen::Vector3d rgb_sum = Eigen::Vector3d::Zero();
  const size_t rest_count = asset.sh_rest_count();
  for (size_t i = 0; i < asset.size(); ++i) {
    const double opacity = 1.0 / (1.0 + std::exp(-static_cast<double>(asset.opacity_logits[i])));
    const double weight = opacity * visible_area(asset.log_scales[i]);
    if (!std::isfinite(weight) || weight <= 0) continue;
    const Eigen::Vector3f rgb = base_rgb(asset.sh_dc[i]);
    const HueSaturation colour = hue_saturation(rgb);
    double directional = 0;
    for (size_t k = 0; k < rest_count; ++k) directional += asset.sh_rest[i * rest_count + k].squaredNorm();
    const double constant = (rgb / kShBand0).squaredNorm();
    weight_sum += weight;
    opacity_sum += weight * opacity;
    rgb_sum += weight * rgb.cast<double>();
    saturation_sum += weight * colour.saturation;
    gloss_sum += weight * std::sqrt(directional / (directional + constant + 1e-9));
    cosine += weight * colour.saturation * std::cos(colour.hue_rad);
    sine += weight * colour.saturation * std::sin(colour.hue_rad);
    hue_weight += weight * colour.saturation;
  }
  if (weight_sum <= 0) return facts;
  facts.mean_rgb = (rgb_sum / weight_sum).cast<float>();
  facts.saturation = static_cast<float>(saturation_sum / weight_sum);
  facts.mean_opacity = static_cast<float>(opacity_sum / weight_sum);
  facts.gloss = static_cast<float>(gloss_sum / weight_sum);
  if (hue_weight > 0) {
    const double length = std::clamp(std::hypot(cosine, sine) / hue_weight, 1e-9, 1.0);
    facts.hue_spread = static_cast<float>(std::sqrt(-2.0 * std::log(length)));
  }
  return facts;
}

size_t surface_stride(size_t kernel_count) { return kernel_count / kMaxSampledKernels + 1; }

SurfaceKernels surface_kernels(const GaussianAsset& asset, const Similarity& object_from_asset) {
  SurfaceKernels kernels;
  kernels.stride = surface_stride(asset.size());
  const double area_scale = object_from_asset.scale * object_from_asset.scale;
  for (size_t i = 0; i < asset.size(); i += kernels.stride) {
    kernels.positions_m.push_back((object_from_asset * asset.positions[i].cast<double>()).cast<float>());
    kernels.rgb.push_back(base_rgb(asset.sh_dc[i]));
    const double area_m2 = area_scale * visible_area(asset.log_scales[i]);
    const float opacity = opacity_of_logit(asset.opacity_logits[i]);
    kernels.weights.push_back(opacity < kMinSampledOpacity ? 0.0f : opacity * static_cast<float>(area_m2));
  }
  std::vector<float> sorted;
  std::copy_if(kernels.weights.begin(), kernels.weights.end(), std::back_inserter(sorted),
               [](float weight) { return weight > 0; });
  if (sorted.empty()) return kernels;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  const float most = kMaxWeightRatio * sorted[sorted.size() / 2];
  for (float& weight : kernels.weights) weight = std::isfinite(weight) ? std::min(weight, most) : 0.0f;
  return kernels;
}

}  // namespace livegs
