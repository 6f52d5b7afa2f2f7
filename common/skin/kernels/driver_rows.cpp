// SPDX-License-Identifier: Apache-2.0
#include "skin/driver_rows.h"

#include <algorithm>
#include <array>

#include "core/assert.h"
#include "core/parallel_for.h"
#include "skin/kernels/driver_skinning.h"
#include "skin/kernels/skin_rigid_row.h"

namespace livegs {
namespace {

// Kernels outside of their cells follow the deformation there, which is limited lane by lane: they are
// gathered into full groups. A kernel inside of its cell needs only the positions of its nodes.
class OutsideKernels {
 public:
  OutsideKernels(const RestBody& rest, const DriverRows& rows, std::vector<Eigen::Vector3f>& positions_m)
      : rest_(rest), rows_(rows), positions_m_(positions_m) {
    lanes_.rest_covariances_m2.fill(Symmetric3f{});
  }
  void add(size_t kernel, const KernelBinding& binding) {
    lanes_.cells[count_] = binding.drivers[0];
    lanes_.local[count_] = {binding.weights[0], binding.weights[1], binding.weights[2]};
    kernels_[count_] = kernel;
    if (++count_ == kernels_.size()) skin();
  }
  void skin() {
    skin_lanes(rows_.nodes, rest_.cells, rows_.lattice, lanes_, count_);
    for (size_t lane = 0; lane < count_; ++lane) positions_m_[kernels_[lane]] = lanes_.positions_m[lane];
    count_ = 0;
  }

 private:
  const RestBody& rest_;
  const DriverRows& rows_;
  std::vector<Eigen::Vector3f>& positions_m_;
  LatticeLanes lanes_;
  std::array<size_t, kDeformationLanes> kernels_{};
  size_t count_ = 0;
};

bool is_inside(const KernelBinding& binding) {
  return std::all_of(binding.weights.begin(), binding.weights.begin() + 3,
                     [](float x) { return x >= 0.0f && x <= 1.0f; });
}

// As interpolate() of skin_lattice.cpp, for the first four lanes.
Eigen::Array4f position_in(const std::array<uint32_t, 8>& cell, std::span<const NodeState> nodes,
                           const KernelBinding& binding) {
  const auto& at = binding.weights;
  const float x[2] = {1.0f - at[0], at[0]};
  const float yz[4] = {(1.0f - at[1]) * (1.0f - at[2]), at[1] * (1.0f - at[2]), (1.0f - at[1]) * at[2],
                       at[1] * at[2]};
  Eigen::Array4f sum = Eigen::Array4f::Zero();
  for (int corner = 0; corner < 8; ++corner)
    sum += (x[corner & 1] * yz[corner >> 1]) * nodes[cell[corner]].position_and_x.head<4>();
  return sum;
}

}  // namespace

void pack_rest_rows(const KernelBindings& bindings, std::span<const uint32_t> kept, size_t first,
                    std::span<RestKernelRow> rows) {
  parallel_for(rows.size(), kSkinBlock, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const size_t k = kept.empty() ? first + i : kept[first + i];
      const KernelBinding& binding = bindings.kernels[k];
      const Symmetric3f& s = bindings.rest_covariances_m2[k];
      rows[i] = {binding.drivers[0],
                 binding.weights[0],
                 binding.weights[1],
                 binding.weights[2],
                 s[0],
                 s[1],
                 s[2],
                 s[3],
                 s[4],
                 s[5]};
      if (bindings.kind == DriverKind::Rigid) {
        const Eigen::Vector3f& x = bindings.rest_positions_m[k];
        rows[i].at_x = x.x();
        rows[i].at_y = x.y();
        rows[i].at_z = x.z();
      }
    }
  });
}

DriverRows pack_driver_rows(const RestBody& rest, const KernelBindings& bindings,
                            const ObjectDrivers& drivers) {
  LIVEGS_ASSERT(rest.kind == drivers.kind && rest.kind != DriverKind::Particles);
  DriverRows rows;
  if (rest.kind == DriverKind::Lattice) {
    LIVEGS_ASSERT(drivers.positions_m.size() == rest.node_coordinates.size());
    rows.nodes = node_states(bindings, drivers.positions_m);
    rows.lattice = lattice_body_of(rest, rows.nodes);
    return rows;
  }
  const std::vector<TurnedBody> bodies = turned_bodies(rest, drivers);
  rows.bodies.reserve(bodies.size());
  for (const TurnedBody& body : bodies) {
    const Eigen::Matrix3f& r = body.world_from_body;
    const Eigen::Vector3f& x = body.position_m;
    const Eigen::Quaternionf& q = body.world_from_asset;
    rows.bodies.push_back({r(0, 0), r(0, 1), r(0, 2), x.x(), r(1, 0), r(1, 1), r(1, 2), x.y(), r(2, 0),
                           r(2, 1), r(2, 2), x.z(), q.x(), q.y(), q.z(), q.w()});
  }
  return rows;
}

void skin_positions(const RestBody& rest, const KernelBindings& bindings, const DriverRows& rows,
                    std::vector<Eigen::Vector3f>& positions_m) {
  positions_m.resize(bindings.kernels.size());
  parallel_for(positions_m.size(), kSkinBlock, [&](size_t begin, size_t end) {
    if (rest.kind == DriverKind::Rigid) {
      for (size_t k = begin; k < end; ++k) {
        const Eigen::Vector3f& x = bindings.rest_positions_m[k];
        const PosedKernelRow posed = skin_rigid_row({0, x.x(), x.y(), x.z(), 0, 0, 0, 0, 0, 0},
                                                    rows.bodies[bindings.kernels[k].drivers[0]]);
        positions_m[k] = {posed.x_m, posed.y_m, posed.z_m};
      }
      return;
    }
    OutsideKernels outside(rest, rows, positions_m);
    for (size_t k = begin; k < end; ++k) {
      const KernelBinding& binding = bindings.kernels[k];
      if (is_inside(binding))
        positions_m[k] = position_in(rest.cells[binding.drivers[0]], rows.nodes, binding).head<3>().matrix();
      else
        outside.add(k, binding);
    }
    outside.skin();
  });
}

}  // namespace livegs
