// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "physics/lattice/build_lattice.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Maximum thickness of a thin sheet, in cell widths.
constexpr double kMaxThinRatio = 0.5;

// Boxes linked to box i are to[begin[i]] ... to[begin[i + 1] - 1].
struct Neighbours {
  std::vector<uint32_t> begin, to;

  Neighbours(size_t count, const BoxLinks& links) : begin(count + 1, 0) {
    for (const auto& [i, j] : links) {
      ++begin[i + 1];
      ++begin[j + 1];
    }
    for (size_t i = 0; i < count; ++i) begin[i + 1] += begin[i];
    to.resize(begin[count]);
    std::vector<uint32_t> next(begin.begin(), begin.end() - 1);
    for (const auto& [i, j] : links) {
      to[next[i]++] = j;
      to[next[j]++] = i;
    }
  }
};

struct ShapeMoments {
  double volume = 0.0;
  Vector3d first = Vector3d::Zero();  // about the cube's centre
  Matrix3d second = Matrix3d::Zero();

  // Adds the part of a box inside the cube; false if it is empty.
  bool add(const MassBox& box, const Vector3d& centre_m, double half_m) {
    const Vector3d low = (box.centre_m - box.half_m - centre_m).cwiseMax(-half_m);
    const Vector3d high = (box.centre_m + box.half_m - centre_m).cwiseMin(half_m);
    const Vector3d edge = high - low;
    if ((edge.array() <= 0.0).any()) return false;
    const double part = box.volume_m3 * edge.cwiseQuotient(2.0 * box.half_m).prod();
    const Vector3d mean = 0.5 * (low + high);
    volume += part;
    first += part * mean;
    second += part * (mean * mean.transpose());
    second.diagonal() += part / 12.0 * edge.cwiseAbs2();
    return true;
  }
};

std::optional<ThinShape> thin_shape(const ShapeMoments& moments, double cell_width_m) {
  if (moments.volume <= 0.0) return std::nullopt;
  const Vector3d mean = moments.first / moments.volume;
  const Matrix3d covariance = moments.second / moments.volume - mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(covariance);
  ThinShape shape;
  // The lower bound avoids division by zero.
  shape.variance_m2 = solver.eigenvalues().cwiseMax(1e-8 * cell_width_m * cell_width_m);
  // The factor is 12 for a rectangle, 4 pi for an ellipse.
  const double area_m2 = 12.3 * std::sqrt(shape.variance_m2[1] * shape.variance_m2[2]);
  const double thickness_m = moments.volume / area_m2;
  if (thickness_m >= kMaxThinRatio * cell_width_m) return std::nullopt;
  shape.variance_m2[0] = std::min(thickness_m * thickness_m / 12.0, shape.variance_m2[1]);
  shape.axes = with_positive_entries(solver.eigenvectors());
  return shape;
}

}  // namespace

void find_thin_shapes(const BodyExtent& extent, const BoxLinks& links, std::span<const BoxInCell> entries,
                      std::span<const uint32_t> cell_of_entry, const Vector3d& origin_m, Lattice& lattice) {
  const double width = lattice.cell_width_m, full_m3 = width * width * width;
  std::vector<std::vector<uint32_t>> boxes(lattice.cells.size());  // of each cell that may be thin
  // A fuller cell holds no thin sheet in any orientation: sqrt(2) times the ratio, rounded up.
  const double thin_m3 = 1.5 * kMaxThinRatio * full_m3;
  for (size_t e = 0; e < entries.size(); ++e) {
    const uint32_t cell = cell_of_entry[e];
    if (lattice.cells[cell].volume_m3 < thin_m3) boxes[cell].push_back(entries[e].box);
  }
  const Neighbours neighbours(extent.boxes.size(), links);
  std::vector<uint32_t> seen_by(extent.boxes.size(), UINT32_MAX);
  for (uint32_t i = 0; i < lattice.cells.size(); ++i) {
    std::vector<uint32_t>& queue = boxes[i];
    if (queue.empty()) continue;
    LatticeCell& cell = lattice.cells[i];
    const Vector3d centre_m =
        origin_m + width * (cell.coordinates.cast<double>() + 0.5 * (cell.centroid + Vector3d::Ones()));
    for (const uint32_t box : queue) seen_by[box] = i;
    ShapeMoments moments;
    for (size_t k = 0; k < queue.size(); ++k) {
      const uint32_t box = queue[k];
      if (!moments.add(extent.boxes[box], centre_m, 0.5 * width)) continue;
      for (uint32_t n = neighbours.begin[box]; n < neighbours.begin[box + 1]; ++n) {
        const uint32_t other = neighbours.to[n];
        if (seen_by[other] == i) continue;
        seen_by[other] = i;
        queue.push_back(other);
      }
    }
    cell.thin = thin_shape(moments, width);
  }
}

}  // namespace livegs
