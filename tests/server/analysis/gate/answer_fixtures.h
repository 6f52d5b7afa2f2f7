// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "analysis/estimate.h"

namespace livegs {

// A stoneware mug of 80 x 95 x 80 mm, captured with both of its walls: 120 cm3 of material.
inline ObjectFacts mug_facts() {
  ObjectFacts facts;
  facts.name = "mug";
  facts.scale_known = true;
  facts.mesh.size_m = {0.08, 0.095, 0.08};
  facts.mesh.principal_size_m = {0.095, 0.08, 0.08};
  facts.mesh.volume_m3 = 1.2e-4;
  facts.mesh.area_m2 = 0.055;
  facts.mesh.mean_wall_m = 4.4e-3;
  facts.mesh.hull_volume_m3 = 4.7e-4;
  facts.mesh.solidity = 0.25;
  facts.mesh.openness = 0.6;
  facts.mesh.piece_count = 1;
  return facts;
}

// A throw pillow of 40 x 12 x 40 cm.
inline ObjectFacts pillow_facts() {
  ObjectFacts facts;
  facts.name = "pillow";
  facts.scale_known = true;
  facts.mesh.size_m = {0.4, 0.12, 0.4};
  facts.mesh.principal_size_m = {0.4, 0.4, 0.12};
  facts.mesh.volume_m3 = 0.011;
  facts.mesh.area_m2 = 0.4;
  facts.mesh.mean_wall_m = 0.055;
  facts.mesh.hull_volume_m3 = 0.0115;
  facts.mesh.solidity = 0.95;
  facts.mesh.piece_count = 1;
  return facts;
}

// A kitchen sponge of 11 x 3 x 7 cm.
inline ObjectFacts sponge_facts() {
  ObjectFacts facts;
  facts.name = "sponge";
  facts.scale_known = true;
  facts.mesh.size_m = {0.11, 0.03, 0.07};
  facts.mesh.principal_size_m = {0.11, 0.07, 0.03};
  facts.mesh.volume_m3 = 2e-4;
  facts.mesh.area_m2 = 0.026;
  facts.mesh.mean_wall_m = 0.03;
  facts.mesh.hull_volume_m3 = 2.2e-4;
  facts.mesh.solidity = 0.91;
  facts.mesh.piece_count = 1;
  return facts;
}

// A tennis ball, named by its file.
inline ObjectFacts tennis_ball_facts() {
  ObjectFacts facts;
  facts.name = "056_tennis_ball";
  facts.scale_known = true;
  facts.mesh.size_m = facts.mesh.principal_size_m = {0.066, 0.066, 0.066};
  facts.mesh.volume_m3 = 1.5e-4;
  facts.mesh.area_m2 = 0.0137;
  facts.mesh.mean_wall_m = 0.06;
  facts.mesh.hull_volume_m3 = 1.5e-4;
  facts.mesh.solidity = 1;
  facts.mesh.piece_count = 1;
  return facts;
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
