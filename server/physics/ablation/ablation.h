// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdlib>
#include <string_view>

// Mechanisms of the solvers that can be disabled one at a time, which shows the purpose of each and what it
// costs (tests/bench/ablation). Only in a build with LIVEGS_ABLATION, by the environment variable
// LIVEGS_WITHOUT; otherwise nothing is left out, at no cost.

namespace livegs {

enum class Mechanism {
  // Elastic bodies
  FirstOrderWhenSlow,
  FirstOrderWhenStrained,
  AlternatingSweep,
  ImpactSteps,
  GripFade,
  LightNodeMass,
  LightNodeDamping,
  LoadedDamping,
  MaterialInertia,
  MomentMapReturn,
  CentrifugalCorrection,
  ContactLag,
  ColliderSide,
  ContactWarmStart,
  RollingResistance,
  CurvedPatches,
  EnergyLimiter,
  ShapeRecovery,
  StuckContacts,
  FlowEnergyCheck,
  RigidWhenUnstrained,
  DriftTest,
  // Rigid bodies
  StepsByLoad,
  DetectionsBySpeed,
  CoincidentShapes,
  DeepOverlaps,
  ReusedManifolds,
  BodyCores,
  JointEnergyLimit,
  FractureRecoil,
  Count,
};

inline constexpr std::array<std::string_view, static_cast<size_t>(Mechanism::Count)> kMechanismNames{
    "first_order_when_slow",
    "first_order_when_strained",
    "alternating_sweep",
    "impact_steps",
    "grip_fade",
    "light_node_mass",
    "light_node_damping",
    "loaded_damping",
    "material_inertia",
    "moment_map_return",
    "centrifugal_correction",
    "contact_lag",
    "collider_side",
    "contact_warm_start",
    "rolling_resistance",
    "curved_patches",
    "energy_limiter",
    "shape_recovery",
    "stuck_contacts",
    "flow_energy_check",
    "rigid_when_unstrained",
    "drift_test",
    "steps_by_load",
    "detections_by_speed",
    "coincident_shapes",
    "deep_overlaps",
    "reused_manifolds",
    "body_cores",
    "joint_energy_limit",
    "fracture_recoil"};

#ifdef LIVEGS_ABLATION
inline bool without(Mechanism mechanism) {
  static const std::string_view named = [] {
    const char* value = std::getenv("LIVEGS_WITHOUT");
    return std::string_view(value ? value : "");
  }();
  return named == kMechanismNames[static_cast<size_t>(mechanism)];
}
#else
constexpr bool without(Mechanism) { return false; }
#endif

}  // namespace livegs
