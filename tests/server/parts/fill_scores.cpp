// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/parts/fill_scores.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "core/percentile.h"
#include "parts/views/room_view.h"
#include "server/parts/part_scores.h"
#include "splat/kernel_view.h"

namespace livegs {
namespace {

constexpr int kRim_px = 5;

using Place = std::tuple<float, float, float>;
Place place_of(const Eigen::Vector3f& at) { return {at.x(), at.y(), at.z()}; }

// 1: kernels of the twin that the room with the thing does not have.
std::vector<uint16_t> uncovered(const GaussianAsset& before, const GaussianAsset& twin) {
  std::set<Place> known;
  for (const Eigen::Vector3f& at : before.positions) known.insert(place_of(at));
  std::vector<uint16_t> label(twin.size());
  for (size_t k = 0; k < twin.size(); ++k) label[k] = !known.contains(place_of(twin.positions[k]));
  return label;
}

KernelView draw_kernels(const GaussianAsset& asset, const Camera& camera) {
  const PosedKernels posed = pose_in_place(asset);
  KernelRasteriser rasteriser;
  KernelView view;
  rasteriser.draw({&asset, &posed, 0}, camera, view);
  return view;
}

double db_of(double sum, size_t count) {
  return count == 0 ? 0.0 : -10 * std::log10(std::max(sum / (3 * static_cast<double>(count)), 1e-10));
}

}  // namespace

FillScores score_fill(const GaussianAsset& before, const GaussianAsset& twin, const GaussianAsset& after,
                      std::span<const Camera> cameras) {
  FillScores scores;
  const std::vector<uint16_t> hidden = uncovered(before, twin);
  double sum = 0, rim_sum = 0;
  size_t rim_pixels = 0, open = 0;
  std::vector<double> depths_mm;
  for (const Camera& camera : cameras) {
    const std::vector<uint16_t> hole = label_picture(twin, hidden, camera);
    const KernelView truth = draw_kernels(twin, camera), got = draw_kernels(after, camera);
    for (int y = 0; y < truth.height; ++y)
      for (int x = 0; x < truth.width; ++x) {
        const size_t i = static_cast<size_t>(y) * static_cast<size_t>(truth.width) + static_cast<size_t>(x);
        bool rim = false;
        for (int dy = -kRim_px; dy <= kRim_px && !hole[i] && !rim; ++dy)
          for (int dx = -kRim_px; dx <= kRim_px && !rim; ++dx)
            rim = dx * dx + dy * dy <= kRim_px * kRim_px && x + dx >= 0 && y + dy >= 0 &&
                  x + dx < truth.width && y + dy < truth.height &&
                  hole[static_cast<size_t>(y + dy) * static_cast<size_t>(truth.width) +
                       static_cast<size_t>(x + dx)];
        if (!hole[i] && !rim) continue;
        double error = 0;
        for (int c = 0; c < 3; ++c) error += std::pow(truth.image.at(x, y)[c] - got.image.at(x, y)[c], 2);
        (hole[i] ? sum : rim_sum) += error;
        if (!hole[i]) {
          ++rim_pixels;
          continue;
        }
        ++scores.hole_pixels;
        if (!std::isfinite(truth.depth_m[i])) continue;
        if (std::isfinite(got.depth_m[i]))
          depths_mm.push_back(1e3 * std::abs(truth.depth_m[i] - got.depth_m[i]));
        else
          ++open;
      }
  }
  scores.psnr_db = db_of(sum, scores.hole_pixels);
  scores.rim_psnr_db = db_of(rim_sum, rim_pixels);
  if (!depths_mm.empty()) scores.depth_p95_mm = percentile(std::move(depths_mm), 0.95);
  if (scores.hole_pixels > 0)
    scores.open_share = static_cast<double>(open) / static_cast<double>(scores.hole_pixels);
  return scores;
}

Image fill_picture(const GaussianAsset& before, const GaussianAsset& twin, const GaussianAsset& after,
                   const Camera& camera) {
  const std::vector<uint16_t> hole = label_picture(twin, uncovered(before, twin), camera);
  const Image pictures[] = {draw_kernels(before, camera).image, draw_kernels(twin, camera).image,
                            draw_kernels(after, camera).image};
  int x0 = camera.width, x1 = 0, y0 = camera.height, y1 = 0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      if (hole[static_cast<size_t>(y) * static_cast<size_t>(camera.width) + static_cast<size_t>(x)])
        x0 = std::min(x0, x), x1 = std::max(x1, x), y0 = std::min(y0, y), y1 = std::max(y1, y);
  constexpr int kAround_px = 30;
  if (x0 > x1) return {};
  x0 = std::max(0, x0 - kAround_px), y0 = std::max(0, y0 - kAround_px);
  x1 = std::min(camera.width - 1, x1 + kAround_px), y1 = std::min(camera.height - 1, y1 + kAround_px);
  Image all;
  all.width = 3 * (x1 - x0 + 2), all.height = y1 - y0 + 1;
  all.pixels.assign(4 * static_cast<size_t>(all.width) * static_cast<size_t>(all.height), 1.0f);
  for (int p = 0; p < 3; ++p)
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x)
        std::copy_n(pictures[p].at(x, y), 4, all.at(p * (x1 - x0 + 2) + x - x0, y - y0));
  return all;
}

}  // namespace livegs
