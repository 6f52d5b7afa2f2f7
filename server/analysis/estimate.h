// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "geometry/surface/mesh_facts.h"
#include "livegs/v1/physics.pb.h"
#include "physics/material.h"

// What an object is made of, worked out without any network: first its name, then its geometry and colour,
// against a table of materials and of everyday objects. An inspectable model with ranges and reasons, never a
// bare number.

namespace livegs {

// How an asset looks: statistics over its kernels, weighted by opacity and area.
struct AppearanceFacts {
  Eigen::Vector3f mean_rgb = Eigen::Vector3f::Zero();  // 0 … 1, display-encoded
  float saturation = 0.0f;                             // mean of the HSV saturation
  float hue_spread = 0.0f;                             // circular standard deviation of hue, radians
  float mean_opacity = 0.0f;                           // low for glass and haze
  float gloss = 0.0f;  // share of colour that depends on the view direction, 0 … 1
};
AppearanceFacts appearance_facts(const GaussianAsset& asset);

// Everything the estimator may look at. Lengths in metres, in the object frame (+Y up).
struct ObjectFacts {
  std::string name;  // a person's label or the asset's file name; may be empty
  MeshFacts mesh;
  AppearanceFacts appearance;
  bool scale_known = false;  // metric, rather than guessed
  bool solid = false;  // given as what takes up room (a shape, a list of points), not captured from outside
};

// The confidence of an estimate whose name states the material but not the object. An estimate by looks alone
// has at most 0.35 and is never held against an author's or a model's material; one of at least this is.
// Smaller: looks overrule authors. Larger: a named material is ignored.
inline constexpr double kMaterialNamedConfidence = 0.4;
// How much of an estimate's confidence a guessed scale leaves.
inline constexpr double kGuessedScaleTrust = 0.8;
// A guessed scale may be off by two, a volume by eight.
inline constexpr double kGuessedVolumeRatio = 8.0;

// Always answers. Every value carries low <= best <= high, its source and a reason. Pure; any thread.
v1::PhysicalParameters estimate_offline(const ObjectFacts& facts);

// What can be said of an author's words without the object: every number finite and within its physical
// range, no contradictions. The message begins with the field's name and holds its range.
Result<void> check_scene_physics(const v1::Physics& written);
// What the author gave that is possible, but far from what the object was taken for or from any material: a
// pillow of 2 GPa. It is used all the same; each line names the field and the range.
std::vector<std::string> implausible_physics(const v1::PhysicalParameters& estimated,
                                             const v1::Physics& written, const v1::PhysicalParameters& merged,
                                             const ObjectFacts& facts);

// What a scene's author wrote wins over what was estimated, value by value (source SCENE), and what depends
// on it is worked out again (mass from density and fill, E from d_R, …). Fails when the author's words
// contradict each other or leave the physical ranges; the message names the field. `by` PERSON: they are
// edits.
Result<v1::PhysicalParameters> merge_scene_physics(const v1::PhysicalParameters& estimated,
                                                   const v1::Physics& written, const ObjectFacts& facts,
                                                   v1::EstimatedValue::Source by = v1::EstimatedValue::SCENE);

// To what a body is made with.
Material to_material(const v1::PhysicalParameters& parameters);

}  // namespace livegs
