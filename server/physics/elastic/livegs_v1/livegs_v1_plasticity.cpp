// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/livegs_v1/livegs_v1_plasticity.h"

#include <Eigen/LU>

namespace livegs {

bool creep_plastically(const Eigen::Matrix3d& stretch, double plasticity, Eigen::Matrix3d& plastic_part) {
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d strain = stretch - identity;
  if (!(plasticity > 0.0) || !(strain.norm() > 1.0 - plasticity)) return false;
  Eigen::Matrix3d crept = (identity + plasticity * strain) * plastic_part;
  const double size = (crept - identity).norm();
  if (size > plasticity) crept = identity + plasticity / size * (crept - identity);
  if (!(crept.determinant() > 1e-3)) return false;
  plastic_part = crept;
  return true;
}

}  // namespace livegs
