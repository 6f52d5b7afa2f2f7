// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "core/pose.h"
#include "geometry/field/sample_particles.h"
#include "physics/body_region.h"

// The lattice of cubic eight-node cells that an elastic body is embedded in. Its nodes are the unknowns of
// the `cells` solver and the drivers of the kernels; particles are embedded in cells by trilinear weights.
//
//        6-------7       Corner c of a cell: bit 0 of c is +x, bit 1 +y, bit 2 +z.
//       /|      /|       A point in a cell has local coordinates -1 ... 1 along each axis,
//      4-------5 |       and corner c the weight N_c = (1 ± x)(1 ± y)(1 ± z) / 8.
//      | 2-----|-3
//      |/      |/        A cell may be partly filled: it stores volume, centroid and spread of its
//      0-------1         material, so cut cells, sheets and cords need no other representation.

namespace livegs {

// Volume fraction of a cell that one of the body's materials fills.
struct MaterialShare {
  uint16_t material;  // 0: the body's own; k: of the k-th region that has a material
  double part;
};

// Shape of the material in and about a cell, if it is a sheet or a cord thinner than half the cell: principal
// axes (columns, lattice axes, thinnest first) and variance along each. The variance along the thinnest axis
// is that of a sheet of this volume over this area, independent of the boxes that represent it.
struct ThinShape {
  Eigen::Matrix3d axes;
  Eigen::Vector3d variance_m2;
};

// Order of cells and nodes.
inline std::tuple<int, int, int> lattice_key(const Eigen::Vector3i& c) { return {c.z(), c.y(), c.x()}; }

struct LatticeCell {
  Eigen::Vector3i coordinates;
  std::array<uint32_t, 8> nodes{};
  double volume_m3 = 0.0;    // of the material inside, at rest
  Eigen::Vector3d centroid;  // of the material, local coordinates
  Eigen::Vector3d spread;    // variance of the material along each axis relative to a full cell; 0 ... 1
  bool fixed = false;        // all material lies in fixed regions
  std::vector<MaterialShare> materials;  // ascending index; parts sum to 1
  uint64_t fill = 0;                     // occupancy mask (skin/cell_fill.h)
  std::optional<ThinShape> thin;
};

// A material point as cell and local coordinates; slightly beyond -1 ... 1 for points outside all cells.
struct EmbeddedPoint {
  uint32_t cell = 0;
  Eigen::Vector3d local = Eigen::Vector3d::Zero();
};
// Local coordinates of a corner.
inline Eigen::Vector3d corner_sign(int c) {
  return {c & 1 ? 1.0 : -1.0, c & 2 ? 1.0 : -1.0, c & 4 ? 1.0 : -1.0};
}
std::array<double, 8> trilinear_weights(const Eigen::Vector3d& local);
// Gradients of the weights with respect to the lattice position, 1/m.
std::array<Eigen::Vector3d, 8> trilinear_gradients(const Eigen::Vector3d& local, double cell_width_m);

// A box of material along the lattice axes.
struct MassBox {
  Eigen::Vector3d centre_m, half_m;  // lattice axes
  double volume_m3;
};

// Axes of the lattice and the material along them. The object's own axes are used if they fit about as
// tightly as the principal axes, which keeps a regular grid of particles regular. Otherwise the principal
// axes are used: sheets and cords are modelled well only along the lattice axes.
struct BodyExtent {
  Eigen::Quaterniond object_from_lattice;
  std::vector<MassBox> boxes;
  Eigen::Vector3d min_m, max_m;  // bounds of the boxes
  double box_edge_m = 0.0;       // of a typical box
  double spacing_m = 0.0;        // of the particles
  bool of_points = false;        // from a list of points without a mesh
  // Boxes are about surface points of a body thinner than a voxel; the material is near them.
  bool loose = false;
};
// Preconditions: at least one particle, finite positions, positive volumes.
BodyExtent measure_extent(const ParticleSet& particles);

// Cells of one colour share no node. The first eight colours are the parities of the coordinates; the rest
// are for additional cells at one place.
inline constexpr int kLatticeColours = 16;

struct Lattice {
  Pose object_from_lattice;
  double cell_width_m = 0.0;
  std::vector<Eigen::Vector3i> node_coordinates;  // >= 0
  std::vector<double> node_volumes_m3;            // sum to the body's volume
  // [material][node]; the sum over materials is node_volumes_m3.
  std::vector<std::vector<double>> material_node_volumes_m3;
  std::vector<double> material_volumes_m3;
  std::vector<LatticeCell> cells;  // grouped by colour, then by z, y, x
  std::array<uint32_t, kLatticeColours + 1> colour_begin{};
  std::vector<uint32_t> cells_by_place;  // all cells by z, y, x
  // Whether several cells or nodes are at one place, for parts of the body that are close but not connected
  // (build_lattice.h).
  bool has_virtual_cells = false;

  Eigen::Vector3d node_position_m(size_t node) const;  // object frame, at rest
  // Embeds a material point (object frame) in its cell, or else in the nearest cell; with virtual cells, in
  // the cell with the nearest material.
  EmbeddedPoint embed(const Eigen::Vector3d& object_point_m) const;
};

// Number of cells at each node; below eight for nodes on the boundary.
std::vector<uint8_t> cells_around_nodes(const Lattice& lattice);

// Number of parts that share no node.
int piece_count(const Lattice& lattice);

// If the lattice is along the object's axes, a lattice plane along each axis is snapped to the inner face of
// the first fixed or moved region, and materials meet exactly at the faces of their regions. Otherwise they
// meet within an eighth of a box edge. Where regions with a material overlap, the last one applies.
Lattice build_lattice(const BodyExtent& extent, double cell_width_m, std::span<const BodyRegion> regions);

}  // namespace livegs
