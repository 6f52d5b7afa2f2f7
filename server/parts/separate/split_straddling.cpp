// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/separate/split_straddling.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/parallel_for.h"
#include "gaussian/opacity.h"
#include "geometry/fracture/split_gaussian.h"
#include "parts/graph/kernel_tree.h"
#include "parts/label/choose_kernels.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr float kMixedShare = 0.8f;  // below it a kernel shows in pixels of several labels
constexpr size_t kNeighbours = 24;   // that decide the plane between two labels
constexpr size_t kMinOtherNeighbours = 4;
constexpr double kMinWidth_footprints = 0.5;  // deviation across the border; narrower kernels stay whole
constexpr double kOverhang_footprints = 1.0;  // allowed across a border, at three deviations
constexpr double kMinKeptOpacity = 1.0 / 255.0;
constexpr double kMaxKeptOpacity = 0.998;
constexpr double kFlattest = 1e-3;  // smallest to largest deviation of a part

struct BorderPlane {
  bool found = false;
  Vector3d point_m, normal;  // towards the other label
  uint16_t other = kRoomLabel;
};

Matrix3d covariance_of(const GaussianAsset& asset, size_t k) {
  const Matrix3d axes = asset.rotations[k].cast<double>().toRotationMatrix() *
                        asset.log_scales[k].cast<double>().array().exp().matrix().asDiagonal();
  return axes * axes.transpose();
}

// The plane as the face between two cells, for split_gaussian().
VoronoiPieces two_sides(const BorderPlane& border, double reach_m) {
  VoronoiPieces sides;
  sides.seeds_m = {border.point_m - reach_m * border.normal, border.point_m + reach_m * border.normal};
  sides.cell_parts.resize(2);
  sides.cell_parts[0].resize(1);
  sides.cell_parts[1].resize(1);
  sides.cell_parts[1][0].piece = 1;
  sides.cell_neighbours = {{1}, {0}};
  return sides;
}

void set_kernel(GaussianAsset& asset, size_t k, const GaussianPart& part, double opacity) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(part.covariance_m2);
  Matrix3d axes = eigen.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
  const double most_m2 = std::max(eigen.eigenvalues()[2], 1e-36);
  asset.positions[k] = part.mean_m.cast<float>();
  asset.rotations[k] = Eigen::Quaterniond(axes).normalized().cast<float>();
  asset.log_scales[k] =
      (0.5 * eigen.eigenvalues().array().max(kFlattest * kFlattest * most_m2).log()).matrix().cast<float>();
  opacity = std::clamp(opacity, 1e-6, kMaxKeptOpacity);
  asset.opacity_logits[k] = static_cast<float>(std::log(opacity / (1 - opacity)));
}

// The support of the kernel's thing, if the kernel reaches below it.
BorderPlane border_at_support(const RoomParts& parts, uint16_t label, const Vector3d& mean_m,
                              const Matrix3d& covariance_m2) {
  BorderPlane border;
  if (label == kRoomLabel || !parts.parts[label - 1].support) return border;
  const RoomPlane& plane = parts.planes.supports[*parts.parts[label - 1].support];
  const double deviation_m = std::sqrt(std::max(0.0, plane.normal.dot(covariance_m2 * plane.normal)));
  const double height_m = plane.height_m(mean_m);
  if (height_m > kSplitDeviations * deviation_m) return border;
  border = {true, mean_m - height_m * plane.normal, -plane.normal, kRoomLabel};
  return border;
}

// The plane half-way between the nearest neighbours of two labels, along the line between their centroids.
BorderPlane border_between_neighbours(const GaussianAsset& asset, const RoomParts& parts, uint16_t own,
                                      std::span<const KernelTree::Neighbour> neighbours) {
  BorderPlane border;
  std::vector<std::pair<uint16_t, size_t>> counts;
  for (const auto& n : neighbours) {
    const uint16_t label = parts.label[n.index];
    const auto at =
        std::find_if(counts.begin(), counts.end(), [&](const auto& c) { return c.first == label; });
    if (at == counts.end())
      counts.emplace_back(label, 1);
    else
      ++at->second;
  }
  size_t own_count = 0, most = 0;
  for (const auto& [label, count] : counts) {
    if (label == own)
      own_count = count;
    else if (count > most)
      most = count, border.other = label;
  }
  if (own_count < kMinOtherNeighbours || most < kMinOtherNeighbours) return border;
  Vector3d mine = Vector3d::Zero(), others = Vector3d::Zero();
  for (const auto& n : neighbours) {
    if (parts.label[n.index] == own) mine += asset.positions[n.index].cast<double>();
    if (parts.label[n.index] == border.other) others += asset.positions[n.index].cast<double>();
  }
  mine /= static_cast<double>(own_count);
  others /= static_cast<double>(most);
  if (!((others - mine).norm() > 0)) return border;
  border.normal = (others - mine).normalized();
  std::vector<double> of_mine, of_others;
  for (const auto& n : neighbours) {
    const double along = border.normal.dot(asset.positions[n.index].cast<double>() - mine);
    if (parts.label[n.index] == own) of_mine.push_back(along);
    if (parts.label[n.index] == border.other) of_others.push_back(along);
  }
  std::sort(of_mine.begin(), of_mine.end());
  std::sort(of_others.begin(), of_others.end());
  const double last = of_mine[of_mine.size() * 3 / 4], first = of_others[of_others.size() / 4];
  if (last > first) return border;  // the labels are mixed, no plane separates them
  border.point_m = mine + 0.5 * (last + first) * border.normal;
  border.found = true;
  return border;
}

}  // namespace

SplitRoom split_straddling(const GaussianAsset& asset, const RoomParts& parts) {
  SplitRoom out;
  out.asset = asset;
  out.label = parts.label;
  out.source.resize(asset.size());
  for (uint32_t k = 0; k < asset.size(); ++k) out.source[k] = k;
  const KernelTree tree(asset.positions);

  struct Replaced {
    size_t kernel;
    std::vector<GaussianPart> parts;  // cell 0: own label; cell 1: the other
    uint16_t other;
  };
  constexpr size_t kSplitBlock = 1024;
  std::vector<std::vector<Replaced>> of_block((asset.size() + kSplitBlock - 1) / kSplitBlock);
  parallel_for(asset.size(), kSplitBlock, [&](size_t begin, size_t end) {
    std::vector<KernelTree::Neighbour> neighbours;
    for (size_t k = begin; k < end; ++k) {
      const uint16_t own = parts.label[k];
      const bool mixed = parts.share[k] > 0 && parts.share[k] < kMixedShare;
      if (own == kRoomLabel && !mixed) continue;
      const Vector3d mean_m = asset.positions[k].cast<double>();
      const Matrix3d covariance_m2 = covariance_of(asset, k);
      BorderPlane border = border_at_support(parts, own, mean_m, covariance_m2);
      if (!border.found && mixed) {
        tree.nearest(asset.positions[k], kNeighbours, neighbours);
        border = border_between_neighbours(asset, parts, own, neighbours);
      }
      if (!border.found) continue;
      const double deviation_m = std::sqrt(std::max(0.0, border.normal.dot(covariance_m2 * border.normal)));
      const double ahead_m = border.normal.dot(border.point_m - mean_m);
      if (std::abs(ahead_m) > kSplitDeviations * deviation_m) {
        // Completely on one side.
        if (ahead_m < 0) of_block[begin / kSplitBlock].push_back({k, {}, border.other});
        continue;
      }
      if (deviation_m < kMinWidth_footprints * parts.footprint_m) continue;
      const double opacity = opacity_of_logit(asset.opacity_logits[k]);
      const SplitLimits limits{kOverhang_footprints * parts.footprint_m,
                               kMinKeptOpacity / std::max(opacity, 1e-6)};
      auto split =
          split_gaussian(mean_m, covariance_m2, two_sides(border, deviation_m + std::abs(ahead_m)), limits);
      of_block[begin / kSplitBlock].push_back({k, std::move(split), border.other});
    }
  });
  for (const auto& block : of_block)
    for (const Replaced& one : block) {
      const size_t k = one.kernel;
      if (one.parts.empty()) {
        out.label[k] = one.other;
        continue;
      }
      const double opacity = opacity_of_logit(asset.opacity_logits[k]);
      ++out.split_count;
      // The first part replaces the kernel.
      for (size_t p = 0; p < one.parts.size(); ++p) {
        size_t at = k;
        if (p > 0) {
          at = out.asset.size();
          append_kernel(out.asset, asset, k);
          out.label.push_back(0);
          out.source.push_back(static_cast<uint32_t>(k));
        }
        set_kernel(out.asset, at, one.parts[p], opacity * one.parts[p].opacity);
        out.label[at] = one.parts[p].cell == 0 ? parts.label[k] : one.other;
      }
    }
  return out;
}

}  // namespace livegs
