// SPDX-License-Identifier: Apache-2.0
#include "skin/passes/skin_rigid_pass.h"

#include <algorithm>

#include "compute/pass_rows.h"
#include "core/assert.h"
#include "skin/kernels/skin_rigid_row.h"
#include "skin_rigid.spv.h"

namespace livegs {
namespace {

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
    set_row(arguments.buffers[2], i,
            skin_rigid_row(kernel, row_at<RigidPoseRow>(arguments.buffers[1], body)));
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
