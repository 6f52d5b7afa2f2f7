// SPDX-License-Identifier: Apache-2.0
#include "skin/passes/skin_lattice_pass.h"

#include <algorithm>

#include "compute/pass_rows.h"
#include "core/assert.h"
#include "skin/kernels/lattice_skinning.h"
#include "skin_lattice.spv.h"

namespace livegs {
namespace {

using NodeFloats = std::array<float, kLatticeNodeFloats>;
static_assert(sizeof(NodeFloats) == sizeof(NodeState));

NodeState state_of(const NodeFloats& floats) {
  return {Eigen::Map<const Eigen::Array<float, 8, 1>>(floats.data()),
          Eigen::Map<const Eigen::Array<float, 8, 1>>(floats.data() + 8)};
}

// CPU function of main() in skin_lattice.comp.glsl.
void skin_lattice_rows(const PassArguments& arguments, size_t begin, size_t end) {
  const auto constants = row_at<SkinLatticeConstants>(arguments.constants, 0);
  const auto& buffers = arguments.buffers;
  end = std::min<size_t>(end, constants.kernel_count);
  LIVEGS_ASSERT((constants.first_kernel + end) * sizeof(RestKernelRow) <= buffers[0].size());
  LIVEGS_ASSERT(constants.cell_count * sizeof(std::array<uint32_t, 8>) <= buffers[1].size());
  LIVEGS_ASSERT(constants.node_count * sizeof(NodeState) <= buffers[2].size());
  LIVEGS_ASSERT(end * sizeof(PosedKernelRow) <= buffers[3].size());
  LatticeBody body;
  body.gradient << constants.body_xx, constants.body_xy, constants.body_xz, constants.body_yx,
      constants.body_yy, constants.body_yz, constants.body_zx, constants.body_zy, constants.body_zz;
  body.lattice_from_asset = {constants.qw, constants.qx, constants.qy, constants.qz};
  body.cell_width_m = constants.cell_width_m;
  LatticeLanes lanes;
  std::array<std::array<uint32_t, 8>, kDeformationLanes> cells;
  std::array<NodeState, 8 * kDeformationLanes> nodes;
  for (size_t group = begin; group < end; group += kDeformationLanes) {
    const size_t count = std::min<size_t>(kDeformationLanes, end - group);
    for (uint32_t lane = 0; lane < count; ++lane) {
      const auto rest = row_at<RestKernelRow>(buffers[0], constants.first_kernel + group + lane);
      lanes.cells[lane] = lane;
      lanes.local[lane] = {rest.at_x, rest.at_y, rest.at_z};
      lanes.rest_covariances_m2[lane] = {rest.sxx_m2, rest.sxy_m2, rest.sxz_m2,
                                         rest.syy_m2, rest.syz_m2, rest.szz_m2};
      const auto corners =
          row_at<std::array<uint32_t, 8>>(buffers[1], std::min(rest.driver, constants.cell_count - 1));
      for (uint32_t corner = 0; corner < 8; ++corner) {
        cells[lane][corner] = 8 * lane + corner;
        nodes[8 * lane + corner] =
            state_of(row_at<NodeFloats>(buffers[2], std::min(corners[corner], constants.node_count - 1)));
      }
    }
    skin_lanes(nodes, cells, body, lanes, count);
    for (size_t lane = 0; lane < count; ++lane) {
      const Eigen::Vector3f& x = lanes.positions_m[lane];
      const Symmetric3f& s = lanes.covariances_m2[lane];
      const Eigen::Quaternionf& q = lanes.world_from_asset[lane];
      set_row(buffers[3], group + lane,
              PosedKernelRow{x.x(), x.y(), x.z(), s[0], s[1], s[2], s[3], s[4], s[5], q.x(), q.y(), q.z(),
                             q.w()});
    }
  }
}

}  // namespace

const Pass& skin_lattice_pass() {
  static const Pass pass{.name = "skin_lattice",
                         .group_size = 64,
                         .buffer_count = 4,
                         .constants_bytes = sizeof(SkinLatticeConstants),
                         .spirv = skin_lattice_spirv,
                         .run = skin_lattice_rows};
  return pass;
}

}  // namespace livegs
