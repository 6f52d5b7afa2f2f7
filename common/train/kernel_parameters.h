// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// Families of the trained numbers of a kernel. Each has its own learning rate.
enum class Family { Position, LogScale, Rotation, Opacity, Colour, Harmonics };
inline constexpr size_t kFamilies = 6;
// Numbers of each family for one kernel. Rotation is a quaternion w, x, y, z of any length; Opacity is a
// logit; Harmonics are the bands 1 to 3, coefficient by coefficient, red, green, blue.
inline constexpr std::array<size_t, kFamilies> kFamilyWidth{3, 3, 4, 1, 3, 45};

// The trained numbers of all kernels, or one number for each of them: a gradient, a moment.
struct KernelParameters {
  std::array<std::vector<float>, kFamilies> families;

  std::vector<float>& of(Family family) { return families[static_cast<size_t>(family)]; }
  const std::vector<float>& of(Family family) const { return families[static_cast<size_t>(family)]; }
  float* row(Family family, size_t kernel) {
    return of(family).data() + kernel * kFamilyWidth[static_cast<size_t>(family)];
  }
  const float* row(Family family, size_t kernel) const {
    return of(family).data() + kernel * kFamilyWidth[static_cast<size_t>(family)];
  }
  size_t size() const { return of(Family::Opacity).size(); }
  void resize(size_t count) {
    for (size_t f = 0; f < kFamilies; ++f) families[f].resize(count * kFamilyWidth[f], 0.0f);
  }
  void clear_to_zero() {
    for (auto& numbers : families) std::fill(numbers.begin(), numbers.end(), 0.0f);
  }
};

// The kernels as an asset in the frame of the capture, rotations normalised. Bands above `sh_degree` are left
// out; 0 <= sh_degree <= 3.
GaussianAsset asset_of(const KernelParameters& parameters, int sh_degree);

}  // namespace livegs
