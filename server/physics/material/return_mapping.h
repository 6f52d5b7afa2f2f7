// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

// Plastic flow of one cell as return mapping: what the shape is strained beyond its yield becomes its new
// rest shape.
//
// The cell's deformation F (world from rest), with the stretch U = sqrt(Fᵀ F), goes through a plastic part D
// in the rest frame: symmetric, positive, det D = 1. D is what the rest shape has become, as a goal of shape
// matching: the elastic energy is mu |U - D|² + lambda/2 (det F - 1)². LIVE-GS's p sets both ends: the cell
// yields at a strain of 1 - p, and |D - I| <= p (Frobenius). Unlike the paper's rule (livegs_v1_plasticity.h)
// the result depends on neither rate nor step, volume is kept, and a cell without shape never flows.
//
//   strain  e = dev(U - D), dev the part without trace
//   yield   |e| <= r
//   flow    D' = D + (1 - r/|e|) e + beta I, beta from det D' = 1; beta I leaves e alone, so |e'| = r
//
// A strain is subtracted, not divided: a bar pulled to a strain sets at that strain minus its yield, as
// lengths, and its load stays what it was at yield however the flow is shared along it. (Were the energy that
// of F D⁻¹, the load would fall as the section shrinks and the bar neck: 5 % under to 11 % over at a yield of
// 0.1, depending on the rate.)
//
// What a solver must not leave out: with T = 2 mu (U - D), the stress of the shear energy in the frame of F's
// rotation is T + A, A antisymmetric with A U + U A = U T - T U. A is zero where U and D have the same axes.
// Without it cells that flowed in different directions turn the body and feed it energy (a free bar of such
// cells: half as much again in 1.5 s; with it, none).
//
// Strain counts without its volume part: flow keeps volume, so it could not undo that part, and a cell
// squeezed from all sides would lose its shape for it. r is set in simple tension: a bar of the material's
// own Poisson ratio starts to flow at the axial strain 1 - p, exactly and also for large yields. (The paper's
// own bodies have nu = 0, where that is |S - I| = 1 - p to the letter.)

namespace livegs {

struct YieldSurface {
  double radius = 0.0;  // r, unitless
  double limit = 0.0;   // of |D - I|; 0: never flows
};
// Once a material. `plasticity` is taken within 0 … 1, poisson_ratio 0 … 0.49. p = 1 flows from the least
// strain.
YieldSurface yield_surface(double plasticity, double poisson_ratio);

struct PlasticFlow {
  Eigen::Matrix3d plastic_part;  // D'; D itself where nothing flowed
  // What flow took out of the shear energy, over mu V (joules: times the shear modulus and the cell's rest
  // volume);
  // >= 0, and 0 where nothing flowed.
  double work = 0.0;
  bool flowed = false;
};
// `elastic_deformation` is F D⁻¹: any matrix. Not finite, inverted, squeezed to under a tenth of its volume
// or stretched a hundredfold: nothing flows. Afterwards |e| = r to rounding, unless D' met the limit: there
// D' is pulled back along ln D', |e| stays above r, and the cell is elastic beyond. det D' = 1 within 1e-14,
// and D' is symmetric to the bit. Precondition: `plastic_part` came from here, or is the identity.
PlasticFlow flow_plastically(const YieldSurface& surface, const Eigen::Matrix3d& elastic_deformation,
                             const Eigen::Matrix3d& plastic_part);

}  // namespace livegs
