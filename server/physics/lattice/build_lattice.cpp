// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/lattice/build_lattice.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "physics/lattice/cut_boxes.h"
#include "skin/kernels/cell_fill.h"

namespace livegs {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

struct MaterialMoments {
  double volume = 0.0;
  std::array<double, 8> corner{};
};

struct Moments {
  double volume = 0.0, fixed_volume = 0.0;
  Vector3d first = Vector3d::Zero(), second = Vector3d::Zero();  // of the local coordinates
  std::map<uint16_t, MaterialMoments> materials;
  uint64_t fill = 0;

  void add(const BoxPiece& piece) {
    // Half-length of a uniform interval: sqrt(3 variance).
    const Vector3d half = (3.0 * (piece.mean_square - piece.mean.cwiseAbs2())).cwiseMax(0.0).cwiseSqrt();
    const auto in_cell = [](const Vector3d& local) -> Eigen::Vector3f {
      return (0.5 * (local + Vector3d::Ones())).cast<float>();
    };
    fill |= fill_of_box(in_cell(piece.mean - half), in_cell(piece.mean + half));
    volume += piece.volume_m3;
    first += piece.volume_m3 * piece.mean;
    second += piece.volume_m3 * piece.mean_square;
    if (piece.fixed) fixed_volume += piece.volume_m3;
    MaterialMoments& material = materials[piece.material];
    material.volume += piece.volume_m3;
    const std::array<double, 8> weights = trilinear_weights(piece.mean);
    for (int c = 0; c < 8; ++c) material.corner[c] += piece.volume_m3 * weights[c];
  }
};

bool meets(const BodyExtent& extent, const BodyRegion& region) {
  return ((region.max_m - extent.min_m).array() > 0.0).all() &&
         ((extent.max_m - region.min_m).array() > 0.0).all();
}

// Origin of the lattice planes along each axis: centred on the body, or on a held region's inner face.
Vector3d lattice_origin(const BodyExtent& extent, double cell_width_m, std::span<const BodyRegion> regions) {
  Vector3d origin;
  for (int d = 0; d < 3; ++d) {
    const double length = extent.max_m[d] - extent.min_m[d];
    const double count = std::max(1.0, std::ceil(length / cell_width_m - kMinSlice));
    origin[d] = 0.5 * (extent.min_m[d] + extent.max_m[d]) - 0.5 * count * cell_width_m;
  }
  if (!along_object_axes(extent)) return origin;
  Vector3i snapped = Vector3i::Zero();
  for (const BodyRegion& region : regions) {
    const bool held = region.fixed || (region.motion && !region.boundary);
    if (!held || !meets(extent, region)) continue;
    for (int d = 0; d < 3; ++d) {
      const double margin = 1e-6 * (extent.max_m[d] - extent.min_m[d]);
      for (const double face : {region.max_m[d], region.min_m[d]}) {
        if (snapped[d] || face <= extent.min_m[d] + margin || face >= extent.max_m[d] - margin) continue;
        origin[d] = face - cell_width_m * std::ceil((face - extent.min_m[d]) / cell_width_m - kMinSlice);
        snapped[d] = 1;
      }
    }
  }
  return origin;
}

LatticeCell make_cell(const Moments& moments) {
  LatticeCell cell;
  cell.volume_m3 = moments.volume;
  cell.centroid = moments.first / moments.volume;
  // The variance of a local coordinate over a full cell is 1/3.
  cell.spread = 3.0 * (moments.second / moments.volume - cell.centroid.cwiseAbs2()).cwiseMax(0.0);
  cell.fixed = moments.fixed_volume > (1.0 - kMinSlice) * moments.volume;
  double parts = 0.0;
  for (const auto& [material, of_material] : moments.materials) {
    const double part = of_material.volume / moments.volume;
    if (part < 1e-9) continue;  // rounding
    cell.materials.push_back({material, part});
    parts += part;
  }
  for (MaterialShare& share : cell.materials) share.part /= parts;
  cell.fill = moments.fill;
  return cell;
}

// The points of an irregular list fill inner cells unevenly, and uneven stiffness distorts both the apparent
// modulus and the mean strain. An inner cell that is nearly full is therefore treated as full; the node
// masses keep the distribution of the points.
void fill_inner_cells(Lattice& lattice) {
  constexpr double kFullTolerance = 0.3;
  const std::vector<uint8_t> cells_around = cells_around_nodes(lattice);
  const double full_m3 = std::pow(lattice.cell_width_m, 3);
  for (LatticeCell& cell : lattice.cells) {
    const bool inner = std::ranges::all_of(cell.nodes, [&](uint32_t n) { return cells_around[n] == 8; });
    if (!inner || std::abs(cell.volume_m3 - full_m3) > kFullTolerance * full_m3) continue;
    cell.volume_m3 = full_m3;
    cell.centroid.setZero();
    cell.spread.setOnes();
  }
}

// Raises the smallest node volumes so that every node can be moved; the total stays the body's volume.
void set_node_volumes(Lattice& lattice) {
  const size_t count = lattice.node_coordinates.size();
  const double floor_m3 = 1e-6 * std::pow(lattice.cell_width_m, 3);  // of an inner node
  std::vector<double> volumes(count, 0.0);
  for (const auto& of_material : lattice.material_node_volumes_m3) {
    for (size_t i = 0; i < count; ++i) volumes[i] += of_material[i];
  }
  double total = 0.0, floored_total = 0.0;
  for (const double volume : volumes) {
    total += volume;
    floored_total += std::max(volume, floor_m3);
  }
  lattice.node_volumes_m3.assign(count, 0.0);
  for (size_t i = 0; i < count; ++i) {
    const double kept = std::max(volumes[i], floor_m3) * total / floored_total;
    if (volumes[i] > 0.0) {
      for (auto& of_material : lattice.material_node_volumes_m3) of_material[i] *= kept / volumes[i];
    } else {
      lattice.material_node_volumes_m3[0][i] = kept;
    }
    for (const auto& of_material : lattice.material_node_volumes_m3)
      lattice.node_volumes_m3[i] += of_material[i];
  }
}

}  // namespace

std::vector<uint8_t> cells_around_nodes(const Lattice& lattice) {
  std::vector<uint8_t> cells_around(lattice.node_coordinates.size(), 0);
  for (const LatticeCell& cell : lattice.cells) {
    for (const uint32_t node : cell.nodes) ++cells_around[node];
  }
  return cells_around;
}

Lattice build_lattice(const BodyExtent& extent, double cell_width_m, std::span<const BodyRegion> regions) {
  const Vector3d origin = lattice_origin(extent, cell_width_m, regions);

  // First pass: connected material in each cell, then the virtual cells and nodes.
  std::vector<BoxInCell> entries;
  std::vector<uint32_t> entry_of_piece;
  uint32_t begin = 0;  // first entry of the box
  cut_boxes(extent, origin, cell_width_m, regions, [&](const BoxPiece& piece) {
    if (entries.empty() || entries.back().box != piece.box) begin = static_cast<uint32_t>(entries.size());
    uint32_t entry = begin;
    while (entry < entries.size() && entries[entry].cell != piece.cell) ++entry;
    if (entry == entries.size()) entries.push_back({piece.box, piece.cell});
    entry_of_piece.push_back(entry);
  });
  const auto links = link_boxes(extent, cell_width_m);
  const VirtualCells virtual_cells = make_virtual_cells(entries, links, kLatticeColours);

  Lattice lattice;
  lattice.cell_width_m = cell_width_m;
  lattice.material_volumes_m3.assign(material_count(regions), 0.0);
  std::vector<Moments> moments(virtual_cells.cells.size());
  size_t next_piece = 0;
  cut_boxes(extent, origin, cell_width_m, regions, [&](const BoxPiece& piece) {
    moments[virtual_cells.cell_of_entry[entry_of_piece[next_piece++]]].add(piece);
    lattice.material_volumes_m3[piece.material] += piece.volume_m3;
  });

  Vector3i lowest = virtual_cells.node_coordinates[0];
  for (const Vector3i& node : virtual_cells.node_coordinates) lowest = lowest.cwiseMin(node);
  lattice.object_from_lattice.orientation = extent.object_from_lattice;
  lattice.object_from_lattice.position_m =
      extent.object_from_lattice * (origin + cell_width_m * lowest.cast<double>());
  for (const Vector3i& node : virtual_cells.node_coordinates)
    lattice.node_coordinates.push_back(node - lowest);
  for (size_t i = 1; i < lattice.node_coordinates.size(); ++i) {
    lattice.has_virtual_cells |= lattice.node_coordinates[i] == lattice.node_coordinates[i - 1];
  }

  lattice.material_node_volumes_m3.assign(lattice.material_volumes_m3.size(),
                                          std::vector<double>(lattice.node_coordinates.size(), 0.0));
  for (size_t i = 0; i < moments.size(); ++i) {
    LatticeCell cell = make_cell(moments[i]);
    cell.coordinates = virtual_cells.cells[i].coordinates - lowest;
    cell.nodes = virtual_cells.cells[i].nodes;
    for (const auto& [material, of_material] : moments[i].materials) {
      for (int c = 0; c < 8; ++c)
        lattice.material_node_volumes_m3[material][cell.nodes[c]] += of_material.corner[c];
    }
    lattice.cells.push_back(std::move(cell));
    ++lattice.colour_begin[virtual_cells.cells[i].colour + 1];
  }
  if (extent.of_points) fill_inner_cells(lattice);
  find_thin_shapes(extent, links, entries, virtual_cells.cell_of_entry,
                   origin + cell_width_m * lowest.cast<double>(), lattice);
  for (int colour = 0; colour < kLatticeColours; ++colour) {
    lattice.colour_begin[colour + 1] += lattice.colour_begin[colour];
  }
  lattice.cells_by_place.resize(lattice.cells.size());
  std::iota(lattice.cells_by_place.begin(), lattice.cells_by_place.end(), 0u);
  std::ranges::stable_sort(lattice.cells_by_place, {},
                           [&](uint32_t i) { return lattice_key(lattice.cells[i].coordinates); });
  set_node_volumes(lattice);
  return lattice;
}

}  // namespace livegs
