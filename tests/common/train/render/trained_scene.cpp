// SPDX-License-Identifier: Apache-2.0
#include "common/train/render/trained_scene.h"

#include <cmath>

#include "train/optimise/random_number.h"

namespace livegs {

double between(double low, double high, uint64_t stream, uint64_t index) {
  return low + (high - low) * random_share(7, stream, index);
}

Camera test_camera(int width, int height) {
  Camera camera = look_at({0.3, 0.4, 2.0}, {0.05, -0.1, 0}, {0.1, 1, 0}, 0.8, width, height);
  camera.centre_x_px += 3.5;  // not in the middle
  camera.focal_y_px *= 1.1;
  camera.near_m = 0.05;
  return camera;
}

KernelParameters test_kernels(size_t count, double max_opacity) {
  KernelParameters kernels;
  kernels.resize(count);
  for (size_t k = 0; k < count; ++k) {
    for (int i = 0; i < 3; ++i) {
      const auto at = 4 * k + static_cast<size_t>(i);
      kernels.row(Family::Position, k)[i] = static_cast<float>(between(-0.7, 0.7, 1, at));
      kernels.row(Family::LogScale, k)[i] = static_cast<float>(between(-3.5, -1.2, 2, at));
      kernels.row(Family::Colour, k)[i] = static_cast<float>(between(-1.5, 1.5, 3, at));
    }
    for (int i = 0; i < 4; ++i)
      kernels.row(Family::Rotation, k)[i] =
          static_cast<float>(between(-1.3, 1.3, 4, 4 * k + static_cast<size_t>(i)));
    const double opacity = between(0.1, max_opacity, 5, k);
    *kernels.row(Family::Opacity, k) = static_cast<float>(std::log(opacity / (1 - opacity)));
    for (int i = 0; i < 45; ++i)
      kernels.row(Family::Harmonics, k)[i] =
          static_cast<float>(between(-0.3, 0.3, 6, 45 * k + static_cast<size_t>(i)));
  }
  return kernels;
}

PicturePlanes random_weights(int width, int height) {
  PicturePlanes weights;
  weights.resize(width, height);
  for (size_t i = 0; i < weights.pixels(); ++i) {
    weights.red[i] = static_cast<float>(between(-1, 1, 10, i));
    weights.green[i] = static_cast<float>(between(-1, 1, 11, i));
    weights.blue[i] = static_cast<float>(between(-1, 1, 12, i));
    weights.alpha[i] = static_cast<float>(between(-1, 1, 13, i));
  }
  return weights;
}

TrainedViewOptions smooth_options() {
  TrainedViewOptions options;
  options.background = {0.2f, 0.5f, 0.8f};
  options.cuts = {1e-9f, 0.0f};
  return options;
}

}  // namespace livegs
