// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "geometry/surface/mesh_facts.h"
#include "livegs/v1/physics.pb.h"
#include "physics/material.h"

// Offline estimate of an object's physical parameters. The estimator compares the name, then the geometry and
// colour with tables of materials and everyday objects. The model is inspectable: every value has a range and
// a reason.

namespace livegs {

// Appearance statistics over the kernels of an asset, weighted by opacity and area.
struct AppearanceFacts {
  Eigen::Vector3f mean_rgb = Eigen::Vector3f::Zero();  // 0 … 1, display-encoded
  float saturation = 0.0f;                             // mean of the HSV saturation
  float hue_spread = 0.0f;                             // circular standard deviation of hue, radians
  float mean_opacity = 0.0f;                           // low for glass and haze
  float gloss = 0.0f;  // fraction of the colour that depends on the view direction, 0 … 1
};
AppearanceFacts appearance_facts(const GaussianAsset& asset);

// The kernels of a captured object as points, to divide it into parts: every `stride`-th one.
struct SurfaceKernels {
  size_t stride = 1;
  std::vector<Eigen::Vector3f> positions_m;  // object frame, at rest
  std::vector<Eigen::Vector3f> rgb;          // 0 … 1, display-encoded
  std::vector<float> weights;                // opacity times visible area, m²
};
// Stride for an asset with this number of kernels.
size_t surface_stride(size_t kernel_count);
SurfaceKernels surface_kernels(const GaussianAsset& asset, const Similarity& object_from_asset);

// Input of the estimator. Lengths in metres, in the object frame (+Y up).
struct ObjectFacts {
  std::string name;  // a user's label or the asset's file name; may be empty
  MeshFacts mesh;
  AppearanceFacts appearance;
  bool scale_known = false;  // metric, not guessed
  bool solid = false;        // given as a volume (a shape, a list of points), not captured from outside
  // Kernels of a captured object; null: the object is not divided by its appearance.
  std::shared_ptr<const SurfaceKernels> kernels;
};

// Confidence of an estimate whose name states the material but not the object. An estimate from appearance
// alone has at most 0.35. Below this constant, an estimate does not contradict the material of an author or a
// model. If reduced, appearance overrules authors. If increased, a named material is ignored.
inline constexpr double kMaterialNamedConfidence = 0.4;
// Below this confidence the estimate names no likely material but a middle one that does not break, and the
// client asks the user. Larger: fewer cups of glass, and more things that are neither hard nor soft.
inline constexpr double kMinMaterialConfidence = 0.25;
// Factor on the confidence of an estimate if the scale is guessed.
inline constexpr double kGuessedScaleTrust = 0.8;
// Uncertainty of a volume if the scale is guessed: a factor of two in length, eight in volume.
inline constexpr double kGuessedVolumeRatio = 8.0;

// Estimates all parameters; never fails. Every value has low <= best <= high, a source and a reason.
// Pure; any thread.
v1::PhysicalParameters estimate_offline(const ObjectFacts& facts);

// Checks an author's values without the object: every number is finite and within its physical range, and no
// two contradict each other. The error begins with the field name and contains its range.
Result<void> check_scene_physics(const v1::Physics& written);
// Lists an author's values that are possible but implausible for this object or for any material, such as a
// pillow of 2 GPa. The values are used all the same. Each line names the field and the range.
std::vector<std::string> implausible_physics(const v1::PhysicalParameters& estimated,
                                             const v1::Physics& written, const v1::PhysicalParameters& merged,
                                             const ObjectFacts& facts);

// Merges a scene author's values over the estimate, value by value (source SCENE), and recomputes the
// dependent values (mass from density and fill, E from d_R, …).
// `by` is PERSON for manual edits.
// Fails if the author's values contradict each other or leave the physical ranges; the error names the field.
Result<v1::PhysicalParameters> merge_scene_physics(const v1::PhysicalParameters& estimated,
                                                   const v1::Physics& written, const ObjectFacts& facts,
                                                   v1::EstimatedValue::Source by = v1::EstimatedValue::SCENE);

// Converts the best values to the material of a simulated body.
Material to_material(const v1::PhysicalParameters& parameters);

}  // namespace livegs
