// SPDX-License-Identifier: Apache-2.0
#include "skin/driver_rows.h"

#include "core/assert.h"
#include "core/parallel_for.h"
#include "skin/kernels/driver_skinning.h"

namespace livegs {
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

}  // namespace livegs
