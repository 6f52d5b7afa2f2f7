// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "gaussian/posed_kernels.h"

namespace livegs {

// Contact and soft shadows of the moving bodies of a picture, in the form that shadow_light() and the pass
// project_splats read (shadow_layout.h). World frame, +Y up.
struct ShadowTable {
  std::vector<uint32_t> words;  // empty: no shadows
  uint64_t version = 0;         // equal versions of one SceneShadows mean equal words
};

// The share of its colour that a kernel keeps, 0 to 1: the product over the bodies of other objects. 1 with
// an empty table and above or far below all bodies. Continuous in `at_m`. Any thread.
float shadow_light(std::span<const uint32_t> words, const Eigen::Vector3f& at_m, uint32_t object_id);

// Kernels that represent the current shape of an object; one entry per kernel.
struct ShadowShape {
  std::span<const Eigen::Vector3f> positions_m;
  std::span<const Symmetric3f> covariances_m2;
  std::span<const float> weights;    // opacity times the number of kernels that each stands for
  std::span<const uint32_t> bodies;  // rigid body of each kernel; every body has its own shadow
};

// The shadows of a scene: light from the whole sky that a body takes from the places under and around it.
//
// The body is cut into bands of height. Each band is a map of covered area, seen from above. For a receiver
// at the gap g below a band, the map is blurred by a standard deviation that grows with g, and its darkness
// falls with g to zero at about two widths of the body. The darkness is the largest of the bands, because
// they are seen in similar directions. It is stored for four heights of the receiver and interpolated
// between. A resting body thus has a dark, sharp shadow, a lifted one a faint, wide shadow or none.
//
// Not thread-safe. Deterministic for any thread count.
class SceneShadows {
 public:
  // Computes the shadows of an object. About 0.3 ms per body on one core.
  void set(uint32_t object_id, const ShadowShape& shape);
  // Removes all objects except these.
  void keep(std::span<const uint32_t> object_ids);
  // The table of all objects; valid until the next call of a function above.
  const ShadowTable& table();

  // Shadows of one body.
  struct Body {
    float x_m = 0, z_m = 0, texels_per_m = 0;
    uint32_t texels_x = 0, texels_z = 0;  // 0: no shadow
    float heights_m[6]{};
    std::vector<float> darkness;
  };

 private:
  std::map<uint32_t, std::vector<Body>> objects_;
  ShadowTable table_;
  bool changed_ = false;
};

}  // namespace livegs
