// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <vector>

#include "core/result.h"
#include "gaussian/posed_kernels.h"
#include "scene/scene.h"
#include "skin/shape_sample.h"
#include "skin/skin_kernels.h"
#include "splat/rasterise.h"
#include "splat/shadow_table.h"

namespace livegs {

// Background of pictures of a scene that states none.
inline const Eigen::Vector3f kPictureBackground(0.08f, 0.08f, 0.1f);

enum class Skinning { Lattice, LivegsV1 };

// Poses a scene's kernels by a frame of its drivers, ready for the rasteriser. Binds each object once and
// keeps its buffers between frames.
class SceneDrawing {
 public:
  // LivegsV1 drives elastic objects by their particles, the four nearest per kernel as in the paper, for any
  // solver.
  explicit SceneDrawing(Skinning skinning = Skinning::Lattice) : skinning_(skinning) {}

  // Poses all objects of `scene`. If `frame` is given (from a file), its drivers replace those of the world;
  // fails if they do not match the scene. The result is valid until the next call.
  Result<std::vector<DrawnObject>> pose(const Scene& scene, const DriverFrame* frame = nullptr);
  // Computes the shadows of the objects, as the client draws them, in every pose(); off by default.
  void set_shadows(bool drawn) { draws_shadows_ = drawn; }
  // Options with background, shadows and environments of the last pose(), valid until the next.
  RasteriseOptions options() const {
    RasteriseOptions options;
    options.background = background_;
    options.shadows = shadow_table_;
    options.environments = environments_;
    return options;
  }

  // Bounds of the objects in the last pose() without the environment, as the client frames them.
  std::vector<Eigen::AlignedBox3d> object_boxes() const { return boxes_; }

  // The deformation gradient F of each kernel of an object in the last pose(). Stored only if enabled.
  void keep_deformation_gradients(bool keep) { keep_gradients_ = keep; }
  const std::vector<Eigen::Matrix3f>& deformation_gradients(uint32_t object_id) const;
  const PosedKernels& kernels(uint32_t object_id) const;

 private:
  struct Bound {
    RestBody rest;
    KernelBindings bindings;
    PosedKernels kernels;
    ShapeSample shape;  // empty for the environment
    std::vector<Eigen::Matrix3f> gradients;
  };
  Skinning skinning_;
  bool keep_gradients_ = false;
  std::map<uint32_t, Bound> bound_;
  bool draws_shadows_ = false;
  SceneShadows shadows_;
  const ShadowTable* shadow_table_ = nullptr;
  std::vector<uint32_t> environments_;
  Eigen::Vector3f background_ = kPictureBackground;
  std::vector<Eigen::AlignedBox3d> boxes_;
};

}  // namespace livegs
