// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

// Classification of visibly deformable bodies by their effective stiffness E* = s E (structure coefficient
// times Young's modulus).

namespace livegs {

// Pa. Above it every body is rigid (LIVE-GS's own limit). If increased, more bodies are elastic, which is not
// visible and costs substeps.
inline constexpr double kRigidStiffness_pa = 200e6;
// Pa. Between this and kRigidStiffness_pa only soft materials are elastic; other bodies do not bend visibly
// by hand.
inline constexpr double kStiffStiffness_pa = 20e6;
// Pa. Below it every body deforms by hand. An answer that calls such a body rigid is refused.
inline constexpr double kSoftStiffness_pa = 1e6;

// Takes MaterialRow::material_class.
inline bool is_soft_class(std::string_view material_class) {
  for (const char* soft : {"elastomer", "foam", "textile", "stuffed", "plant", "food"}) {
    if (material_class == soft) return true;
  }
  return false;
}

}  // namespace livegs
