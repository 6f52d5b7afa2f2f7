// SPDX-License-Identifier: GPL-3.0-or-later
// The moments of the material in each cell are exact: a particle is a box along the lattice axes, and a box cut by
// lattice planes is again boxes. (Point samples of the particles alias with the lattice, elastic-study.md 2.1.)
#include "physics/lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace livegs {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// A slice of a box thinner than this part of a cell goes to the neighbouring cell, so that rounding makes no cell of
// nearly nothing.
constexpr double kThinnestSlice = 1e-3;
// A node is never lighter than this part of an inner one.
constexpr double kLightestNode = 1e-6;
// Particles outside every cell ride in the nearest one, at most this far beyond its faces (local coordinates).
constexpr double kFurthestLocal = 2.0;

struct Moments {
  double volume = 0.0, fixed_volume = 0.0;
  Vector3d first = Vector3d::Zero(), second = Vector3d::Zero();  // of the local coordinates
  std::array<double, 8> corner{};
};

// What of an interval lies in one cell: part of its length, mean and mean square of the local coordinate.
struct Slice {
  int cell;
  double part, mean, mean_square;
};

// `low`, `high` in cells.
void cut_interval(double low, double high, std::vector<Slice>& slices) {
  slices.clear();
  const auto snapped = [](double x) {
    const double plane = std::round(x);
    return std::abs(x - plane) < kThinnestSlice ? plane : x;
  };
  if (high - low > 4.0 * kThinnestSlice) {
    low = snapped(low);
    high = snapped(high);
  }
  double begin = low;
  for (int cell = static_cast<int>(std::floor(low)); begin < high; ++cell) {
    const double end = std::min(high, cell + 1.0);
    const double from = 2.0 * (begin - cell) - 1.0, to = 2.0 * (end - cell) - 1.0;
    slices.push_back({cell, (end - begin) / (high - low), 0.5 * (from + to), (from * from + from * to + to * to) / 3.0});
    begin = end;
  }
}

auto key_of(const Vector3i& c) { return std::make_tuple(c.z(), c.y(), c.x()); }
using Key = std::tuple<int, int, int>;

int colour_of(const Vector3i& c) { return (c.x() & 1) | (c.y() & 1) << 1 | (c.z() & 1) << 2; }

auto cell_order(const LatticeCell& cell) { return std::make_tuple(colour_of(cell.coordinates), key_of(cell.coordinates)); }

bool contains(const RestBox& box, const Vector3d& point, double margin) {
  return ((point - box.min_m).array() >= -margin).all() && ((box.max_m - point).array() >= -margin).all();
}

// Where lattice planes stand along each axis: centred on the body, or through a fixed region's inner face.
Vector3d lattice_origin(const BodyExtent& extent, double cell_width, std::span<const RestBox> fixed_regions) {
  Vector3d origin;
  for (int d = 0; d < 3; ++d) {
    const double length = extent.max_m[d] - extent.min_m[d];
    const double count = std::max(1.0, std::ceil(length / cell_width - kThinnestSlice));
    origin[d] = 0.5 * (extent.min_m[d] + extent.max_m[d]) - 0.5 * count * cell_width;
  }
  if (extent.object_from_lattice.angularDistance(Eigen::Quaterniond::Identity()) > 1e-9) return origin;
  Vector3i snapped = Vector3i::Zero();
  for (const RestBox& region : fixed_regions) {
    if (((region.max_m - extent.min_m).array() <= 0.0).any() || ((extent.max_m - region.min_m).array() <= 0.0).any()) {
      continue;
    }
    for (int d = 0; d < 3; ++d) {
      const double margin = 1e-6 * (extent.max_m[d] - extent.min_m[d]);
      for (const double face : {region.max_m[d], region.min_m[d]}) {
        if (snapped[d] || face <= extent.min_m[d] + margin || face >= extent.max_m[d] - margin) continue;
        origin[d] = face - cell_width * std::ceil((face - extent.min_m[d]) / cell_width - kThinnestSlice);
        snapped[d] = 1;
      }
    }
  }
  return origin;
}

}  // namespace

std::array<double, 8> trilinear_weights(const Vector3d& local) {
  std::array<double, 8> weights;
  for (int c = 0; c < 8; ++c) {
    weights[c] = 0.125 * (c & 1 ? 1.0 + local.x() : 1.0 - local.x()) * (c & 2 ? 1.0 + local.y() : 1.0 - local.y()) *
                 (c & 4 ? 1.0 + local.z() : 1.0 - local.z());
  }
  return weights;
}

std::array<Vector3d, 8> trilinear_gradients(const Vector3d& local, double cell_width_m) {
  std::array<Vector3d, 8> gradients;
  for (int c = 0; c < 8; ++c) {
    const Vector3d sign(c & 1 ? 1.0 : -1.0, c & 2 ? 1.0 : -1.0, c & 4 ? 1.0 : -1.0);
    const Vector3d f = Vector3d::Ones() + sign.cwiseProduct(local);
    gradients[c] = Vector3d(sign.x() * f.y() * f.z(), sign.y() * f.z() * f.x(), sign.z() * f.x() * f.y()) /
                   (4.0 * cell_width_m);
  }
  return gradients;
}

Vector3d Lattice::node_position_m(size_t node) const {
  return object_from_lattice * (cell_width_m * node_coordinates[node].cast<double>());
}

EmbeddedPoint Lattice::embed(const Vector3d& object_point_m) const {
  const Vector3d point = object_from_lattice.orientation.conjugate() *
                         (object_point_m - object_from_lattice.position_m) / cell_width_m;
  const auto local_in = [&](const LatticeCell& cell) -> Vector3d {
    return 2.0 * (point - cell.coordinates.cast<double>()) - Vector3d::Ones();
  };
  EmbeddedPoint nearest;
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](uint32_t i) {
    const double beyond = (local_in(cells[i]).cwiseAbs() - Vector3d::Ones()).cwiseMax(0.0).squaredNorm();
    if (beyond >= least) return;
    least = beyond;
    nearest.cell = i;
  };
  const auto consider_at = [&](const Vector3i& coordinates) {
    LatticeCell sought;
    sought.coordinates = coordinates;
    const auto found = std::lower_bound(cells.begin(), cells.end(), sought, [](const auto& a, const auto& b) {
      return cell_order(a) < cell_order(b);
    });
    if (found != cells.end() && found->coordinates == coordinates) consider(static_cast<uint32_t>(found - cells.begin()));
  };
  // Within reach of int and finite, or it is far outside anyway.
  if ((point.array().abs() < 1e9).all()) {
    const Vector3i own(static_cast<int>(std::floor(point.x())), static_cast<int>(std::floor(point.y())),
                       static_cast<int>(std::floor(point.z())));
    consider_at(own);
    for (int k = 0; k < 27 && least > 0.0; ++k) consider_at(own + Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
  }
  // Any other cell is a whole cell away: two local units.
  if (least > 4.0) {
    for (uint32_t i = 0; i < cells.size(); ++i) consider(i);
  }
  nearest.local = local_in(cells[nearest.cell]).cwiseMax(-kFurthestLocal).cwiseMin(kFurthestLocal);
  return nearest;
}

Lattice build_lattice(const BodyExtent& extent, double cell_width_m, std::span<const RestBox> fixed_regions) {
  const Vector3d origin = lattice_origin(extent, cell_width_m, fixed_regions);
  const double margin = 1e-6 * cell_width_m;

  std::map<Key, Moments> filled;
  std::array<std::vector<Slice>, 3> slices;
  for (const MassBox& box : extent.boxes) {
    for (int d = 0; d < 3; ++d) {
      const double centre = (box.centre_m[d] - origin[d]) / cell_width_m, half = box.half_m[d] / cell_width_m;
      cut_interval(centre - half, centre + half, slices[d]);
    }
    for (const Slice& z : slices[2]) {
      for (const Slice& y : slices[1]) {
        for (const Slice& x : slices[0]) {
          const double volume = box.volume_m3 * x.part * y.part * z.part;
          const Vector3d mean(x.mean, y.mean, z.mean);
          Moments& moments = filled[{z.cell, y.cell, x.cell}];
          moments.volume += volume;
          moments.first += volume * mean;
          moments.second += volume * Vector3d(x.mean_square, y.mean_square, z.mean_square);
          const std::array<double, 8> weights = trilinear_weights(mean);
          for (int c = 0; c < 8; ++c) moments.corner[c] += volume * weights[c];
          const Vector3d centre = extent.object_from_lattice *
                                  (origin + cell_width_m * (Vector3d(x.cell, y.cell, z.cell) +
                                                            0.5 * (mean + Vector3d::Ones())));
          for (const RestBox& region : fixed_regions) {
            if (!contains(region, centre, margin)) continue;
            moments.fixed_volume += volume;
            break;
          }
        }
      }
    }
  }

  Vector3i lowest = Vector3i::Constant(std::numeric_limits<int>::max());
  for (const auto& [key, moments] : filled) {
    lowest = lowest.cwiseMin(Vector3i(std::get<2>(key), std::get<1>(key), std::get<0>(key)));
  }

  Lattice lattice;
  lattice.cell_width_m = cell_width_m;
  lattice.object_from_lattice.orientation = extent.object_from_lattice;
  lattice.object_from_lattice.position_m =
      extent.object_from_lattice * (origin + cell_width_m * lowest.cast<double>());

  std::map<Key, double> node_volumes;
  for (const auto& [key, moments] : filled) {
    LatticeCell cell;
    cell.coordinates = Vector3i(std::get<2>(key), std::get<1>(key), std::get<0>(key)) - lowest;
    cell.volume_m3 = moments.volume;
    cell.centroid = moments.first / moments.volume;
    // The variance of a local coordinate over a full cell is 1/3.
    cell.spread = 3.0 * (moments.second / moments.volume - cell.centroid.cwiseAbs2()).cwiseMax(0.0);
    cell.fixed = moments.fixed_volume > 0.999 * moments.volume;
    lattice.cells.push_back(cell);
    for (int c = 0; c < 8; ++c) {
      node_volumes[key_of(cell.coordinates + Vector3i(c & 1, c >> 1 & 1, c >> 2))] += moments.corner[c];
    }
  }
  std::sort(lattice.cells.begin(), lattice.cells.end(),
            [](const auto& a, const auto& b) { return cell_order(a) < cell_order(b); });

  double total = 0.0, floored_total = 0.0;
  const double floor_m3 = kLightestNode * cell_width_m * cell_width_m * cell_width_m;
  std::map<Key, uint32_t> node_indices;
  for (const auto& [key, volume] : node_volumes) {
    node_indices[key] = static_cast<uint32_t>(lattice.node_coordinates.size());
    lattice.node_coordinates.emplace_back(std::get<2>(key), std::get<1>(key), std::get<0>(key));
    lattice.node_volumes_m3.push_back(std::max(volume, floor_m3));
    total += volume;
    floored_total += lattice.node_volumes_m3.back();
  }
  for (double& volume : lattice.node_volumes_m3) volume *= total / floored_total;

  for (size_t i = 0; i < lattice.cells.size(); ++i) {
    LatticeCell& cell = lattice.cells[i];
    for (int c = 0; c < 8; ++c) {
      cell.nodes[c] = node_indices[key_of(cell.coordinates + Vector3i(c & 1, c >> 1 & 1, c >> 2))];
    }
    ++lattice.colour_begin[colour_of(cell.coordinates) + 1];
  }
  for (int colour = 0; colour < 8; ++colour) lattice.colour_begin[colour + 1] += lattice.colour_begin[colour];
  return lattice;
}

}  // namespace livegs
