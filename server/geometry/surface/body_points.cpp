// SPDX-License-Identifier: GPL-3.0-or-later
// Drops haze and isolated floaters, then adds points to large kernels.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "gaussian/opacity.h"
#include "geometry/field/regular_grid.h"
#include "geometry/reconstruct_surface.h"

namespace livegs {
namespace {

// Minimum opacity of a kernel; fainter kernels are haze. A higher value splits thin leaves, a lower one keeps
// haze around an object.
constexpr float kMinOpacity = 0.1f;
// Removal of isolated groups. Kernels are sorted into cells of kLinkCell of the bounding-box diagonal. A
// group of adjacent cells with less than kMinShare of all kernels is dropped. This is repeated with the
// smaller box until nothing changes. A leaf is a chain of cells connected to its plant, however thin and
// long. The cells are doubled while more than kMaxAlone of the kernels are alone in theirs: then the cloud is
// sparse, not isolated. On average 1.4 kernels in a cell of a surface leave a quarter of them alone.
constexpr double kLinkCell = 0.02;
constexpr double kMaxAlone = 0.25;
constexpr double kMinShare = 1e-3;
constexpr int kMaxRounds = 12;
// Kernels larger than this fraction of the diagonal get additional points with this spacing, up to one
// standard deviation (0.6 of the opacity). So few large kernels close a leaf or a wall like many small ones.
// At most kMaxSpreadPoints per side and axis, then with a wider spacing.
constexpr double kSpread = 0.01;
constexpr int kMaxSpreadPoints = 4;
// At most this many additional points, plus kSpreadPerKernel for each kernel; then the spacing is wider for
// all. Captures need a tenth. The limit keeps the memory in proportion to the file if kernels are as wide as
// the whole object.
constexpr size_t kMaxSpreadTotal = 2000000;
constexpr size_t kSpreadPerKernel = 8;
constexpr double kSpreadGrowth = 1.25;

Eigen::AlignedBox3d bounds_of(const std::vector<Eigen::Vector3d>& points) {
  Eigen::AlignedBox3d bounds;
  for (const auto& point : points) bounds.extend(point);
  return bounds;
}

// For each point the number of its group of adjacent occupied cells (26 neighbours), and the size of each
// group.
struct Groups {
  std::vector<int32_t> of_point;
  std::vector<size_t> sizes;
};

Groups linked_groups(const std::vector<Eigen::Vector3d>& points, const Eigen::AlignedBox3d& bounds) {
  RegularGrid grid;
  grid.origin_m = bounds.min();
  const auto cell_of = [&](const Eigen::Vector3d& p) {
    return Eigen::Vector3i(
        ((p - grid.origin_m) / grid.cell_m).array().floor().cast<int>().min(grid.counts.array() - 1));
  };
  const auto alone = [&] {
    std::vector<uint8_t> held(grid.size(), 0);  // 2: two or more
    for (const auto& point : points) {
      const Eigen::Vector3i c = cell_of(point);
      uint8_t& cell = held[grid.index(c.x(), c.y(), c.z())];
      cell = std::min<uint8_t>(cell + 1, 2);
    }
    return static_cast<double>(std::count(held.begin(), held.end(), 1));
  };
  grid.cell_m = kLinkCell * bounds.diagonal().norm();
  for (;; grid.cell_m *= 2.0) {
    grid.counts = (bounds.sizes() / grid.cell_m).array().floor().cast<int>() + 1;
    if (grid.size() == 1 || alone() <= kMaxAlone * static_cast<double>(points.size())) break;
  }
  constexpr int32_t kEmpty = -2, kUnseen = -1;
  std::vector<int32_t> group_of_cell(grid.size(), kEmpty);
  for (const auto& point : points) {
    const Eigen::Vector3i c = cell_of(point);
    group_of_cell[grid.index(c.x(), c.y(), c.z())] = kUnseen;
  }
  int32_t count = 0;
  std::vector<Eigen::Vector3i> open;
  for (int k = 0; k < grid.counts.z(); ++k) {
    for (int j = 0; j < grid.counts.y(); ++j) {
      for (int i = 0; i < grid.counts.x(); ++i) {
        if (group_of_cell[grid.index(i, j, k)] != kUnseen) continue;
        group_of_cell[grid.index(i, j, k)] = count;
        open.emplace_back(i, j, k);
        while (!open.empty()) {
          const Eigen::Vector3i c = open.back();
          open.pop_back();
          const Eigen::Vector3i low = (c.array() - 1).max(0),
                                high = (c.array() + 1).min(grid.counts.array() - 1);
          for (int z = low.z(); z <= high.z(); ++z) {
            for (int y = low.y(); y <= high.y(); ++y) {
              for (int x = low.x(); x <= high.x(); ++x) {
                int32_t& group = group_of_cell[grid.index(x, y, z)];
                if (group != kUnseen) continue;
                group = count;
                open.emplace_back(x, y, z);
              }
            }
          }
        }
        ++count;
      }
    }
  }
  Groups groups;
  groups.sizes.assign(count, 0);
  for (const auto& point : points) {
    const Eigen::Vector3i c = cell_of(point);
    groups.of_point.push_back(group_of_cell[grid.index(c.x(), c.y(), c.z())]);
    ++groups.sizes[groups.of_point.back()];
  }
  return groups;
}

// Removes isolated groups from `kernels` and `points`.
void drop_far(std::vector<uint32_t>& kernels, std::vector<Eigen::Vector3d>& points) {
  for (int round = 0; round < kMaxRounds; ++round) {
    const Eigen::AlignedBox3d bounds = bounds_of(points);
    if (points.empty() || !(bounds.diagonal().norm() > 0.0)) return;
    const Groups groups = linked_groups(points, bounds);
    size_t kept = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      if (static_cast<double>(groups.sizes[groups.of_point[i]]) <
          kMinShare * static_cast<double>(points.size()))
        continue;
      kernels[kept] = kernels[i];
      points[kept++] = points[i];
    }
    if (kept == points.size() || kept == 0) return;
    kernels.resize(kept);
    points.resize(kept);
  }
}

// The additional points of a kernel at this spacing: every `step` of the kernel's axes, to `steps` on each
// side.
struct SpreadGrid {
  Eigen::Array3d step;
  Eigen::Array3i steps;
};

std::optional<SpreadGrid> spread_grid(const Eigen::Vector3d& deviations, double spread) {
  if (deviations.maxCoeff() < spread) return std::nullopt;
  SpreadGrid grid;
  grid.step = (deviations.array() / kMaxSpreadPoints).max(spread);
  grid.steps = (deviations.array() / grid.step + 1e-9).floor().cast<int>();
  return grid;
}

// The spacing, or a wider one with which all kernels together stay within the limit.
double limited_spread(const GaussianAsset& asset, const std::vector<uint32_t>& kernels, double spread) {
  const size_t limit = kMaxSpreadTotal + kSpreadPerKernel * kernels.size();
  for (; spread > 0.0; spread *= kSpreadGrowth) {
    size_t count = 0;
    for (const uint32_t kernel : kernels) {
      const auto grid = spread_grid(asset.log_scales[kernel].cast<double>().array().exp(), spread);
      if (grid) count += static_cast<size_t>((2 * grid->steps + 1).prod());
    }
    if (count <= limit) break;
  }
  return spread;
}

}  // namespace

std::vector<Eigen::Vector3d> body_points(const GaussianAsset& asset, const Similarity& object_from_asset) {
  std::vector<uint32_t> kernels;
  std::vector<Eigen::Vector3d> points;
  for (uint32_t kernel = 0; kernel < asset.size(); ++kernel) {
    if (opacity_of_logit(asset.opacity_logits[kernel]) < kMinOpacity) continue;
    kernels.push_back(kernel);
    points.push_back(asset.positions[kernel].cast<double>());
  }
  drop_far(kernels, points);

  const double spread = limited_spread(asset, kernels, kSpread * bounds_of(points).diagonal().norm());
  const size_t centre_count = points.size();
  for (size_t i = 0; i < centre_count && spread > 0.0; ++i) {
    const Eigen::Vector3d deviations = asset.log_scales[kernels[i]].cast<double>().array().exp();
    const auto grid = spread_grid(deviations, spread);
    if (!grid) continue;
    const auto& [step, steps] = *grid;
    const Eigen::Matrix3d axes = asset.rotations[kernels[i]].cast<double>().toRotationMatrix();
    for (int a = -steps.x(); a <= steps.x(); ++a) {
      for (int b = -steps.y(); b <= steps.y(); ++b) {
        for (int c = -steps.z(); c <= steps.z(); ++c) {
          const Eigen::Vector3d offset = step * Eigen::Array3d(a, b, c);
          const bool within = offset.cwiseQuotient(deviations).squaredNorm() <= 1.0 + 1e-9;
          if (!within || (a == 0 && b == 0 && c == 0)) continue;
          points.push_back(points[i] + axes * offset);
        }
      }
    }
  }
  for (auto& point : points) point = object_from_asset * point;
  return points;
}

}  // namespace livegs
