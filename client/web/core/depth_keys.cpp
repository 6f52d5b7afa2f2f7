// SPDX-License-Identifier: Apache-2.0
// Plain arrays and no branches in the loops, for SIMD; compiled for speed, unlike the rest of this folder.
#include "web/core/depth_keys.h"

#include "splat/passes/key_order.h"
#include "splat/project/raster_options.h"

namespace livegs {
namespace {

template <bool by_distance>
void fill(OrderView view, const KernelPositions& positions,
          const std::array<std::vector<float>, 6>* covariances_m2, std::span<uint32_t> keys) {
  view.by_distance = by_distance;
  const float *x = positions.x_m.data(), *y = positions.y_m.data(), *z = positions.z_m.data();
  if (!covariances_m2) {
    const Row3 o = view.origin_m;
    for (size_t k = 0; k < keys.size(); ++k)
      keys[k] = ordered_key(order_depth(view, Row3{x[k] - o.x, y[k] - o.y, z[k] - o.z}));
    return;
  }
  const float* s[6];
  for (size_t i = 0; i < 6; ++i) s[i] = (*covariances_m2)[i].data();
  for (size_t k = 0; k < keys.size(); ++k) {
    const PosedKernelRow row{x[k],    y[k],    z[k], s[0][k], s[1][k], s[2][k], s[3][k],
                             s[4][k], s[5][k], 0,    0,       0,       1};
    keys[k] = ordered_key(order_depth(view, row, kEnvironmentOrderBias));
  }
}

}  // namespace

void fill_depth_keys(const OrderView& view, const KernelPositions& positions,
                     const std::array<std::vector<float>, 6>* covariances_m2, std::span<uint32_t> keys) {
  if (view.by_distance)
    fill<true>(view, positions, covariances_m2, keys);
  else
    fill<false>(view, positions, covariances_m2, keys);
}

}  // namespace livegs
