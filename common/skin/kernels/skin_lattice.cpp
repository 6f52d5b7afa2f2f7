// SPDX-License-Identifier: Apache-2.0
// Each kernel is embedded in a trilinear cell. The gradient of a node along an axis is the mean over the
// adjacent cells of the trilinear gradient at the corner of the node, that is, the cell edge from the corner
// along the axis. All cells have the same volume, so the volume-weighted mean is the plain mean.
//
// This gives central differences inside a body, one-sided differences on its surface, and the exact gradient
// of the trilinear map in a body one cell thick. Interpolation over a face uses only the nodes of the face,
// which both cells share, so there is no seam.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <tuple>

#include "core/assert.h"
#include "core/parallel_for.h"
#include "skin/kernels/cell_fill.h"
#include "skin/kernels/driver_skinning.h"
#include "skin/kernels/lattice_skinning.h"
#include "skin/kernels/nearest_cubes.h"

namespace livegs {
namespace {

constexpr size_t kNodeBlock = 512;

// Cells that are compared to find the nearest material of a kernel: those around a cell, and more if parts of
// the object have separate cells at the same place.
constexpr size_t kCellsConsidered = 48;

Result<void> check_lattice(const RestBody& rest) {
  if (rest.cells.empty()) return invalid_argument("rest body: a lattice needs at least one cell");
  if (!std::isfinite(rest.cell_width_m) || rest.cell_width_m <= 0.0) {
    return invalid_argument("rest body: cell_width_m must be positive");
  }
  if (!rest.object_from_lattice.position_m.allFinite() ||
      !rest.object_from_lattice.orientation.coeffs().allFinite()) {
    return invalid_argument("rest body: object_from_lattice is not finite");
  }
  if (!rest.cell_fills.empty() && rest.cell_fills.size() != rest.cells.size()) {
    return invalid_argument("rest body: " + std::to_string(rest.cell_fills.size()) + " fills of " +
                            std::to_string(rest.cells.size()) + " cells");
  }
  for (size_t i = 0; i < rest.cells.size(); ++i) {
    for (int corner = 0; corner < 8; ++corner) {
      const uint32_t node = rest.cells[i][corner];
      if (node >= rest.node_coordinates.size()) {
        return invalid_argument("rest body: cell " + std::to_string(i) + " refers to node " +
                                std::to_string(node) + " of " + std::to_string(rest.node_coordinates.size()));
      }
      for (int d = 0; d < 3; ++d) {
        const int64_t step =
            int64_t{rest.node_coordinates[node][d]} - rest.node_coordinates[rest.cells[i][0]][d];
        if (step != ((corner >> d) & 1)) {
          return invalid_argument("rest body: corner " + std::to_string(corner) + " of cell " +
                                  std::to_string(i) + " is not the node at its place");
        }
      }
    }
  }
  return {};
}

void bind_node_gradients(const RestBody& rest, KernelBindings& bindings) {
  // node, axis, neighbour, neighbour is at -axis
  using Edge = std::tuple<uint32_t, uint32_t, uint32_t, bool>;
  std::vector<Edge> edges;
  edges.reserve(rest.cells.size() * 24);
  std::vector<uint32_t> cells_around(rest.node_coordinates.size(), 0);
  for (const std::array<uint32_t, 8>& cell : rest.cells) {
    for (uint32_t corner = 0; corner < 8; ++corner) {
      ++cells_around[cell[corner]];
      for (uint32_t axis = 0; axis < 3; ++axis) {
        edges.emplace_back(cell[corner], axis, cell[corner ^ (1u << axis)], ((corner >> axis) & 1u) != 0);
      }
    }
  }
  std::sort(edges.begin(), edges.end());
  bindings.node_terms.clear();
  bindings.node_terms_begin.assign(1, 0);
  bindings.node_terms_begin.reserve(rest.node_coordinates.size() + 1);
  auto edge = edges.begin();
  for (uint32_t node = 0; node < rest.node_coordinates.size(); ++node) {
    while (edge != edges.end() && std::get<0>(*edge) == node) {
      const auto [unused, axis, neighbour, backward] = *edge;
      const auto last = std::find_if(edge, edges.end(), [&](const Edge& other) { return other != *edge; });
      const double share = static_cast<double>(last - edge) / cells_around[node];
      const double weight_per_m = (backward ? -share : share) / rest.cell_width_m;
      bindings.node_terms.push_back({neighbour, axis, static_cast<float>(weight_per_m)});
      edge = last;
    }
    bindings.node_terms_begin.push_back(static_cast<uint32_t>(bindings.node_terms.size()));
  }
}

// Mean deformation of the body over its nodes, each counted once per cell, as a mass weighting would.
Eigen::Matrix3f mean_gradient(const RestBody& rest, std::span<const NodeState> states) {
  Eigen::Array<double, 8, 1> x = Eigen::Array<double, 8, 1>::Zero(), yz = x;
  for (const std::array<uint32_t, 8>& cell : rest.cells) {
    for (const uint32_t node : cell) {
      x += states[node].position_and_x.cast<double>();
      yz += states[node].y_and_z.cast<double>();
    }
  }
  Eigen::Matrix3d mean;
  mean << x[4], yz[0], yz[4], x[5], yz[1], yz[5], x[6], yz[2], yz[6];
  return (mean / (8.0 * static_cast<double>(rest.cells.size()))).cast<float>();
}

uint32_t cell_of_nearest_material(const RestBody& rest, const std::vector<Eigen::Vector3f>& centres,
                                  std::span<const NearestCubes::Neighbour> candidates,
                                  const Eigen::Vector3f& point) {
  uint32_t best = candidates[0].index;
  FillDistance least;
  for (size_t i = 0; i < candidates.size(); ++i) {
    const uint32_t cell = candidates[i].index;
    const Eigen::Vector3f in_cell = point - centres[cell] + Eigen::Vector3f::Constant(0.5f);
    const FillDistance distance = fill_distance(rest.cell_fills[cell], in_cell);
    if (i > 0 && !(distance < least)) continue;
    least = distance;
    best = cell;
  }
  return best;
}

Eigen::Array3f local_of(const KernelBinding& binding) {
  return {binding.weights[0], binding.weights[1], binding.weights[2]};
}

// The state at local coordinates `at` of a cell, trilinear. Precondition: 0 <= at <= 1.
NodeState interpolate(std::span<const NodeState> states, const std::array<uint32_t, 8>& cell,
                      const Eigen::Array3f& at) {
  const float x[2] = {1.0f - at[0], at[0]};
  const float yz[4] = {(1.0f - at[1]) * (1.0f - at[2]), at[1] * (1.0f - at[2]), (1.0f - at[1]) * at[2],
                       at[1] * at[2]};
  NodeState sum{Eigen::Array<float, 8, 1>::Zero(), Eigen::Array<float, 8, 1>::Zero()};
  for (int corner = 0; corner < 8; ++corner) {
    const float weight = x[corner & 1] * yz[corner >> 1];
    sum.position_and_x += weight * states[cell[corner]].position_and_x;
    sum.y_and_z += weight * states[cell[corner]].y_and_z;
  }
  return sum;
}

}  // namespace

Result<void> bind_lattice(const RestKernels& kernels, const RestBody& rest, KernelBindings& bindings) {
  if (Result<void> checked = check_lattice(rest); !checked) return checked.error();
  bind_node_gradients(rest, bindings);

  // In cell units relative to the first cell: the numbers are small, so float is precise enough for the
  // search.
  const Eigen::Vector3d origin = rest.node_coordinates[rest.cells[0][0]].cast<double>();
  std::vector<Eigen::Vector3f> centres;
  centres.reserve(rest.cells.size());
  for (const std::array<uint32_t, 8>& cell : rest.cells) {
    const Eigen::Vector3d corner = rest.node_coordinates[cell[0]].cast<double>();
    centres.push_back((corner - origin + Eigen::Vector3d::Constant(0.5)).cast<float>());
  }
  const NearestCubes cells(centres, 0.5f);
  const Pose lattice_from_object = rest.object_from_lattice.inverse();
  const Eigen::Matrix3f turn = lattice_from_object.orientation.toRotationMatrix().cast<float>();

  parallel_for(kernels.positions_m.size(), kSkinBlock, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      const Eigen::Vector3d in_cells = (lattice_from_object * kernels.positions_m[k]) / rest.cell_width_m;
      const Eigen::Vector3f point = (in_cells - origin).cast<float>();
      std::array<NearestCubes::Neighbour, kCellsConsidered> nearest;
      const size_t considered = rest.cell_fills.empty() ? 1 : nearest.size();
      const size_t found = cells.find(point, std::span(nearest).first(considered));
      uint32_t cell = nearest[0].index;
      if (!rest.cell_fills.empty())
        cell = cell_of_nearest_material(rest, centres, std::span(nearest).first(found), point);
      const Eigen::Vector3d corner = rest.node_coordinates[rest.cells[cell][0]].cast<double>();
      KernelBinding& binding = bindings.kernels[k];
      binding.drivers[0] = cell;
      for (int d = 0; d < 3; ++d) binding.weights[d] = static_cast<float>(in_cells[d] - corner[d]);
      bindings.rest_covariances_m2[k] = transformed(turn, symmetric_of(kernels.covariances_m2[k]));
    }
  });
  return {};
}

std::vector<NodeState> node_states(const KernelBindings& bindings,
                                   const std::vector<Eigen::Vector3f>& positions_m) {
  std::vector<NodeState> states(positions_m.size());
  parallel_for(states.size(), kNodeBlock, [&](size_t begin, size_t end) {
    for (size_t n = begin; n < end; ++n) {
      Eigen::Matrix3f gradient = Eigen::Matrix3f::Zero();
      for (uint32_t t = bindings.node_terms_begin[n]; t < bindings.node_terms_begin[n + 1]; ++t) {
        const NodeGradientTerm& term = bindings.node_terms[t];
        gradient.col(term.axis) += term.weight_per_m * (positions_m[term.neighbour] - positions_m[n]);
      }
      const Eigen::Vector3f& x = positions_m[n];
      states[n].position_and_x << x[0], x[1], x[2], 0, gradient(0, 0), gradient(1, 0), gradient(2, 0), 0;
      states[n].y_and_z << gradient(0, 1), gradient(1, 1), gradient(2, 1), 0, gradient(0, 2), gradient(1, 2),
          gradient(2, 2), 0;
    }
  });
  return states;
}

LatticeBody lattice_body_of(const RestBody& rest, std::span<const NodeState> states) {
  LimitedDeformations whole_body;
  whole_body.gradients.fill(mean_gradient(rest, states));
  limit_deformations(whole_body);
  const Eigen::Quaterniond lattice_from_object = rest.object_from_lattice.orientation.conjugate();
  return {whole_body.gradients[0],
          (lattice_from_object * rest.object_from_asset.rotation).normalized().cast<float>(),
          static_cast<float>(rest.cell_width_m)};
}

void move_beyond_cell(const Eigen::Array3f& beyond, const Eigen::Matrix3f& gradient, const LatticeBody& body,
                      Eigen::Vector3f& position_m) {
  const Eigen::Vector3f offset = (beyond * body.cell_width_m).matrix();
  const float near_share = std::min(1.0f, body.cell_width_m / offset.norm());
  position_m += gradient * (near_share * offset) + body.gradient * ((1.0f - near_share) * offset);
}

void skin_lanes(std::span<const NodeState> states, std::span<const std::array<uint32_t, 8>> cells,
                const LatticeBody& body, LatticeLanes& lanes, size_t count) {
  lanes.deformations.gradients.fill(Eigen::Matrix3f::Identity());
  for (size_t lane = 0; lane < count; ++lane) {
    const NodeState here =
        interpolate(states, cells[lanes.cells[lane]], lanes.local[lane].max(0.0f).min(1.0f));
    const Eigen::Array<float, 8, 1>&x = here.position_and_x, &yz = here.y_and_z;
    lanes.positions_m[lane] << x[0], x[1], x[2];
    lanes.deformations.gradients[lane] << x[4], yz[0], yz[4], x[5], yz[1], yz[5], x[6], yz[2], yz[6];
  }
  limit_deformations(lanes.deformations);
  for (size_t lane = 0; lane < count; ++lane) {
    const Eigen::Matrix3f& gradient = lanes.deformations.gradients[lane];
    const Eigen::Array3f local = lanes.local[lane];
    const Eigen::Array3f beyond = local - local.max(0.0f).min(1.0f);
    if ((beyond != 0.0f).any()) move_beyond_cell(beyond, gradient, body, lanes.positions_m[lane]);
    lanes.covariances_m2[lane] = transformed(gradient, lanes.rest_covariances_m2[lane]);
    lanes.world_from_asset[lane] = lanes.deformations.rotations[lane] * body.lattice_from_asset;
  }
}

void skin_lattice(const RestBody& rest, const KernelBindings& bindings, const ObjectDrivers& drivers,
                  PosedKernels& kernels, std::vector<Eigen::Matrix3f>* deformation_gradients) {
  LIVEGS_ASSERT(drivers.positions_m.size() == rest.node_coordinates.size());
  LIVEGS_ASSERT(bindings.node_terms_begin.size() == rest.node_coordinates.size() + 1);
  const std::vector<NodeState> states = node_states(bindings, drivers.positions_m);
  const LatticeBody body = lattice_body_of(rest, states);
  const Eigen::Matrix3f lattice_from_object =
      rest.object_from_lattice.orientation.conjugate().toRotationMatrix().cast<float>();

  parallel_for(bindings.kernels.size(), kSkinBlock, [&](size_t begin, size_t end) {
    LatticeLanes lanes;
    // Groups are counted from the start of the block, so the lane of a kernel does not depend on the number
    // of threads.
    for (size_t group = begin; group < end; group += kDeformationLanes) {
      const size_t count = std::min<size_t>(kDeformationLanes, end - group);
      for (size_t lane = 0; lane < count; ++lane) {
        lanes.cells[lane] = bindings.kernels[group + lane].drivers[0];
        lanes.local[lane] = local_of(bindings.kernels[group + lane]);
        lanes.rest_covariances_m2[lane] = bindings.rest_covariances_m2[group + lane];
      }
      skin_lanes(states, rest.cells, body, lanes, count);
      for (size_t lane = 0; lane < count; ++lane) {
        const size_t k = group + lane;
        kernels.positions_m[k] = lanes.positions_m[lane];
        kernels.covariances_m2[k] = lanes.covariances_m2[lane];
        kernels.world_from_asset[k] = lanes.world_from_asset[lane];
        if (deformation_gradients)
          (*deformation_gradients)[k] = lanes.deformations.gradients[lane] * lattice_from_object;
      }
    }
  });
}

}  // namespace livegs
