// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

// Which bodies deform visibly, by their effective stiffness E* = s E (structure coefficient times Young's
// modulus).

namespace livegs {

// Pa. Above it every body is rigid (LIVE-GS's own limit). Larger: more bodies are elastic, which nobody sees
// and which cost substeps.
inline constexpr double kRigidStiffness_pa = 200e6;
// Pa. Between this and kRigidStiffness_pa only materials that are soft by nature are elastic: hands cannot
// bend the rest visibly.
inline constexpr double kStiffStiffness_pa = 20e6;
// Pa. Below it a hand deforms every body. An answer that calls such a body rigid is refused.
inline constexpr double kSoftStiffness_pa = 1e6;

// Of MaterialRow::material_class.
inline bool is_soft_class(std::string_view material_class) {
  for (const char* soft : {"elastomer", "foam", "textile", "stuffed", "plant", "food"}) {
    if (material_class == soft) return true;
  }
  return false;
}

}  // namespace livegs
