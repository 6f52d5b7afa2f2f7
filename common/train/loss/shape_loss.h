// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "train/kernel_parameters.h"

namespace livegs {

// Losses on the shape of kernels, added to the loss of the picture.
enum class ShapeLoss {
  None,
  Needle,      // mean(max(longest / middle axis, r) - r): forbids needles, allows discs
  Anisotropy,  // mean(max(longest / shortest axis, r) - r), the paper's L_A (Xie et al. 2024, equation 14)
};

struct ShapeOptions {
  ShapeLoss loss = ShapeLoss::Needle;
  float weight = 1;
  float limit = 3;  // r
  // Weight of the mean opacity (Kheradmand et al. 2024, equation 10, with 0.01). It removes superfluous
  // kernels. With 0.01, surfaces become half-transparent and their depth is wrong by centimetres.
  float opacity_weight = 0.002f;
  float scale_weight = 0.01f;  // of the mean axis, as a share of the extent of the scene
};

// Adds the derivatives to `gradient` and returns the loss.
double add_shape_loss(const KernelParameters& parameters, const ShapeOptions& options, double extent,
                      KernelParameters& gradient);

}  // namespace livegs
