// SPDX-License-Identifier: Apache-2.0
#include "skin/pose_rigid_kernels.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "core/assert.h"
#include "pose_rigid_kernels.spv.h"

namespace livegs {

namespace {

// The twin of main() in pose_rigid_kernels.comp.glsl.
RigidKernelRow posed_row(const RigidKernelRow& kernel, const RigidPoseRows& p) {
  const float r[3][3] = {{p.r00, p.r01, p.r02}, {p.r10, p.r11, p.r12}, {p.r20, p.r21, p.r22}};
  const float s[3][3] = {{kernel.sxx_m2, kernel.sxy_m2, kernel.sxz_m2},
                         {kernel.sxy_m2, kernel.syy_m2, kernel.syz_m2},
                         {kernel.sxz_m2, kernel.syz_m2, kernel.szz_m2}};
  const auto turned = [&](int i) {
    return r[i][0] * kernel.x_m + r[i][1] * kernel.y_m + r[i][2] * kernel.z_m;
  };
  float rs[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) rs[i][j] = r[i][0] * s[0][j] + r[i][1] * s[1][j] + r[i][2] * s[2][j];
  }
  const auto entry = [&](int i, int j) {
    return rs[i][0] * r[j][0] + rs[i][1] * r[j][1] + rs[i][2] * r[j][2];
  };
  return {turned(0) + p.x_m, turned(1) + p.y_m, turned(2) + p.z_m, kernel.body, entry(0, 0), entry(0, 1),
          entry(0, 2),       entry(1, 1),       entry(1, 2),       entry(2, 2), 0.0f,        0.0f};
}

// Rows of a buffer; the bytes of one are read and written by memcpy, which the compiler turns into plain
// moves.
template <class Row>
Row row_at(std::span<const std::byte> buffer, size_t index) {
  Row row;
  std::memcpy(&row, buffer.data() + index * sizeof(Row), sizeof(Row));
  return row;
}

void pose_rigid_kernels(const PassArguments& arguments, size_t begin, size_t end) {
  const auto constants = row_at<PoseRigidKernelsConstants>(arguments.constants, 0);
  end = std::min<size_t>(end, constants.kernel_count);
  LIVEGS_ASSERT(end * sizeof(RigidKernelRow) <= arguments.buffers[0].size());
  LIVEGS_ASSERT(constants.body_count * sizeof(RigidPoseRows) <= arguments.buffers[1].size());
  LIVEGS_ASSERT(end * sizeof(RigidKernelRow) <= arguments.buffers[2].size());
  for (size_t k = begin; k < end; ++k) {
    const auto kernel = row_at<RigidKernelRow>(arguments.buffers[0], k);
    const uint32_t body = std::min(kernel.body, constants.body_count - 1);
    const RigidKernelRow posed = posed_row(kernel, row_at<RigidPoseRows>(arguments.buffers[1], body));
    std::memcpy(arguments.buffers[2].data() + k * sizeof(posed), &posed, sizeof(posed));
  }
}

}  // namespace

const Pass& pose_rigid_kernels_pass() {
  static const Pass pass{.name = "pose_rigid_kernels",
                         .group_size = 64,
                         .buffer_count = 3,
                         .constants_bytes = sizeof(PoseRigidKernelsConstants),
                         .spirv = pose_rigid_kernels_spirv,
                         .run = pose_rigid_kernels};
  return pass;
}

Result<void> dispatch_pose_rigid_kernels(Backend& backend, const PoseRigidKernels& work) {
  if (work.body_count == 0)
    return invalid_argument("pass pose_rigid_kernels: no bodies; it needs at least one");
  const PoseRigidKernelsConstants constants{work.kernel_count, work.body_count};
  const std::array buffers{work.rest, work.poses, work.posed};
  return backend.dispatch(pose_rigid_kernels_pass(), buffers, std::as_bytes(std::span(&constants, 1)),
                          work.kernel_count);
}

}  // namespace livegs
