// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>

namespace livegs {

enum class Behavior { Auto, Static, Rigid, Elastic };

// Contents of the volume enclosed by an object's surface mesh.
enum class Fill {
  Solid,      // solid material
  Shell,      // a closed wall around air
  OpenShell,  // a wall with an opening: a cup, a bowl
  Filled,     // a container and its contents, modelled as one effective density
};

// Material of a body, SI units. Created from PhysicalParameters (server/analysis) or a scene's `physics`.
struct Material {
  Behavior behavior = Behavior::Rigid;  // never Auto in a world
  double mass_kg = 0.0;                 // of the whole body; > 0
  Fill fill = Fill::Solid;
  double wall_thickness_m = 0.0;       // Shell and OpenShell; 0 when unknown
  double youngs_modulus_pa = 1e5;      // > 0
  double poisson_ratio = 0.3;          // 0 … 0.49
  double structure_coefficient = 1.0;  // s of LIVE-GS, 0 … 1: the body as a whole has E* = s E
  double plasticity = 0.0;             // p of LIVE-GS, 0 … 1
  double loss_factor = 0.1;            // damping of deformation, unitless, 0 … 2
  bool fragile = false;
  double break_impulse_n_s = 0.0;
  unsigned fracture_pieces = 32;  // number of pieces of a fragile body, 2 … 64
  // Colour of cut faces, 0 … 1 as displayed; none: the colour of the nearest surface.
  std::optional<Eigen::Vector3f> interior_rgb;
  double friction = 0.5;     // 0 … 2
  double restitution = 0.2;  // 0 … 1

  double effective_youngs_modulus_pa() const { return structure_coefficient * youngs_modulus_pa; }
};

// LIVE-GS's deformation resistance d_R in 0 … 1 from E* = s E, and its inverse. Piecewise linear through (0,
// 0), (0.1 MPa, 0.1), (1 MPa, 0.5), (50 MPa, 0.8), (200 MPa, 1). Objects above 200 MPa are rigid.
double deformation_resistance(double effective_youngs_modulus_pa);
double effective_youngs_modulus_pa(double deformation_resistance);

}  // namespace livegs
