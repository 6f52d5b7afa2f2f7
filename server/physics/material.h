// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>

namespace livegs {

enum class Behavior { Auto, Static, Rigid, Elastic };

// What the enclosed volume of an object's surface mesh is filled with.
enum class Fill {
  Solid,      // material throughout
  Shell,      // a closed wall around air
  OpenShell,  // a wall with an opening: a cup, a bowl
  Filled,     // a container with its contents, taken as one effective density
};

// What a body is made of, in SI units. Made from PhysicalParameters (server/analysis) or a scene's `physics`.
struct Material {
  Behavior behavior = Behavior::Rigid;  // never Auto in a world
  double mass_kg = 0.0;                 // of the whole body; > 0
  Fill fill = Fill::Solid;
  double wall_thickness_m = 0.0;       // Shell and OpenShell; 0 when unknown
  double youngs_modulus_pa = 1e5;      // > 0
  double poisson_ratio = 0.3;          // 0 … 0.49
  double structure_coefficient = 1.0;  // s of LIVE-GS, 0 … 1: E* = s E is what the body as a whole shows
  double plasticity = 0.0;             // p of LIVE-GS, 0 … 1
  double loss_factor = 0.1;            // damping of deformation, unitless, 0 … 2
  bool fragile = false;
  double break_impulse_n_s = 0.0;
  unsigned fracture_pieces = 32;  // a fragile body is cut into, 2 … 64
  std::optional<Eigen::Vector3f>
      interior_rgb;          // of cut faces, 0 … 1 as displayed; none: as the surface near by
  double friction = 0.5;     // 0 … 2
  double restitution = 0.2;  // 0 … 1

  double effective_youngs_modulus_pa() const { return structure_coefficient * youngs_modulus_pa; }
};

// LIVE-GS's deformation resistance d_R in 0 … 1 from E* = s E: piecewise linear through (0, 0), (0.1 MPa,
// 0.1), (1 MPa, 0.5), (50 MPa, 0.8), (200 MPa, 1) and its inverse. Above 200 MPa an object is rigid.
double deformation_resistance(double effective_youngs_modulus_pa);
double effective_youngs_modulus_pa(double deformation_resistance);

// d_R is the part of the way to its goal that a particle goes in one substep, so what it shows grows with the
// square of the substep rate. At the substep the paper ran at (60 Hz, 4 substeps) it stands for a stiffness,
// as that of a spring to the goal by mass, omega² = d_R / ((1 - d_R) h_ref²) in 1/s²: 0 … infinity, which is
// rigid.
inline constexpr double kPaperSubstep_s = 1.0 / 240.0;
double resistance_stiffness_per_s2(double deformation_resistance);
// And back at a substep of any length: omega² h² / (1 + omega² h²), the implicit step of that spring; 1 where
// omega² is infinite. Equals d_R at kPaperSubstep_s.
double resistance_blend(double stiffness_per_s2, double substep_s);

}  // namespace livegs
