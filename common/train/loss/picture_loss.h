// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "train/render/trained_view.h"

namespace livegs {

// Mean structural similarity of two planes (Wang et al. 2004): window of 11 x 11 pixels, Gaussian with a
// standard deviation of 1.5 pixels around the pixel, zeros beyond the border, values in 0..1.
inline constexpr int kSsimWindow = 11;
inline constexpr double kSsimDeviation_px = 1.5;
inline constexpr float kSsimC1 = 1e-4f, kSsimC2 = 9e-4f;

// Weight of 1 - SSIM; that of the mean absolute difference is the rest (Kerbl et al. 2023, equation 7).
inline constexpr float kSsimWeight = 0.2f;

// Loss of a picture and its derivative. Buffers are kept between calls. Not shared between threads. The same
// bits for any number of threads.
class PictureLoss {
 public:
  // (1 - w) L1 + w (1 - SSIM), means over pixels and colours, plus `alpha_weight` times the mean absolute
  // difference of alpha. `counts`: pixels with 0 are ignored; empty: none. Both pictures have one size.
  double evaluate(const PicturePlanes& picture, const PicturePlanes& target, std::span<const uint8_t> counts,
                  float alpha_weight, PicturePlanes& by_picture);

  // Mean over the colours, without a derivative. Colours over 1 count as 1.
  double ssim(const PicturePlanes& picture, const PicturePlanes& target);

 private:
  double plane_ssim(const float* x, const float* y, int width, int height, bool with_gradient, float* by_x,
                    float scale);

  std::vector<float> rows_[5];  // blurred along the rows
  std::vector<float> maps_[3];  // derivatives by mean, mean square and mean product
  std::vector<float> clamped_;
  std::vector<double> partial_;
};

// Peak signal-to-noise ratio over the colours, dB, of colours held in 0..1. Ignored pixels are left out.
// Infinity for equal pictures.
double psnr_db(const PicturePlanes& picture, const PicturePlanes& target, std::span<const uint8_t> counts);

}  // namespace livegs
