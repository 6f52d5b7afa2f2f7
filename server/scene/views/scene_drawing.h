// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <vector>

#include "core/result.h"
#include "gaussian/posed_kernels.h"
#include "scene/scene.h"
#include "skin/skin_kernels.h"

namespace livegs {

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

  // The deformation gradient F of each kernel of an object in the last pose(). Stored only if enabled.
  void keep_deformation_gradients(bool keep) { keep_gradients_ = keep; }
  const std::vector<Eigen::Matrix3f>& deformation_gradients(uint32_t object_id) const;
  const PosedKernels& kernels(uint32_t object_id) const;

 private:
  struct Bound {
    RestBody rest;
    KernelBindings bindings;
    PosedKernels kernels;
    std::vector<Eigen::Matrix3f> gradients;
  };
  Skinning skinning_;
  bool keep_gradients_ = false;
  std::map<uint32_t, Bound> bound_;
};

}  // namespace livegs
