// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "physics/cut_boxes.h"
#include "physics/lattice.h"
#include "physics/lattice_order.h"

namespace livegs {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Cells are counted as if the body were shorter by this part of one.
constexpr double kThinnestLayer = 1e-3;
// A node is never lighter than this part of an inner one.
constexpr double kLightestNode = 1e-6;
// Less than this part of a cell of a material is rounding.
constexpr double kLeastPart = 1e-9;
// A cell is fixed when all but this part of it is.
constexpr double kLeastFree = 1e-3;

struct MaterialMoments {
  double volume = 0.0;
  std::array<double, 8> corner{};
};

struct Moments {
  double volume = 0.0, fixed_volume = 0.0;
  Vector3d first = Vector3d::Zero(), second = Vector3d::Zero();  // of the local coordinates
  std::map<uint16_t, MaterialMoments> materials;

  void add(const BoxPiece& piece) {
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
  return ((region.max_m - extent.min_m).array() > 0.0).all() && ((extent.max_m - region.min_m).array() > 0.0).all();
}

// Where lattice planes stand along each axis: centred on the body, or through a held region's inner face.
Vector3d lattice_origin(const BodyExtent& extent, double cell_width_m, std::span<const BodyRegion> regions) {
  Vector3d origin;
  for (int d = 0; d < 3; ++d) {
    const double length = extent.max_m[d] - extent.min_m[d];
    const double count = std::max(1.0, std::ceil(length / cell_width_m - kThinnestLayer));
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
        origin[d] = face - cell_width_m * std::ceil((face - extent.min_m[d]) / cell_width_m - kThinnestLayer);
        snapped[d] = 1;
      }
    }
  }
  return origin;
}

LatticeCell make_cell(const Vector3i& coordinates, const Moments& moments) {
  LatticeCell cell;
  cell.coordinates = coordinates;
  cell.volume_m3 = moments.volume;
  cell.centroid = moments.first / moments.volume;
  // The variance of a local coordinate over a full cell is 1/3.
  cell.spread = 3.0 * (moments.second / moments.volume - cell.centroid.cwiseAbs2()).cwiseMax(0.0);
  cell.fixed = moments.fixed_volume > (1.0 - kLeastFree) * moments.volume;
  double parts = 0.0;
  for (const auto& [material, of_material] : moments.materials) {
    const double part = of_material.volume / moments.volume;
    if (part < kLeastPart) continue;
    cell.materials.push_back({material, part});
    parts += part;
  }
  for (MaterialShare& share : cell.materials) share.part /= parts;
  return cell;
}

// No node is too light to be moved, and the sum stays the body's volume.
void set_node_volumes(Lattice& lattice) {
  const size_t count = lattice.node_coordinates.size();
  const double floor_m3 = kLightestNode * std::pow(lattice.cell_width_m, 3);
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
    for (const auto& of_material : lattice.material_node_volumes_m3) lattice.node_volumes_m3[i] += of_material[i];
  }
}

}  // namespace

Lattice build_lattice(const BodyExtent& extent, double cell_width_m, std::span<const BodyRegion> regions) {
  const Vector3d origin = lattice_origin(extent, cell_width_m, regions);
  Lattice lattice;
  lattice.cell_width_m = cell_width_m;
  lattice.material_volumes_m3.assign(material_count(regions), 0.0);

  std::map<LatticeKey, Moments> filled;
  Vector3i lowest = Vector3i::Constant(std::numeric_limits<int>::max());
  cut_boxes(extent, origin, cell_width_m, regions, [&](const BoxPiece& piece) {
    filled[lattice_key(piece.cell)].add(piece);
    lowest = lowest.cwiseMin(piece.cell);
    lattice.material_volumes_m3[piece.material] += piece.volume_m3;
  });
  lattice.object_from_lattice.orientation = extent.object_from_lattice;
  lattice.object_from_lattice.position_m =
      extent.object_from_lattice * (origin + cell_width_m * lowest.cast<double>());

  std::map<LatticeKey, uint32_t> node_indices;
  for (const auto& [key, moments] : filled) {
    const Vector3i coordinates(std::get<2>(key), std::get<1>(key), std::get<0>(key));
    lattice.cells.push_back(make_cell(coordinates - lowest, moments));
    for (int c = 0; c < 8; ++c) node_indices[lattice_key(lattice.cells.back().coordinates + corner_offset(c))] = 0;
  }
  for (auto& [key, index] : node_indices) {
    index = static_cast<uint32_t>(lattice.node_coordinates.size());
    lattice.node_coordinates.emplace_back(std::get<2>(key), std::get<1>(key), std::get<0>(key));
  }
  std::sort(lattice.cells.begin(), lattice.cells.end(),
            [](const auto& a, const auto& b) { return cell_order(a) < cell_order(b); });

  lattice.material_node_volumes_m3.assign(lattice.material_volumes_m3.size(),
                                          std::vector<double>(lattice.node_coordinates.size(), 0.0));
  for (LatticeCell& cell : lattice.cells) {
    const Moments& moments = filled.at(lattice_key(cell.coordinates + lowest));
    for (int c = 0; c < 8; ++c) {
      cell.nodes[c] = node_indices.at(lattice_key(cell.coordinates + corner_offset(c)));
      for (const auto& [material, of_material] : moments.materials) {
        lattice.material_node_volumes_m3[material][cell.nodes[c]] += of_material.corner[c];
      }
    }
    ++lattice.colour_begin[colour_of(cell.coordinates) + 1];
  }
  for (int colour = 0; colour < 8; ++colour) lattice.colour_begin[colour + 1] += lattice.colour_begin[colour];
  set_node_volumes(lattice);
  return lattice;
}

}  // namespace livegs
