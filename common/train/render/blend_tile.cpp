// SPDX-License-Identifier: Apache-2.0
// Kerbl et al. 2023, algorithm 2. The backward pass also runs front to back. With C the final colour and g =
// dL/dC, the part of g . C behind kernel i is the remainder after subtracting the parts in front. Neither
// lists per pixel nor divisions that recover transmittance are needed:
//   dL/dalpha_i = T_i (g . c_i) - left_i / (1 - alpha_i)
#include "train/render/blend_tile.h"

#include <algorithm>
#include <bit>

#include "splat/raster/lanes.h"
#include "splat/raster/touched_runs.h"

namespace livegs {
namespace {

constexpr float kHalf = 0.5f;

// a b + c with one rounding where the processor has it.
inline Lanes fused(Lanes a, Lanes b, Lanes c) {
#ifdef __FMA__
  return _mm256_fmadd_ps(a, b, c);
#else
  return a * b + c;
#endif
}

// 2^x as exp2 of lanes.h, with fused steps.
inline Lanes fused_exp2(Lanes x) {
  constexpr float kRound = 12582912.0f;  // 1.5 * 2^23: adding it rounds to an integer
  const Lanes shifted = x + kRound;
  const Lanes f = x - (shifted - kRound);
  Lanes y = fused(lanes(1.33908633e-3f), f, lanes(9.67603177e-3f));
  y = fused(y, f, lanes(5.55035695e-2f));
  y = fused(y, f, lanes(0.240221068f));
  y = fused(y, f, lanes(0.693147182f));
  y = fused(y, f, lanes(1.00000012f));
  return reinterpret_cast<Lanes>(reinterpret_cast<LaneMask>(y) + (reinterpret_cast<LaneMask>(shifted) << 23));
}

// Lane sums are added in a fixed order.
inline float sum_of(Lanes v) {
#ifdef __AVX__
  const __m128 four = _mm_add_ps(_mm256_castps256_ps128(v), _mm256_extractf128_ps(v, 1));
  const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps(two, two, 1)));
#else
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
#endif
}

// Values of one kernel along the rows of a tile. Both passes evaluate them with the same operations, so that
// they skip and stop at the same pixels.
struct KernelRows {
  KernelRows(const ProjectedKernel& k, const TileKernel& placed_kernel, const RenderCuts& cuts)
      : kernel(k),
        placed(placed_kernel),
        along(k.across_x * lane_indices()),
        first_u(k.across_x * placed_kernel.dx),
        right_u(k.across_x * 8.0f),
        min_alpha(cuts.min_alpha),
        min_transmittance(cuts.min_transmittance) {}

  struct Step {
    Lanes alpha, weight, after, left;
    LaneMask adds, clamped;
  };
  Step step(int run, Lanes before) const {
    const float dy = placed.dy + static_cast<float>(run & 15);
    const float v = kernel.down_y * dy;
    const Lanes u = along + (first_u + kernel.across_y * dy + (run < 16 ? 0.0f : right_u));
    const Lanes exponent = (kernel.log2_opacity - v * v) - u * u;
    const Lanes free = fused_exp2(max(exponent, lanes(-64.0f)));
    Step s;
    s.alpha = min(free, lanes(kMaxAlpha));
    const LaneMask seen = (s.alpha >= min_alpha) & (before > 0.0f);
    s.weight = s.alpha * before;
    s.after = before - s.weight;
    const LaneMask stops = seen & (s.after < min_transmittance);
    s.adds = seen & ~stops;
    s.clamped = free > kMaxAlpha;
    s.left = s.adds ? s.after : (stops ? -before : before);
    return s;
  }

  const ProjectedKernel& kernel;
  const TileKernel& placed;
  Lanes along;
  float first_u, right_u, min_alpha, min_transmittance;
};

inline float rim_of(const ProjectedKernel& kernel, const RenderCuts& cuts) {
  return kernel.log2_opacity - __builtin_log2f(cuts.min_alpha);
}

inline int first_pixel(int run) { return (run & 15) * kTileSize + (run < 16 ? 0 : 8); }

}  // namespace

uint32_t runs_of_tile(int columns, int rows) {
  uint32_t runs = 0;
  for (int row = 0; row < std::min(rows, kTileSize); ++row) {
    runs |= uint32_t{1} << row;
    if (columns > 8) runs |= uint32_t{1} << (16 + row);
  }
  return runs;
}

uint32_t blend_forward(const ProjectedKernel& kernel, const TileFrame& frame, const RenderCuts& cuts,
                       uint32_t live, TilePixels& tile, bool with_spread, uint32_t* halfway, uint32_t rank) {
  const TileKernel placed(kernel, frame.x, frame.y);
  const KernelRows rows(kernel, placed, cuts);
  uint32_t finished = 0;
  for (uint32_t runs = touched_runs(kernel, placed, rim_of(kernel, cuts)) & live; runs != 0;
       runs &= runs - 1) {
    const int run = std::countr_zero(runs);
    const int pixel = first_pixel(run);
    Lanes& transmittance = lanes_at(tile.transmittance + pixel);
    const Lanes before = transmittance;
    const KernelRows::Step s = rows.step(run, before);
    const Lanes added = s.adds ? s.weight : lanes(0.0f);
    lanes_at(tile.red + pixel) = fused(added, lanes(kernel.red), lanes_at(tile.red + pixel));
    lanes_at(tile.green + pixel) = fused(added, lanes(kernel.green), lanes_at(tile.green + pixel));
    lanes_at(tile.blue + pixel) = fused(added, lanes(kernel.blue), lanes_at(tile.blue + pixel));
    if (with_spread) {
      // Kernels come in the order of their depths, so |z_i - z_k| needs no absolute value.
      Lanes& depth = lanes_at(tile.depth + pixel);
      const Lanes front = lanes(1.0f) - before;
      const Lanes distances = fused(lanes(kernel.depth_m), front, -depth);
      lanes_at(tile.spread + pixel) = fused(added + added, distances, lanes_at(tile.spread + pixel));
      depth = fused(added, lanes(kernel.depth_m), depth);
    }
    if (halfway != nullptr) {
      const uint32_t bits = mask_bits(s.adds & (before >= kHalf) & (s.after < kHalf));
      for (uint32_t left = bits; left != 0; left &= left - 1) halfway[pixel + std::countr_zero(left)] = rank;
    }
    transmittance = s.left;
    finished |= static_cast<uint32_t>(mask_bits(s.left > 0.0f) == 0) << run;
  }
  return finished;
}

uint32_t blend_backward(const ProjectedKernel& kernel, const TileFrame& frame, const RenderCuts& cuts,
                        uint32_t live, TilePixels& tile, TileGradient& gradient, bool with_spread,
                        EllipseGradient& sums) {
  const TileKernel placed(kernel, frame.x, frame.y);
  const KernelRows rows(kernel, placed, cuts);
  const uint32_t touched = touched_runs(kernel, placed, rim_of(kernel, cuts)) & live;
  const Lanes zero = lanes(0.0f), one = lanes(1.0f);
  // Sums of G, G dx and so on; `moment` is of the powers of dy for each column, because dx is fixed there.
  Lanes sum = zero, x = zero, y = zero, xx = zero, xy = zero, yy = zero;
  Lanes red = zero, green = zero, blue = zero, by_depth = zero;
  const Lanes z = lanes(kernel.depth_m);
  uint32_t finished = 0;
  for (int half = 0; half < 2; ++half) {
    Lanes moment0 = zero, moment1 = zero, moment2 = zero;
    uint32_t runs = touched & (half == 0 ? 0xffffu : 0xffff0000u);
    if (runs == 0) continue;
    for (; runs != 0; runs &= runs - 1) {
      const int run = std::countr_zero(runs);
      const int pixel = first_pixel(run);
      Lanes& transmittance = lanes_at(tile.transmittance + pixel);
      const Lanes before = transmittance;
      const KernelRows::Step s = rows.step(run, before);
      transmittance = s.left;
      finished |= static_cast<uint32_t>(mask_bits(s.left > 0.0f) == 0) << run;
      const Lanes weight = s.adds ? s.weight : zero;
      const Lanes by_red = lanes_at(gradient.red + pixel);
      const Lanes by_green = lanes_at(gradient.green + pixel);
      const Lanes by_blue = lanes_at(gradient.blue + pixel);
      red = fused(weight, by_red, red);
      green = fused(weight, by_green, green);
      blue = fused(weight, by_blue, blue);
      Lanes by_colour = fused(by_red, lanes(kernel.red),
                              fused(by_green, lanes(kernel.green),
                                    fused(by_blue, lanes(kernel.blue), lanes_at(gradient.alpha + pixel))));
      if (with_spread) {
        // With A and D the sums of w and w z in front of this kernel and of all:
        //   dL/dw = 2 (z (2 A_front - A) - (2 D_front - D)),   dL/dz = 2 w (2 A_front + w - A)
        Lanes& depth = lanes_at(tile.depth + pixel);
        const Lanes front = one - before;
        const Lanes balance = front + front - lanes_at(gradient.final_alpha + pixel);
        const Lanes depth_balance = depth + depth - lanes_at(gradient.final_depth + pixel);
        const Lanes twice = lanes_at(gradient.spread + pixel) + lanes_at(gradient.spread + pixel);
        by_colour = fused(twice, fused(z, balance, -depth_balance), by_colour);
        by_depth = fused(twice * weight, balance + weight, by_depth);
        depth = fused(weight, z, depth);
      }
      Lanes& left = lanes_at(gradient.left + pixel);
      const Lanes behind = fused(-weight, by_colour, left);
      left = behind;
      // G = alpha dL/dalpha.
      const Lanes slope = s.weight * by_colour - s.alpha * behind / (one - s.alpha);
      const Lanes g = (s.adds & ~s.clamped) ? slope : zero;
      const Lanes dy = lanes(placed.dy + static_cast<float>(run & 15));
      const Lanes g_dy = g * dy;
      moment0 += g;
      moment1 += g_dy;
      moment2 = fused(g_dy, dy, moment2);
    }
    const Lanes dx = lane_indices() + (placed.dx + (half == 0 ? 0.0f : 8.0f));
    const Lanes m0_dx = moment0 * dx;
    sum += moment0;
    x += m0_dx;
    xx = fused(m0_dx, dx, xx);
    y += moment1;
    xy = fused(moment1, dx, xy);
    yy += moment2;
  }
  sums = {sum_of(sum), sum_of(x),   sum_of(y),     sum_of(xx),   sum_of(xy),
          sum_of(yy),  sum_of(red), sum_of(green), sum_of(blue), sum_of(by_depth)};
  return finished;
}

}  // namespace livegs
