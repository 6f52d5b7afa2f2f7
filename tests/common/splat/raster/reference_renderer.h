// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "gaussian/posed_kernels.h"
#include "splat/camera.h"
#include "splat/rasterise.h"

namespace livegs {

// A literal implementation of the published formulas: every kernel at every pixel, in doubles, with full
// matrices and harmonics from Legendre polynomials. Shares no code with the rasteriser.
class ReferenceRenderer {
 public:
  ReferenceRenderer(std::span<const DrawnObject> objects, const Camera& camera,
                    const RasteriseOptions& options);

  struct Pixel {
    Eigen::Vector3d rgb;
    double coverage;
    double depth_m;  // infinity if transmittance never falls under 0.5
  };
  Pixel pixel(int x, int y) const;
  Image image() const;

 private:
  struct Kernel {
    Eigen::Vector2d centre_px;
    // std::stable_sort of libstdc++ 12 does not align its buffer to more than 16 bytes.
    Eigen::Matrix<double, 2, 2, Eigen::DontAlign> conic;
    double opacity, depth_m, order;
    Eigen::Vector3d rgb;
  };
  std::vector<Kernel> kernels_;  // nearest first
  int width_, height_;
  Eigen::Vector3d background_;
};

// Real spherical harmonic of degree l and order m at a unit direction, with the Condon-Shortley sign.
double spherical_harmonic(int l, int m, const Eigen::Vector3d& direction);

}  // namespace livegs
