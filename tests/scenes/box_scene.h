// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include "scene/scene.h"

namespace livegs {

// A fragile block on a floor. A scene event breaks it after `breaks_after_s`.
inline Scene breaking_scene(double rate_hz = 90, uint32_t first_object_id = 1, double breaks_after_s = 1) {
  v1::Scene file;
  const auto parsed = google::protobuf::util::JsonStringToMessage(R"({
    "substeps": 4,
    "environment": { "colliders": [ { "plane": {}, "friction": 0.6 } ] },
    "objects": [
      { "name": "box", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0, 0.1, 0] },
        "physics": { "behavior": "RIGID", "mass_kg": 1.0, "fragile": true, "break_impulse_n_s": 2 } } ],
    "events": [ { "time_s": 1.0, "break": { "object": "box", "point_m": [0.1, 0.1, 0.1] } } ] })",
                                                                  &file);
  EXPECT_TRUE(parsed.ok()) << parsed.message();
  file.mutable_events(0)->set_time_s(breaks_after_s);
  SceneOptions options;
  options.rate_hz = rate_hz;
  options.first_object_id = first_object_id;
  auto scene = Scene::build(file, ".", "breaking", options);
  EXPECT_TRUE(scene) << scene.error().message;
  return std::move(*scene);
}

// A rigid box and a soft cube, 1 m apart on a floor. Both are shapes, so the scene needs no assets.
inline Scene box_scene(double rate_hz = 90, double box_size_m = 0.2, uint32_t first_object_id = 1) {
  v1::Scene file;
  const auto parsed = google::protobuf::util::JsonStringToMessage(R"({
    "substeps": 4,
    "environment": { "colliders": [ { "plane": {}, "friction": 0.6 } ] },
    "objects": [
      { "name": "box", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [-0.5, 0.1, 0] },
        "physics": { "behavior": "RIGID", "mass_kg": 1.0, "friction": 0.5 } },
      { "name": "cube", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0.5, 0.1, 0] },
        "physics": { "behavior": "ELASTIC", "density_kg_m3": 300, "youngs_modulus_pa": 2e4 } } ] })",
                                                                  &file);
  EXPECT_TRUE(parsed.ok()) << parsed.message();
  for (int i = 0; i < 3; ++i)
    file.mutable_objects(0)->mutable_shape()->mutable_box()->set_size_m(i, box_size_m);
  SceneOptions options;
  options.rate_hz = rate_hz;
  options.first_object_id = first_object_id;
  auto scene = Scene::build(file, ".", "boxes", options);
  EXPECT_TRUE(scene) << scene.error().message;
  return std::move(*scene);
}

}  // namespace livegs
