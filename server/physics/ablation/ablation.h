// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

// Mechanisms of the solvers that stabilise, limit, fade or save time, beyond the equations themselves. One at
// a time can be disabled, which shows what it is for and what it costs (study/chart/ablation_chart.h).

namespace livegs {

enum class Mechanism : uint8_t {
  None,
  // elastic
  AlternatingSweep,
  CentrifugalCorrection,
  ContactLag,
  ContactWarmStart,
  CurvedPatches,
  DriftTest,
  EnergyLimiter,
  FirstOrderWhenSlow,
  FirstOrderWhenStrained,
  FlowEnergyCheck,
  GripFade,
  ImpactSteps,
  LightNodeMass,
  LoadedDamping,
  MaterialInertia,
  RigidWhenUnstrained,
  RollingResistance,
  ShapeRecovery,
  StuckContacts,
  // rigid
  BodyCores,
  CoincidentShapes,
  DeepOverlaps,
  DetectionsBySpeed,
  FractureRecoil,
  JointEnergyLimit,
  ReusedManifolds,
  StepsByLoad,
};

// The disabled mechanism of this process. Write it only while no world exists: some mechanisms apply when a
// body is made.
inline Mechanism disabled_mechanism = Mechanism::None;

inline bool without(Mechanism mechanism) { return mechanism == disabled_mechanism; }

}  // namespace livegs
