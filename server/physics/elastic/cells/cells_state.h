// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/revision.h"
#include "physics/collision/point_contact.h"
#include "physics/elastic/cells/cell_batches.h"
#include "physics/elastic/cells/cell_nodes.h"
#include "physics/elastic/elastic_sleep_timer.h"
#include "physics/elastic/flat_body.h"
#include "physics/elastic/resolution/lattice_resolution.h"
#include "physics/elastic_body.h"
#include "physics/lattice/lattice.h"
#include "physics/motion/free_rotation.h"
#include "physics/motion/momentum_ledger.h"

// The state of a body of the `cells` solver, in parts. Each part belongs to one or two files of this folder
// and holds data only; CellsBody (cells_body.h) composes them. Positions are relative to the body's origin.

namespace livegs::cells {

using Eigen::AlignedBox3d;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// A material point of the cell with these nodes, from its local coordinates.
inline NodeSample sample_of(std::span<const uint32_t, 8> nodes, const Vector3d& local) {
  const std::array<double, 8> weights = trilinear_weights(local);
  NodeSample sample;
  for (size_t c = 0; c < 8; ++c) {
    sample.nodes[c] = nodes[c];
    sample.weights[c] = static_cast<float>(weights[c]);
  }
  return sample;
}

// Materials of the body and of its regions, as requested; cells_body.cpp.
struct Materials : BodyMaterials {
  Material own;
  std::vector<RegionMaterial> regions;
  std::vector<std::string> region_names;  // of `regions`
  CellMaterials cells;                    // as simulated
};

// Resolution in space and time, and the predicted accuracy; cells_body.cpp.
struct Accuracy {
  double rate_hz = 0.0;
  int scene_substeps = 0, given_substeps = 0;  // per frame; the second 0: chosen
  // Per frame; the first is infinite if the cell width was given.
  double max_node_substeps = 0.0, scene_node_substeps = 0.0;
  LatticeResolution resolution;
  std::optional<LatticeResolution> unbudgeted;  // set if the scene's budget limits the body
  std::vector<MaterialAccuracy> materials;      // in the order of Materials
  double thin_part = 0.0;                       // as ElasticAccuracy::thin_part
  bool is_thin = false;                         // steps are limited by kMaxThinCourant
};

// Gains of the sweep for the body's own steps, for impact steps, and for the last other step length, imposed
// by neighbours; cells_body.cpp.
struct Gains {
  struct OfStep {
    double step_s = 0.0;                          // h; 0: none
    std::optional<GaussSeidelGains> of_order[2];  // first, second; computed on first use
  };
  OfStep own, impact, imposed;
  double last_step_s = 0.0;  // h; 0: none, or the cells have changed
};

// Plastic flow; cells_plasticity.cpp.
struct Plasticity {
  std::vector<PlasticCells> cut, thin;  // as CellBatches::cut and .thin; empty until plastic flow
  std::vector<Matrix3d> parts;          // by cell
  std::vector<std::array<Vector3d, kModeCount>> modes;  // rest amplitudes, rotated frame
  double work_j = 0.0;
};

// A region that holds or moves part of the body.
struct ConstrainedRegion {
  BodyRegion region;
  std::vector<uint32_t> nodes;                         // held nodes
  std::vector<uint32_t> nodes_of_others;               // contained too, but held by regions before this one
  std::vector<NodeSample> particles;                   // particles held individually
  std::vector<Vector3d> node_rest_m, particle_rest_m;  // object frame
  std::vector<uint32_t> particle_nodes;                // of `particles`
  std::vector<std::array<uint32_t, 8>> numbers;        // of each particle's nodes, in particle_nodes
  bool released = false;
};

// Fixed and moved regions; cells_regions.cpp.
struct Holding {
  Pose world_from_object;  // initial pose, for regions
  std::vector<ConstrainedRegion> regions;
  bool held = false;            // part of the body is fixed or has a prescribed motion
  bool moved = false;           // part of the body has a prescribed motion
  bool boundary_moved = false;  // the whole boundary has a prescribed motion at the start
  double reach_m = 0.0;         // from the held nodes to the farthest free one
};

struct Load {
  NodeSample sample;
  Vector3d force_n;  // world frame
  PointSpring* spring = nullptr;
  Vector3d from_m = Vector3d::Zero();  // position before the step
};

// Forces on the body; cells_step.cpp.
struct Loads {
  std::vector<Load> regions, points;
  double contact_n_s = 0.0;  // sum of impulse magnitudes in this step
  double pressed_n = 0.0;    // sum of the contact forces, moving average
  double carried_n = 0.0;    // force passed through the body between contacts, moving average
  ContactTotal contact_total;
};

struct SurfaceCell {
  std::array<uint32_t, 8> nodes;
  uint32_t begin, end;         // range of Surface::points
  Eigen::AlignedBox3f points;  // bounds of these points, local coordinates
};

// The curvature around a surface point (SurfacePatch), lattice axes at rest.
struct CurvedPatch {
  Eigen::Vector3f bulge = Eigen::Vector3f::Zero();
  Eigen::Matrix3f curvature = Eigen::Matrix3f::Zero(), flatten = Eigen::Matrix3f::Zero();
  float radius_m = 0.0f;  // mean of curvature
  float reach_m = 0.0f;   // 0: without curvature
  // How far the patch may reach beyond its point, against the other surface's normal.
  float lowest_m = 0.0f;
};

// Surface points, grouped by cell; cells_surface.cpp.
struct Surface {
  std::vector<NodeSample> points;
  std::vector<uint32_t> lattice_cells;  // by point; empty if the friction is the same everywhere
  std::vector<float> mobility;
  std::vector<CurvedPatch> patches;  // by point; empty if the whole surface is flat
  std::vector<SurfaceCell> cells;
  std::vector<Eigen::Vector3f> local;         // local coordinates of the points
  std::vector<uint32_t> face_begins;          // first face of each point, and the end
  std::vector<Eigen::Vector3f> face_normals;  // outward, lattice axes
  // Boxes of `cells` and of all of them; valid if boxes_known: in a step at the node positions before
  // contact, and these until the next step.
  mutable std::vector<Eigen::AlignedBox3d> cell_boxes;
  mutable Eigen::AlignedBox3d box;
  mutable bool boxes_known = false;
};

struct Candidate {
  uint32_t cell, collider;
  double apart_m = 0.0;  // relative motion until a point of the cell can touch the body
};

struct ColliderContact {
  uint32_t point;  // index in Surface::points
  NodeSample sample;
  Vector3d impulse_n_s;
};

// Contact with colliders; cells_contact.cpp.
struct ColliderContacts {
  std::vector<Candidate> candidates;
  double margin_m = 0.0;                  // remaining motion of any node before a new search
  size_t count = 0;                       // of colliders at the search
  std::vector<ColliderContact> contacts;  // of this step
};

struct DynamicContact {
  NodeSample sample;
  Vector3d impulse_n_s;
};

// Contacts of a rigid body's points with this body's surface, found a few steps ago.
struct RigidContacts {
  uint64_t body_id = 0;
  double margin_m = 0.0;  // relative motion until they are found again
  double motion_m = 0.0;  // bound of the relative motion in this step
  uint64_t own_revision = 0, shape_revision = 0;
  Pose last{};  // of the rigid body after the last step
  struct Point {
    Vector3d local_m;  // rigid body's frame
    NodeSample own;    // material point that touches
    uint32_t element;  // surface point next to it
    Vector3d normal;   // outward, of this body
    double offset_m;   // distance along the normal, less that from `own`
  };
  std::vector<Point> points = {};
};

// Contacts of this body's points with another elastic body, found a few steps ago.
struct ElasticContacts {
  uint64_t body_id = 0;
  double margin_m = 0.0;  // relative motion until they are found again
  uint64_t own_revision = 0, other_revision = 0;
  struct Point {
    uint32_t point, other_point;  // surface points
    NodeSample own, other;        // material points that touch
    Vector3d normal;              // outward, of the other body
    double apart_m = 0.0;         // relative motion until they can touch
  };
  std::vector<Point> points;
};

// The contact force of the last step that listed contacts, from which the next solve starts.
struct LastForce {
  uint64_t body_id = 0, step = 0;
  Eigen::Vector3f friction_n = Eigen::Vector3f::Zero();
  float normal_n = 0.0f;
};

// A contact with a body that pushes from opposite sides while the strain is far too large.
struct StuckContact {
  uint64_t body_id = 0;
  // In this frame, while overstrained: sums of impulse magnitudes and of impulses.
  double pushed_n_s = 0.0;
  Vector3d net_n_s = Vector3d::Zero();
  double stuck_s = 0.0;
  bool separating = false, overlaps = false;  // contact is off while separating, until no overlap remains
};

// Contact with rigid and elastic bodies; cells_dynamic_contact.cpp, cells_rigid_contact.cpp,
// cells_stuck_contacts.cpp.
struct BodyContacts {
  std::vector<Candidate> rigid_candidates;  // with indices of `rigid`
  double rigid_margin_m = 0.0;              // relative motion of any of them before a new search
  std::vector<RigidContacts> rigid;         // of the bodies that are near, in their order
  std::vector<ElasticContacts> elastic;     // likewise
  uint64_t revision = new_revision();       // of the motion; contacts found before are void
  // At the start of the last step, and a bound of the motion that it did not know of, such as by an impact.
  Vector3d velocity_m_s = Vector3d::Zero();
  double node_speed_m_s = 0.0, jump_m = 0.0;
  std::vector<LastForce> last_forces;  // by surface point
  uint64_t step = 0;                   // steps in which contacts could be listed
  double step_s = 0.0;
  std::vector<DynamicContact> contacts;  // of this step
  std::vector<StuckContact> stuck;       // ascending id
};

// The current step; cells_step.cpp.
struct StepState : StepMemory {
  double kinetic_j = 0.0;                           // of the last step
  double spin_rad_s = 0.0;                          // of the whole body
  double driven_m_s = 0.0;                          // fastest node of a moved region
  double strain_squared = 0.0, bent_squared = 0.0;  // largest over the cells
  bool second_order = false, is_slow = false, in_step = false;
  double gravity_m_s2 = 0.0;  // of the last substep
  Vector3d gravity = Vector3d::Zero();
  double impact_until_s = -1.0;
};

// Upper bound of the energy while badly strained; cells_energy_limiter.cpp.
struct EnergyLimiter {
  std::optional<double> limit_j;
  double work_j = 0.0;  // of hands and moving bodies in this frame
};

// cells_shape_recovery.cpp.
struct ShapeRecovery {
  bool degenerate = false, recovering = false;
  double degenerate_s = 0.0;
};

// State of a body that moves as a rigid body because it does not deform visibly.
struct RigidMotion {
  Pose world_from_body;                  // pose of the frozen shape_m
  std::vector<Eigen::Vector3f> shape_m;  // nodes relative to the centre of mass
  PrincipalAxes axes;
  Matrix3d inverse_inertia;  // body axes
};

// Sleep, and rigid motion before it; cells_sleep.cpp.
struct Rest {
  bool supported = false, forced = false, driven = false;  // or without gravity; loaded; moved by a region
  std::optional<RigidMotion> rigid;
  double unstrained_s = 0.0;
  Vector3d stationary_at_m = Vector3d::Constant(INFINITY);  // centre of mass at the start of stationary_s
  double stationary_s = 0.0;
  std::vector<Vector3d> points_m;  // of the surface, when one of them moved last; world frame
  bool may_rest = false;
  SleepTimer sleep_timer{false};
};

}  // namespace livegs::cells
