// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/chart/ablation_chart.h"

namespace livegs::study {

std::span<const MechanismText> all_mechanisms() {
  using enum Mechanism;
  static constexpr MechanismText kTexts[] = {
      {AlternatingSweep, "alternating_sweep", "the sweep over cells changes its direction during contact"},
      {CentrifugalCorrection, "centrifugal_correction",
       "nodes of a spinning body are pulled as the material"},
      {ContactLag, "contact_lag", "the centre of mass follows contact impulses without the lag of BDF2"},
      {ContactWarmStart, "contact_warm_start", "contacts of elastic bodies start from their last force"},
      {CurvedPatches, "curved_patches", "contact points of round bodies lie on the curved surface"},
      {DriftTest, "drift_test", "a held or loaded body sleeps only if its mean position is constant"},
      {EnergyLimiter, "energy_limiter", "a free body cannot gain energy over a frame"},
      {FirstOrderWhenSlow, "first_order_when_slow", "a slow body in contact takes steps of first order"},
      {FirstOrderWhenStrained, "first_order_when_strained",
       "a badly strained body takes steps of first order"},
      {FlowEnergyCheck, "flow_energy_check", "plastic flow that would add elastic energy is rejected"},
      {GripFade, "grip_fade", "a hand slips off overstretched material"},
      {ImpactSteps, "impact_steps", "a body takes shorter steps during an impact"},
      {LightNodeMass, "light_node_mass", "nodes of nearly empty cells get a least mass"},
      {LoadedDamping, "loaded_damping", "the loss factor also damps the load on a body"},
      {MaterialInertia, "material_inertia", "a body turns by the inertia of its material, not of its nodes"},
      {RigidWhenUnstrained, "rigid_when_unstrained", "a free body without strain flies as a rigid one"},
      {RollingResistance, "rolling_resistance", "rolling loses energy by the loss factor"},
      {ShapeRecovery, "shape_recovery", "cells without volume are returned to their shape"},
      {StuckContacts, "stuck_contacts", "contacts that press a body from both sides separate"},
      {BodyCores, "body_cores", "the inscribed ball of a body does not pass thin bodies"},
      {CoincidentShapes, "coincident_shapes", "bodies at the same place separate along their thinnest side"},
      {DeepOverlaps, "deep_overlaps", "deeply overlapping bodies separate in one direction"},
      {DetectionsBySpeed, "detections_by_speed", "fast pairs find their contacts several times a substep"},
      {FractureRecoil, "fracture_recoil", "fragments recoil from an impact that broke the body"},
      {JointEnergyLimit, "joint_energy_limit", "a group of joined bodies cannot gain energy by its joints"},
      {ReusedManifolds, "reused_manifolds", "pairs that hardly move keep their contact points"},
      {StepsByLoad, "steps_by_load", "heavily loaded islands take more solver steps"},
  };
  return kTexts;
}

}  // namespace livegs::study
