// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "analysis/estimate.h"

namespace livegs {

// One piece at a known scale; lengths and volumes of a closed mesh.
inline ObjectFacts facts_of(const char* name, const MeshFacts& mesh) {
  ObjectFacts facts;
  facts.name = name;
  facts.scale_known = true;
  facts.mesh = mesh;
  facts.mesh.piece_count = 1;
  return facts;
}

// A stoneware mug of 80 x 95 x 80 mm, captured inside and outside: 120 cm3 of material.
inline ObjectFacts mug_facts() {
  return facts_of("mug", {.size_m = {0.08, 0.095, 0.08},
                          .principal_size_m = {0.095, 0.08, 0.08},
                          .volume_m3 = 1.2e-4,
                          .area_m2 = 0.055,
                          .mean_wall_m = 4.4e-3,
                          .hull_volume_m3 = 4.7e-4,
                          .solidity = 0.25,
                          .openness = 0.6});
}

// A throw pillow of 40 x 12 x 40 cm.
inline ObjectFacts pillow_facts() {
  return facts_of("pillow", {.size_m = {0.4, 0.12, 0.4},
                             .principal_size_m = {0.4, 0.4, 0.12},
                             .volume_m3 = 0.011,
                             .area_m2 = 0.4,
                             .mean_wall_m = 0.055,
                             .hull_volume_m3 = 0.0115,
                             .solidity = 0.95});
}

// A kitchen sponge of 11 x 3 x 7 cm.
inline ObjectFacts sponge_facts() {
  return facts_of("sponge", {.size_m = {0.11, 0.03, 0.07},
                             .principal_size_m = {0.11, 0.07, 0.03},
                             .volume_m3 = 2e-4,
                             .area_m2 = 0.026,
                             .mean_wall_m = 0.03,
                             .hull_volume_m3 = 2.2e-4,
                             .solidity = 0.91});
}

// A tennis ball, named by its file.
inline ObjectFacts tennis_ball_facts() {
  return facts_of("056_tennis_ball", {.size_m = {0.066, 0.066, 0.066},
                                      .principal_size_m = {0.066, 0.066, 0.066},
                                      .volume_m3 = 1.5e-4,
                                      .area_m2 = 0.0137,
                                      .mean_wall_m = 0.06,
                                      .hull_volume_m3 = 1.5e-4,
                                      .solidity = 1});
}

inline nlohmann::json mug_answer() {
  return nlohmann::json::parse(R"({
    "description": "a glazed stoneware mug with a handle", "evidence": "glossy glaze, bare ring at the foot",
    "name": "coffee mug", "name_confidence": 0.95, "is_replica": false, "fill": "open_shell",
    "parts": [{"name": "body", "material_id": "stoneware", "share": 1.0, "thickness_mm": 4.5}],
    "behaviour": "rigid", "size_m": [0.08, 0.095, 0.08],
    "mass_g": {"low": 270, "best": 330, "high": 400},
    "young_mpa": {"low": 40000, "best": 60000, "high": 75000}, "structure_s": 1.0,
    "plasticity_level": "glass", "plasticity": 0.0, "fragile": true, "friction": 0.5, "restitution": 0.3,
    "confidence": 0.9, "kb_ids": ["stoneware"]})");
}

inline nlohmann::json with_fields(nlohmann::json answer, const nlohmann::json& fields) {
  answer.update(fields);
  return answer;
}

inline nlohmann::json sponge_answer() {
  return nlohmann::json::parse(R"({
    "description": "a yellow sponge", "evidence": "open pores", "name": "sponge", "name_confidence": 0.9,
    "is_replica": false, "fill": "solid",
    "parts": [{"name": "all", "material_id": "kitchen sponge", "share": 1, "thickness_mm": null}],
    "behaviour": "elastic", "size_m": [0.11, 0.03, 0.07], "mass_g": {"low": 5, "best": 7, "high": 11},
    "young_mpa": {"low": 0.03, "best": 0.05, "high": 0.1}, "structure_s": 1, "plasticity_level": "rubber",
    "plasticity": 0.1, "fragile": false, "friction": 0.6, "restitution": 0.2, "confidence": 0.8, "kb_ids": []})");
}

inline nlohmann::json pillow_answer() {
  return nlohmann::json::parse(R"({
    "description": "a soft cushion", "evidence": "cotton cover, plump seams", "name": "throw pillow",
    "name_confidence": 0.9, "is_replica": false, "fill": "solid",
    "parts": [{"name": "filling", "material_id": "fibre fill", "share": 0.8, "thickness_mm": null},
              {"name": "cover", "material_id": "cotton fabric", "share": 0.2, "thickness_mm": 0.5}],
    "behaviour": "elastic", "size_m": [0.4, 0.12, 0.4], "mass_g": {"low": 300, "best": 450, "high": 700},
    "young_mpa": {"low": 0.01, "best": 0.02, "high": 0.05}, "structure_s": 0.5, "plasticity_level": "foam",
    "plasticity": 0.1, "fragile": false, "friction": 0.6, "restitution": 0.1, "confidence": 0.8, "kb_ids": []})");
}

}  // namespace livegs
