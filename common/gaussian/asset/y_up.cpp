// SPDX-License-Identifier: Apache-2.0
#include "gaussian/asset/y_up.h"

#include <array>

namespace livegs {
namespace {

// Sign of each real spherical harmonic under (x, y, z) -> (x, -y, -z); each one is even or odd.
// l=1: y z x; l=2: xy yz zz xz xx-yy; l=3: y(3xx-yy) xyz y(..) z(..) x(..) z(xx-yy) x(xx-3yy).
constexpr std::array<float, 15> kSignOfBasis = {-1, -1, 1, -1, 1, 1, -1, 1, -1, 1, -1, -1, 1, -1, 1};

}  // namespace

void turn_half_about_x(GaussianAsset& asset) {
  const size_t rest = asset.sh_rest_count();
  for (size_t i = 0; i < asset.size(); ++i) {
    asset.positions[i].tail<2>() *= -1;
    asset.rotations[i].y() *= -1;
    asset.rotations[i].z() *= -1;
    for (size_t k = 0; k < rest; ++k) asset.sh_rest[i * rest + k] *= kSignOfBasis[k];
  }
}

}  // namespace livegs
