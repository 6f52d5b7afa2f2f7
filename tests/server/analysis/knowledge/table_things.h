// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "analysis/estimate.h"
#include "analysis/knowledge/tables.h"
#include "server/analysis/gate/answer_fixtures.h"

// A typical object of a row of objects.csv as captured, and the matching answer.

namespace livegs {

// Knud Thomsen's formula, within 1.1 %.
inline double ellipsoid_area_m2(const Eigen::Vector3d& size_m) {
  constexpr double p = 1.6075;
  const Eigen::Vector3d half = 0.5 * size_m;
  const double sum =
      std::pow(half[0] * half[1], p) + std::pow(half[1] * half[2], p) + std::pow(half[2] * half[0], p);
  return 4 * EIGEN_PI * std::pow(sum / 3, 1 / p);
}

inline double box_area_m2(const Eigen::Vector3d& size_m) {
  return 2 * (size_m[0] * size_m[1] + size_m[1] * size_m[2] + size_m[2] * size_m[0]);
}

inline MeshFacts mesh_of_row(const ObjectRow& row) {
  MeshFacts mesh;
  const Eigen::Vector3d size_m(row.size_m.best, row.middle_m, row.short_m);
  mesh.size_m = mesh.box_m = mesh.principal_size_m = size_m;
  mesh.volume_m3 = row.box_filling * size_m.prod();
  mesh.hull_volume_m3 = size_m.prod() * std::max(row.box_filling, 0.5);
  mesh.solidity = mesh.volume_m3 / mesh.hull_volume_m3;
  mesh.area_m2 = box_area_m2(size_m);
  mesh.mean_wall_m = 2 * mesh.volume_m3 / mesh.area_m2;
  mesh.piece_count = 1;
  return mesh;
}

inline ObjectFacts facts_of_row(const ObjectRow& row, const std::string& name) {
  ObjectFacts facts;
  facts.name = name;
  facts.scale_known = true;
  facts.mesh = mesh_of_row(row);
  return facts;
}

inline const char* fill_word(v1::Physics::Fill fill) {
  return fill == v1::Physics::SOLID        ? "solid"
         : fill == v1::Physics::SHELL      ? "shell"
         : fill == v1::Physics::OPEN_SHELL ? "open_shell"
                                           : "filled";
}

inline nlohmann::json all_of(const std::string& material) {
  return nlohmann::json::array(
      {{{"name", "all"}, {"material_id", material}, {"share", 1}, {"thickness_mm", nullptr}}});
}

// `mass_g`: a number or a range.
inline nlohmann::json answer_of_row(const ObjectRow& row, v1::Physics::Behavior behavior,
                                    const nlohmann::json& mass_g) {
  nlohmann::json answer = mug_answer();
  answer["name"] = row.label;
  answer["parts"] = all_of(row.material);
  answer["fill"] = fill_word(row.fill);
  answer["behaviour"] = behavior == v1::Physics::RIGID ? "rigid" : "elastic";
  answer["fragile"] = material_row(row.material).fragile;
  answer["young_mpa"] = answer["structure_s"] = answer["plasticity"] = nullptr;
  if (behavior != v1::Physics::RIGID) answer["structure_s"] = row.structure_coefficient.best;
  answer["mass_g"] = mass_g;
  return answer;
}

}  // namespace livegs
