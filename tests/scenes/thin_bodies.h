// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "physics/elastic/cells/plate_cell.h"
#include "physics/lattice/lattice.h"
#include "server/physics/lattice/lattice_statics.h"

// Sheets and cords made of small cubes, in a lattice that is rotated against them.

namespace livegs::test {

inline constexpr double kStripThickness_m = 0.003, kStripModulus_pa = 1e6, kStripDensity_kg_m3 = 1000.0;

struct Strip {
  double length_m = 0.2, width_m = 0.05;
  // 0: flat, along x; otherwise an arc in the xz plane that starts along x at 0 and bends down
  double radius_m = 0.0;
};

struct StripPoint {
  Eigen::Vector3d at_m;
  double along_m;
  double volume_m3;
};

// A single layer of cubes, as thick as the strip.
inline std::vector<StripPoint> strip_points(const Strip& strip) {
  const double t = kStripThickness_m;
  const int along = static_cast<int>(std::lround(strip.length_m / t));
  const int across = std::max(1, static_cast<int>(std::lround(strip.width_m / t)));
  const double step = strip.length_m / along, side = strip.width_m / across;
  std::vector<StripPoint> points;
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j < across; ++j) {
      const double s = (i + 0.5) * step, y = (j + 0.5) * side - 0.5 * strip.width_m;
      Eigen::Vector3d at(s, y, 0.0);
      if (strip.radius_m > 0.0) {
        const double turn = s / strip.radius_m;
        at = {strip.radius_m * std::sin(turn), y, strip.radius_m * (std::cos(turn) - 1.0)};
      }
      points.push_back({at, s, step * side * t});
    }
  }
  return points;
}

// Extent of the strip for a lattice that is rotated against it and shifted by a fraction of a cell.
inline BodyExtent strip_extent(const std::vector<StripPoint>& points,
                               const Eigen::Quaterniond& object_from_lattice,
                               const Eigen::Vector3d& shift_m) {
  BodyExtent extent;
  extent.object_from_lattice = object_from_lattice;
  extent.box_edge_m = extent.spacing_m = kStripThickness_m;
  extent.min_m.setConstant(1e300);
  extent.max_m.setConstant(-1e300);
  for (const StripPoint& point : points) {
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5 * std::cbrt(point.volume_m3));
    const Eigen::Vector3d centre = object_from_lattice.conjugate() * point.at_m;
    extent.boxes.push_back({centre, half, point.volume_m3});
    extent.min_m = extent.min_m.cwiseMin(centre - half);
    extent.max_m = extent.max_m.cwiseMax(centre + half);
  }
  // The lattice is centred on the bounds, so wider bounds on one side shift it.
  extent.max_m += 2.0 * shift_m;
  return extent;
}

// Matrix from the displacements of a cell's corners to its strain measures (plate_cell.h).
inline Eigen::Matrix<double, 18, 24> cell_measures(const LatticeCell& cell, double cell_width_m) {
  const auto gradients = trilinear_gradients(cell.centroid, cell_width_m);
  Eigen::Matrix<double, 18, 24> measures = Eigen::Matrix<double, 18, 24>::Zero();
  for (int c = 0; c < 8; ++c) {
    for (int d = 0; d < 3; ++d) {
      Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
      gradient.row(d) = gradients[c].transpose();
      measures.block<6, 1>(0, 3 * c + d) = mandel(0.5 * (gradient + gradient.transpose()));
      for (int j = 0; j < kModeCount; ++j) measures(6 + 3 * j + d, 3 * c + d) = 0.125 * mode_sign(j, c);
    }
  }
  return measures;
}

inline LatticeStatics::CellMatrix thin_matrices(const Lattice& lattice, const IsotropicMaterial& material) {
  return [&lattice, material](const LatticeCell& cell) -> Matrix24 {
    if (!cell.thin) return cell_matrix(cell, lattice.cell_width_m, material);
    const auto measures = cell_measures(cell, lattice.cell_width_m);
    return measures.transpose() *
           thin_cell_stiffness(cell, lattice.cell_width_m, material, strain_modulus(material)) * measures;
  };
}

// Node loads equivalent to forces on points of the body. Forces are in object axes.
inline std::vector<NodeLoad> loads_at(const Lattice& lattice, const std::vector<StripPoint>& points,
                                      const std::function<Eigen::Vector3d(const StripPoint&)>& force_n) {
  std::vector<NodeLoad> loads;
  for (const StripPoint& point : points) {
    const Eigen::Vector3d force = lattice.object_from_lattice.orientation.conjugate() * force_n(point);
    if (force.isZero()) continue;
    const EmbeddedPoint at = lattice.embed(point.at_m);
    const auto weights = trilinear_weights(at.local);
    for (int c = 0; c < 8; ++c) loads.push_back({lattice.cells[at.cell].nodes[c], weights[c] * force});
  }
  return loads;
}

inline double work(const std::vector<NodeLoad>& loads, const std::vector<Eigen::Vector3d>& displacements) {
  double sum = 0.0;
  for (const NodeLoad& load : loads) sum += load.force_n.dot(displacements[load.node]);
  return sum;
}

}  // namespace livegs::test
