// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "skin/kernels/skin_rigid_layout.h"

namespace livegs {

// CPU function of main() in skin_rigid.comp.glsl.
inline PosedKernelRow skin_rigid_row(const RestKernelRow& kernel, const RigidPoseRow& p) {
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

}  // namespace livegs
