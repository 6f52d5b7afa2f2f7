// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "splat/project/project_kernels.h"
#include "train/kernel_parameters.h"
#include "train/render/render_cuts.h"

namespace livegs {

// Projects one kernel with the model of common/splat (project_kernels.h), without shadows and radius caps.
// False if nothing of it is visible. `ellipse.tile` and `tile_bound` are not set.
bool project_trained(const Projection& projection, const KernelParameters& parameters, size_t kernel,
                     int sh_degree, const RenderCuts& cuts, ProjectedKernel& ellipse);

// Derivatives of the loss by the projected values of one kernel. With d = pixel - centre, alpha the opacity
// at the pixel and G = alpha dL/dalpha (0 where alpha is at its limit or was skipped):
struct EllipseGradient {
  float sum = 0;                       // sum of G
  float x = 0, y = 0;                  // of G d
  float xx = 0, xy = 0, yy = 0;        // of G d dᵀ
  float red = 0, green = 0, blue = 0;  // dL by the colour
  float depth = 0;                     // dL by the depth of the centre, scene units
};

// Derivatives of the loss by the pose of the camera.
struct CameraGradient {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // per scene unit
  Eigen::Vector3d turn =
      Eigen::Vector3d::Zero();  // by a rotation about the camera's centre, world axes, per rad
};

// Derivatives by the trained numbers of the kernel; they are written, not added. Returns the part of the
// kernel in those by the camera. Precondition: project_trained returned true with the same arguments.
CameraGradient project_backward(const Projection& projection, const KernelParameters& parameters,
                                size_t kernel, int sh_degree, const EllipseGradient& ellipse,
                                KernelParameters& gradient);

}  // namespace livegs
