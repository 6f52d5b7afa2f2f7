// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

// Plastic flow of one cell by return mapping: strain beyond the yield surface becomes part of the rest shape.
//
// The cell's deformation F (world from rest) has the stretch U = sqrt(Fᵀ F). The plastic part D in the rest
// frame is symmetric, positive definite, and has det D = 1. D is the goal of shape matching: the elastic
// energy is mu |U - D|² + lambda/2 (det F - 1)². LIVE-GS's plasticity p sets two limits: the cell yields at a
// strain of 1 - p, and |D - I| <= p (Frobenius). Unlike the paper's rule (server/baseline), the result
// is independent of rate and step size, volume is preserved, and degenerate cells do not flow.
//
//   strain  e = dev(U - D), dev the part without trace
//   yield   |e| <= r
//   flow    D' = D + (1 - r/|e|) e + beta I, beta from det D' = 1; beta I leaves e unchanged, so |e'| = r
//
// The plastic strain is subtracted, not divided: with the energy of F D⁻¹ the load of a bar that flows would
// drop with its cross-section, and the bar would neck, by an amount that depends on the rate.
//
// With T = 2 mu (U - D), the stress of the shear energy in the frame of F's rotation is T + A, where A is
// antisymmetric and A U + U A = U T - T U (add_turning_force in cell_kernels.cpp).
//
// The yield criterion ignores volumetric strain, which flow could not reduce. r is defined by simple tension:
// a bar with the material's Poisson ratio starts to flow at the axial strain 1 - p, exactly, also at large
// yield strains.

namespace livegs {

// Volume ratio below which a cell or body is degenerate: flattened, wound or inverted.
inline constexpr double kMinVolumeRatio = 0.1;

struct YieldSurface {
  double radius = 0.0;  // r, unitless
  double limit = 0.0;   // upper bound of |D - I|; 0: no flow
};
// Computed once per material. `plasticity` is clamped to 0 … 1, `poisson_ratio` to 0 … 0.49. With plasticity
// 1 any strain flows.
YieldSurface yield_surface(double plasticity, double poisson_ratio);

struct PlasticFlow {
  Eigen::Matrix3d plastic_part;  // D'; equal to D if the cell did not flow
  // Shear energy dissipated by the flow, divided by mu V (V: rest volume of the cell). >= 0; 0 without flow.
  double work = 0.0;
  bool flowed = false;
};
// `elastic_deformation` is F D⁻¹ and may be any matrix. There is no flow if it is not finite, inverted,
// compressed to less than a tenth of its volume, or stretched more than a hundredfold. Afterwards |e| = r to
// rounding, unless D' reached the limit: D' is then scaled back along ln D', |e| remains above r, and the
// cell is elastic beyond. det D' = 1 within 1e-14, and D' is exactly symmetric. Precondition: `plastic_part`
// is the identity or a result of this function.
PlasticFlow flow_plastically(const YieldSurface& surface, const Eigen::Matrix3d& elastic_deformation,
                             const Eigen::Matrix3d& plastic_part);

}  // namespace livegs
