// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "train/kernel_parameters.h"

namespace livegs {

// Losses on the shape of kernels, added to the loss of the picture.
enum class ShapeLoss {
  None,
  Needle,      // mean(max(longest / middle axis, r) - r): penalises needles, not discs
  Anisotropy,  // mean(max(longest / shortest axis, r) - r), the paper's L_A (Xie et al. 2024, equation 14)
};

struct ShapeOptions {
  ShapeLoss loss = ShapeLoss::Needle;
  float weight = 1;
  float limit = 3;  // r: largest ratio of axes without a loss. Larger: longer kernels remain
  // Weight of the mean opacity (Kheradmand et al. 2024, equation 10). This term removes superfluous kernels.
  // Larger, such as the 0.01 of that paper: surfaces become half-transparent, and their depth is wrong.
  float opacity_weight = 0.002f;
  float scale_weight = 0.01f;  // weight of the mean axis divided by the extent of the scene
};

// Adds the derivatives to `gradient` and returns the loss. `extent`: of the scene, in its unit.
double add_shape_loss(const KernelParameters& parameters, const ShapeOptions& options, double extent,
                      KernelParameters& gradient);

}  // namespace livegs
