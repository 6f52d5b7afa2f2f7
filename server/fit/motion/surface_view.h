// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "scene/scene.h"
#include "splat/camera.h"
#include "splat/kernel_view.h"

namespace livegs {

// A material point on the surface of an object, in the frame of its asset at rest.
struct TrackedPoint {
  std::string object;
  Eigen::Vector3f asset_point;
};

// Visible surface points of the pixels of a camera, for the current state of a scene. The scene is not
// stored.
class SurfaceView {
 public:
  // `objects`: names of objects of the scene; other objects only occlude them.
  static Result<SurfaceView> of(const Scene& scene, const Camera& camera,
                                std::span<const std::string> objects);

  // One entry per pixel: 255 where the object is visible and no rim is within `rim_px` pixels, else 0.
  std::vector<uint8_t> mask(const std::string& object, int rim_px) const;
  // Returns the surface point at a position in the picture. nullopt outside of the picture, and where none of
  // the objects is visible.
  std::optional<TrackedPoint> at(const Eigen::Vector2d& px) const;

 private:
  struct Seen {
    KernelView view;
    std::vector<Eigen::Vector3f> positions_m, rest_points;  // of its kernels: posed, and in the asset
    std::vector<Eigen::Matrix3f> asset_from_world;          // rotation and stretch of each kernel, inverted
  };
  Camera camera_;
  std::map<uint32_t, std::string> names_;
  std::map<uint32_t, Seen> seen_;
  std::vector<uint32_t> object_id_;  // per pixel
};

}  // namespace livegs
