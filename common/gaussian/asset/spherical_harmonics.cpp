// SPDX-License-Identifier: Apache-2.0
// Sloan 2008, Stupid Spherical Harmonics Tricks, appendix A2; the signs are those of 3DGS files.
#include "gaussian/spherical_harmonics.h"

#include <algorithm>

namespace livegs {

void evaluate_sh_bands(const Eigen::Vector3f& direction, int degree, float* bands) {
  const float x = direction.x(), y = direction.y(), z = direction.z();
  if (degree < 1) return;
  bands[0] = -0.48860251f * y;
  bands[1] = 0.48860251f * z;
  bands[2] = -0.48860251f * x;
  if (degree < 2) return;
  const float xx = x * x, yy = y * y, zz = z * z;
  bands[3] = 1.09254843f * x * y;
  bands[4] = -1.09254843f * y * z;
  bands[5] = 0.31539157f * (2.0f * zz - xx - yy);
  bands[6] = -1.09254843f * x * z;
  bands[7] = 0.54627422f * (xx - yy);
  if (degree < 3) return;
  bands[8] = -0.59004359f * y * (3.0f * xx - yy);
  bands[9] = 2.89061144f * x * y * z;
  bands[10] = -0.45704580f * y * (4.0f * zz - xx - yy);
  bands[11] = 0.37317633f * z * (2.0f * zz - 3.0f * xx - 3.0f * yy);
  bands[12] = -0.45704580f * x * (4.0f * zz - xx - yy);
  bands[13] = 1.44530572f * z * (xx - yy);
  bands[14] = -0.59004359f * x * (xx - 3.0f * yy);
}

Eigen::Vector3f evaluate_sh_colour(const Eigen::Vector3f& dc, const Eigen::Vector3f* rest, int degree,
                                   const Eigen::Vector3f& direction) {
  float bands[15];
  evaluate_sh_bands(direction, degree, bands);
  Eigen::Vector3f sum = Eigen::Vector3f::Constant(0.5f) + kShDc * dc;
  const int count = (degree + 1) * (degree + 1) - 1;
  for (int k = 0; k < count; ++k) sum += bands[k] * rest[k];
  // This argument order maps NaN to 0.
  return {std::max(0.0f, sum.x()), std::max(0.0f, sum.y()), std::max(0.0f, sum.z())};
}

}  // namespace livegs
