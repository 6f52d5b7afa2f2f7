// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <span>

namespace livegs::sample {

// A function of the angle to an axis, as coefficients of the spherical-harmonic bands 0..3 (Ramamoorthi and
// Hanrahan 2001): f(d) = sum_l strength[l] sum_m Y_lm(axis) Y_lm(d).
struct ZonalLobe {
  std::array<double, 4> strength{};
};

// Projects f, a function of the cosine of the angle to the axis, by Gauss-Legendre quadrature up to band
// `degree` (1..3). A Lanczos window damps ringing. The result is scaled so that its value on the axis is
// f(1): a band-limited highlight is wider than the real one but as bright.
ZonalLobe project_lobe(const std::function<double(double cosine)>& f, int degree);

// The plain projection, without damping and scaling.
ZonalLobe project_zonal(const std::function<double(double cosine)>& f, int degree);

// Real spherical harmonics with the Condon-Shortley sign, as stored in 3DGS files: Y_00, then l = 1 with m =
// -1, 0, 1, and so on. `direction` is a unit vector.
std::array<double, 16> real_harmonics(const Eigen::Vector3d& direction);

// Adds `colour` times the lobe to a kernel. `axis` is the viewing direction at the lobe's peak, from the
// camera to the kernel, in the asset's frame.
void add_lobe(const ZonalLobe& lobe, const Eigen::Vector3d& axis, const Eigen::Vector3d& colour,
              Eigen::Vector3d& dc, std::span<Eigen::Vector3d> rest);

}  // namespace livegs::sample
