// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

namespace livegs {

// Y_00, the constant spherical harmonic: 1 / (2 sqrt(pi)).
inline constexpr float kShBand0 = 0.28209479177387814f;

// The kernels of one captured object, as trained (Kerbl et al. 2023, 3D Gaussian Splatting), one array per
// property.
//
// Frame: that of 3DGS tools, x right, -Y up, z forward ("RDF"), in the file's own unit of length. Readers
// convert to it. Values are not metric: `scale` and `up` of a scene object place an asset in the world.
//
// Invariants, established by every reader: all values finite, rotations unit, arrays of equal length, 0 <=
// sh_degree <= 3.
struct GaussianAsset {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> log_scales;    // ln of the standard deviation along each principal axis
  std::vector<Eigen::Quaternionf> rotations;  // asset_from_kernel
  std::vector<float> opacity_logits;          // opacity = 1 / (1 + e^-logit)
  std::vector<Eigen::Vector3f> sh_dc;         // rgb = 0.5 + 0.28209479 sh_dc + the bands below
  // kernel-major: [kernel * sh_rest_count() + k], k = l=1 m=-1,0,1; l=2 …
  std::vector<Eigen::Vector3f> sh_rest;
  int sh_degree = 0;
  bool antialiased = false;  // trained with the mip low-pass filter: opacity is compensated when drawn

  size_t size() const { return positions.size(); }
  size_t sh_rest_count() const { return static_cast<size_t>((sh_degree + 1) * (sh_degree + 1) - 1); }
  void resize(size_t count) {
    positions.resize(count);
    log_scales.resize(count);
    rotations.resize(count);
    opacity_logits.resize(count);
    sh_dc.resize(count);
    sh_rest.resize(count * sh_rest_count());
  }
};

}  // namespace livegs
