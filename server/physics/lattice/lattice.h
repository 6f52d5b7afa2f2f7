// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/pose.h"
#include "geometry/field/sample_particles.h"
#include "physics/body_region.h"

// The lattice of cubic eight-node cells that an elastic body is embedded in. Its nodes are the unknowns of
// the `cells` solver and the drivers of the kernels; particles ride in cells by trilinear weights.
//
//        6-------7         Corner c of a cell: bit 0 of c is +x, bit 1 +y, bit 2 +z.
//       /|      /|         Inside a cell a point has local coordinates -1 ... 1 along each axis, and corner c
//       the
//      4-------5 |         weight N_c = (1 ± x)(1 ± y)(1 ± z) / 8.
//      | 2-----|-3
//      |/      |/          A cell need not be full: it keeps the volume, centroid and spread of the material
//      in it, 0-------1           so that cut cells, sheets and cords need no form of their own.

namespace livegs {

// What part of a cell's material, by volume, is of one of the body's materials.
struct MaterialShare {
  uint16_t material;  // 0: the body's own; k: of the k-th region that has a material
  double part;
};

// The material in and about a cell, where that is a sheet or a cord thinner than half the cell: its principal
// axes (columns, lattice axes, the thinnest first) and its variance along each. Along the thinnest it is that
// of a sheet of this volume over this area, whatever boxes stand for it.
struct ThinShape {
  Eigen::Matrix3d axes;
  Eigen::Vector3d variance_m2;
};

struct LatticeCell {
  Eigen::Vector3i coordinates;
  std::array<uint32_t, 8> nodes{};
  double volume_m3 = 0.0;    // of the material inside, at rest
  Eigen::Vector3d centroid;  // of the material, local coordinates
  Eigen::Vector3d spread;    // variance of the material along each axis over that of a full cell; 0 ... 1
  bool fixed = false;        // all its material lies in fixed regions
  std::vector<MaterialShare> materials;  // ascending, parts sum to 1
  uint64_t fill = 0;                     // where the material is (skin/cell_fill.h)
  std::optional<ThinShape> thin;
};

// A material point as its cell and local coordinates; slightly beyond -1 ... 1 for points outside every cell.
struct EmbeddedPoint {
  uint32_t cell = 0;
  Eigen::Vector3d local = Eigen::Vector3d::Zero();
};
std::array<double, 8> trilinear_weights(const Eigen::Vector3d& local);
// Gradients of the weights by lattice position, 1/m.
std::array<Eigen::Vector3d, 8> trilinear_gradients(const Eigen::Vector3d& local, double cell_width_m);

// The material as boxes along the lattice axes: what the cells are filled with.
struct MassBox {
  Eigen::Vector3d centre_m, half_m;  // lattice axes
  double volume_m3;
};

// The directions of the lattice and what lies along them. The object's own axes where they fit as tightly as
// the principal ones (a tie keeps a regular grid of particles regular), else the principal axes: a sheet or a
// cord is modelled well only along itself (elastic-study.md 5).
struct BodyExtent {
  Eigen::Quaterniond object_from_lattice;
  std::vector<MassBox> boxes;
  Eigen::Vector3d min_m, max_m;  // of the boxes
  double box_edge_m = 0.0;       // of a typical box
  double spacing_m = 0.0;        // of the particles
  bool of_points = false;        // of a list of points: no mesh says where it is full
  bool loose =
      false;  // boxes stand about points on the surface of what is thinner than a voxel, near where it is
};
// Preconditions: at least one particle, finite positions, positive volumes.
BodyExtent measure_extent(const ParticleSet& particles);

// Cells of one colour share no node. The first eight are the parities of the coordinates; the rest are for
// further cells at one place.
inline constexpr int kLatticeColours = 16;

struct Lattice {
  Pose object_from_lattice;
  double cell_width_m = 0.0;
  std::vector<Eigen::Vector3i> node_coordinates;  // >= 0
  std::vector<double> node_volumes_m3;            // sum to the body's
  std::vector<std::vector<double>>
      material_node_volumes_m3;  // [material][node], sum over materials to the above
  std::vector<double> material_volumes_m3;
  std::vector<LatticeCell> cells;  // grouped by colour, then by z, y, x
  std::array<uint32_t, kLatticeColours + 1> colour_begin{};
  std::vector<uint32_t> cells_by_place;  // all cells by z, y, x
  // Several cells or nodes may stand at one place, for parts of the body that touch only in the picture
  // (virtual_nodes.h).
  bool has_virtual_cells = false;

  Eigen::Vector3d node_position_m(size_t node) const;  // object frame, at rest
  // The cell a material point (object frame) lies in, or the nearest cell; with virtual cells the cell whose
  // material is nearest.
  EmbeddedPoint embed(const Eigen::Vector3d& object_point_m) const;
};

// How many cells each node belongs to; one with fewer than eight is on the outside.
std::vector<uint8_t> cells_around_nodes(const Lattice& lattice);

// Parts of it that share no node.
int piece_count(const Lattice& lattice);

// Where the lattice lies along the object's axes, a lattice plane is snapped to the inner face of the first
// fixed or moved region along each axis, and materials meet exactly at the faces of their regions (else
// within an eighth of a box edge). Where regions with a material overlap, the last counts.
Lattice build_lattice(const BodyExtent& extent, double cell_width_m, std::span<const BodyRegion> regions);

}  // namespace livegs
