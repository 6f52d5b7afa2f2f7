// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/field/colour_grid.h"

#include <cmath>

#include "core/assert.h"

namespace livegs {
namespace {
constexpr double kCells = 100000.0;
}

ColourGrid::ColourGrid(std::span<const Eigen::Vector3d> points_m, std::span<const Eigen::Vector3f> colours) {
  LIVEGS_ASSERT(!points_m.empty() && points_m.size() == colours.size());
  Eigen::AlignedBox3d box;
  for (const auto& point : points_m) box.extend(point);
  const Eigen::Vector3d size = box.sizes().cwiseMax(1e-3 * box.sizes().maxCoeff()).cwiseMax(1e-9);
  grid_.cell_m = affordable_cell_m(std::cbrt(size.prod() / kCells), box.sizes(), 4.0 * kCells);
  grid_.origin_m = box.min();
  grid_.counts = (box.sizes() / grid_.cell_m).array().floor().cast<int>() + 1;

  std::vector<Eigen::Vector3d> sums(grid_.size(), Eigen::Vector3d::Zero());
  std::vector<uint32_t> counts(grid_.size(), 0);
  for (size_t p = 0; p < points_m.size(); ++p) {
    const size_t cell = cell_of(points_m[p]);
    sums[cell] += colours[p].cast<double>();
    ++counts[cell];
  }
  colours_.assign(grid_.size(), Eigen::Vector3f::Zero());
  std::vector<uint32_t> layer(grid_.size(), ~0u);
  std::vector<size_t> front, next;
  for (size_t cell = 0; cell < layer.size(); ++cell) {
    if (counts[cell] == 0) continue;
    colours_[cell] = (sums[cell] / counts[cell]).cast<float>();
    layer[cell] = 0;
    front.push_back(cell);
  }
  const auto for_neighbours = [&](size_t cell, auto&& visit) {
    const size_t row = grid_.counts.x(), sheet = row * grid_.counts.y();
    if (cell % row > 0) visit(cell - 1);
    if (cell % row + 1 < row) visit(cell + 1);
    if (cell % sheet >= row) visit(cell - row);
    if (cell % sheet + row < sheet) visit(cell + row);
    if (cell >= sheet) visit(cell - sheet);
    if (cell + sheet < grid_.size()) visit(cell + sheet);
  };
  for (uint32_t step = 1; !front.empty(); ++step) {
    next.clear();
    for (size_t cell : front) {
      for_neighbours(cell, [&](size_t other) {
        if (layer[other] != ~0u) return;
        layer[other] = step;
        next.push_back(other);
      });
    }
    for (size_t cell : next) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      float count = 0.0f;
      for_neighbours(cell, [&](size_t other) {
        if (layer[other] < step) sum += colours_[other], count += 1.0f;
      });
      colours_[cell] = sum / count;
    }
    front.swap(next);
  }
}

size_t ColourGrid::cell_of(const Eigen::Vector3d& point_m) const {
  const Eigen::Array3d place = ((point_m - grid_.origin_m) / grid_.cell_m).array().floor();
  const Eigen::Vector3i cell = place.max(0.0).min((grid_.counts.array() - 1).cast<double>()).cast<int>();
  return grid_.index(cell.x(), cell.y(), cell.z());
}

}  // namespace livegs
