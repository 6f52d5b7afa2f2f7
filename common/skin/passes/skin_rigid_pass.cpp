// SPDX-License-Identifier: Apache-2.0
#include "skin/passes/skin_rigid_pass.h"

#include <algorithm>

#include "compute/pass_rows.h"
#include "core/assert.h"
#include "skin_rigid.spv.h"

namespace livegs {
namespace {

// CPU twin of main() in skin_rigid.comp.glsl.
PosedKernelRow posed_row(const RestKernelRow& kernel, const RigidPoseRow& p) {
  const float r[3][3] = {{p.r00, p.r01, p.r02}, {p.r10, p.r11, p.r12}, {p.r20, p.r21, p.r22}};
  const float s[3][3] = {{kernel.sxx_m2, kernel.sxy_m2, kernel.sxz_m2},
                         {kernel.sxy_m2, kernel.syy_m2, kernel.syz_m2},
                         {kernel.sxz_m2, kernel.syz_m2, kernel.szz_m2}};
  const auto turned = [&](int i) {
    return r[i][0] * kernel.at_x + r[i][1] * kernel.at_y + r[i][2] * kernel.at_z;
  };
  float rs[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) rs[i][j] = r[i][0] * s[0][j] + r[i][1] * s[1][j] + r[i][2] * s[2][j];
  }
  const auto entry = [&](int i, int j) {
    return rs[i][0] * r[j][0] + rs[i][1] * r[j][1] + rs[i][2] * r[j][2];
  };
  return {turned(0) + p.x_m,
          turned(1) + p.y_m,
          turned(2) + p.z_m,
          entry(0, 0),
          entry(0, 1),
          entry(0, 2),
          entry(1, 1),
          entry(1, 2),
          entry(2, 2),
          p.qx,
          p.qy,
          p.qz,
          p.qw};
}

void skin_rigid_rows(const PassArguments& arguments, size_t begin, size_t end) {
  const auto constants = row_at<SkinRigidConstants>(arguments.constants, 0);
  end = std::min<size_t>(end, constants.kernel_count);
  LIVEGS_ASSERT(constants.body_count > 0);
  LIVEGS_ASSERT((constants.first_kernel + end) * sizeof(RestKernelRow) <= arguments.buffers[0].size());
  LIVEGS_ASSERT(constants.body_count * sizeof(RigidPoseRow) <= arguments.buffers[1].size());
  LIVEGS_ASSERT(end * sizeof(PosedKernelRow) <= arguments.buffers[2].size());
  for (size_t i = begin; i < end; ++i) {
    const auto kernel = row_at<RestKernelRow>(arguments.buffers[0], constants.first_kernel + i);
    const uint32_t body = std::min(kernel.driver, constants.body_count - 1);
    set_row(arguments.buffers[2], i, posed_row(kernel, row_at<RigidPoseRow>(arguments.buffers[1], body)));
  }
}

}  // namespace

const Pass& skin_rigid_pass() {
  static const Pass pass{.name = "skin_rigid",
                         .group_size = 64,
                         .buffer_count = 3,
                         .constants_bytes = sizeof(SkinRigidConstants),
                         .spirv = skin_rigid_spirv,
                         .run = skin_rigid_rows};
  return pass;
}

}  // namespace livegs
