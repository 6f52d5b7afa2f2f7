// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/skin/kernels/rest_bodies.h"
#include "skin/skin_kernels.h"

// Errors of kernels that a client skins from received drivers, compared with the server's own drivers:
// position and rotation. At 0.7 m, 0.05 mm is a tenth of a headset pixel.

namespace livegs::bench {

struct Percentiles {
  std::vector<double> counts = std::vector<double>(kBins, 0.0);
  double largest = 0;
  // Bins of 0.5 % each, for errors from 1e-6 on.
  static constexpr size_t kBins = 6000;
  static constexpr double kMinValue = 1e-6, kRatio = 1.005;

  void add(double error) {
    largest = std::max(largest, error);
    const double bin = error > kMinValue ? std::log(error / kMinValue) / std::log(kRatio) : 0.0;
    counts[std::min(kBins - 1, static_cast<size_t>(bin))] += 1;
  }
  double share_above(double error) const {
    double all = 0, above = 0;
    const auto from = static_cast<size_t>(std::log(error / kMinValue) / std::log(kRatio)) + 1;
    for (size_t i = 0; i < kBins; ++i) {
      all += counts[i];
      if (i >= from) above += counts[i];
    }
    return all > 0 ? above / all : 0;
  }
  double percentile(double share) const {
    double all = 0, below = 0;
    for (const double count : counts) all += count;
    if (all == 0) return 0;
    for (size_t i = 0; i < kBins; ++i) {
      if ((below += counts[i]) >= share * all)
        return kMinValue * std::pow(kRatio, static_cast<double>(i + 1));
    }
    return largest;
  }
};

struct KernelErrors {
  Percentiles position_mm, rotation_deg;
};

// Kernels of one body: `count` points inside it, with shapes of 1 to 20 mm.
class BoundKernels {
 public:
  BoundKernels(const RestBody& rest, size_t count, uint64_t seed)
      : rest_(rest), asset_(testing::kernels_at(rest, testing::points_inside(rest, count, seed), seed)) {
    auto bound = bind_kernels(asset_, rest_);
    if (bound) bindings_ = std::move(*bound);
  }

  const GaussianAsset& asset() const { return asset_; }
  PosedKernels pose(const ObjectDrivers& drivers) const {
    PosedKernels kernels;
    skin_kernels(asset_, rest_, bindings_, drivers, kernels);
    return kernels;
  }

 private:
  RestBody rest_;
  GaussianAsset asset_;
  KernelBindings bindings_;
};

// Angle from the difference of quaternions in double precision. The arc cosine of a float cannot resolve 0.02
// degrees.
inline double angle_deg(const Eigen::Quaternionf& a, const Eigen::Quaternionf& b) {
  const Eigen::Vector4d p = a.coeffs().cast<double>().normalized(),
                        q = b.coeffs().cast<double>().normalized();
  return 4.0 * 180.0 / M_PI * std::asin(std::min(1.0, 0.5 * std::min((p - q).norm(), (p + q).norm())));
}

inline void add_errors(const PosedKernels& is, const PosedKernels& shown, KernelErrors& errors) {
  for (size_t k = 0; k < is.positions_m.size(); ++k) {
    errors.position_mm.add(1e3 *
                           (is.positions_m[k].cast<double>() - shown.positions_m[k].cast<double>()).norm());
    errors.rotation_deg.add(angle_deg(is.world_from_asset[k], shown.world_from_asset[k]));
  }
}

}  // namespace livegs::bench
