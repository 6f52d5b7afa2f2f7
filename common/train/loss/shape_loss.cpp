// SPDX-License-Identifier: Apache-2.0
#include "train/loss/shape_loss.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel_for.h"

namespace livegs {
namespace {

constexpr size_t kShapeBlock = 2048;  // kernels

}  // namespace

double add_shape_loss(const KernelParameters& parameters, const ShapeOptions& options, double extent,
                      KernelParameters& gradient) {
  const size_t count = parameters.size();
  if (count == 0) return 0;
  const float share = 1.0f / static_cast<float>(count);
  const float by_opacity = options.opacity_weight * share;
  const float by_scale = options.scale_weight * share / (3 * static_cast<float>(extent));
  std::vector<double> partial((count + kShapeBlock - 1) / kShapeBlock, 0.0);
  parallel_for(count, kShapeBlock, [&](size_t begin, size_t end) {
    double sum = 0;
    for (size_t k = begin; k < end; ++k) {
      const float logit = *parameters.row(Family::Opacity, k);
      const float opacity = 1.0f / (1.0f + std::exp(-logit));
      *gradient.row(Family::Opacity, k) += by_opacity * opacity * (1 - opacity);
      sum += double{by_opacity} * opacity;
      const float* log_scale = parameters.row(Family::LogScale, k);
      float* by = gradient.row(Family::LogScale, k);
      for (int i = 0; i < 3; ++i) {
        const float scale = std::exp(log_scale[i]);
        by[i] += by_scale * scale;
        sum += double{by_scale} * scale;
      }
      if (options.loss == ShapeLoss::None) continue;
      std::array<int, 3> axes{0, 1, 2};
      std::sort(axes.begin(), axes.end(), [&](int a, int b) {
        return log_scale[a] > log_scale[b] || (log_scale[a] == log_scale[b] && a < b);
      });
      const int longest = axes[0], other = options.loss == ShapeLoss::Needle ? axes[1] : axes[2];
      // Ratios over e^20 have no use; the limit keeps the derivative finite.
      const float ratio = std::exp(std::min(20.0f, log_scale[longest] - log_scale[other]));
      if (ratio <= options.limit) continue;
      const float slope = options.weight * share * ratio;
      by[longest] += slope;
      by[other] -= slope;
      sum += double{options.weight * share} * (ratio - options.limit);
    }
    partial[begin / kShapeBlock] = sum;
  });
  double sum = 0;
  for (double part : partial) sum += part;
  return sum;
}

}  // namespace livegs
