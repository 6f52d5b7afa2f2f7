// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "geometry/field/sample_particles.h"
#include "physics/body_region.h"
#include "physics/collider.h"
#include "physics/collision/point_surface.h"
#include "physics/elastic/contact_constraints.h"
#include "physics/material.h"
#include "skin/driver_frame.h"
#include "skin/rest_body.h"

// Interface between the world's substep loop and an elastic solver. Two solvers implement it: `cells`, an
// embedded lattice of eight-node cells, and `livegs-v1`, the paper's shape-matching blend and the baseline of
// all charts.

namespace livegs {

struct RigidProxy;
struct SurfacePatch;  // collision/surface_points.h

// Default budget of node-substeps (nodes times substeps, summed) per frame for the elastic bodies of a scene.
// kNodeSubstep_ms (server/scene) is the time that one takes. A larger budget allows finer cells and costs
// time in proportion.
inline constexpr double kMaxNodeSubsteps = 250e3;

// Switches for ablation studies; `cells` only.
struct CellsOptions {
  bool second_order = true;  // BDF2; false: BDF1 throughout
  bool compensate = true;    // subtract the numerical compliance of the sweep
  bool thin = true;          // thin cells use the plate element (plate_cell.h)
  uint64_t scramble = 0;     // > 0: seed; each free node starts at a random place within twice the body's box
  // Choose substeps and clip the stiffness as stability needs; false: use the values as given.
  bool choose = true;
};

struct ElasticBodyDescription {
  uint32_t object_id = 0;
  ParticleSet particles;  // object frame, at rest
  // Contact surface of the particles (prepare_body); null: the body makes it.
  std::shared_ptr<const std::vector<SurfacePatch>> patches;
  Material material;
  Pose world_from_object;                                            // pose of the rest shape at the start
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();            // centre of mass, world frame
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();  // world frame
  std::vector<Eigen::Vector3d> particle_velocities_m_s;  // added to the above; empty or one per particle
  // Deforms the rest shape about its centre.
  Eigen::Matrix3d initial_deformation = Eigen::Matrix3d::Identity();
  std::vector<BodyRegion> regions;  // where materials overlap, the later region applies
  double cell_width_m = 0.0;        // 0: chosen from the material and the rate (lattice_resolution.h)
  int substeps = 0;                 // per frame, a multiple of the scene's; 0: chosen
  // Per frame (share_elastic_budget.h); not applied if cell_width_m is given.
  double max_node_substeps = kMaxNodeSubsteps;
  bool own_budget = false;  // max_node_substeps is the body's own, not a part of the scene's
  double scene_node_substeps = kMaxNodeSubsteps;  // budget of the whole scene; only for the report
  CellsOptions cells;
};

// A damped spring from a material point to a moving target, world frame. The body integrates it implicitly in
// each of its own steps: the force follows the position and velocity at the end of the step, limited by the
// effective mass at the point.
struct PointSpring {
  // At the start of the substep.
  Eigen::Vector3d target_m = Eigen::Vector3d::Zero(), target_velocity_m_s = Eigen::Vector3d::Zero();
  double stiffness_n_m = 0.0, damping_n_s_m = 0.0, max_force_n = 0.0;
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  // of the last step; warm start of the next one
};

// A force on one material point (rest frame of the object): constant over the substep, or the force of a
// spring.
struct PointForce {
  Eigen::Vector3d point_m;
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  // world frame
  PointSpring* spring = nullptr;                      // only for bodies with takes_springs()
};

class ElasticBody;
struct ElasticNeighbour {
  ElasticBody* body;
  uint64_t body_id;  // as RigidProxy::body_id
};

// Everything that acts on a body in one substep. Rigid bodies and neighbours immediately receive the opposite
// of every impulse on this body; no other thread may use them during the substep. Neighbours step together
// with the body.
struct SubstepContext {
  double start_s = 0.0;  // simulation time at the start of the substep
  double duration_s = 0.0;
  Eigen::Vector3d gravity_m_s2;
  std::span<const Collider> colliders;
  std::span<RigidProxy* const> bodies;       // rigid bodies that may be touched in this substep
  std::span<const ElasticNeighbour> others;  // elastic bodies of the same solver
  std::span<const PointForce> forces;
  std::vector<uint64_t>* touched_ids =
      nullptr;  // output of this body: ids of the bodies pushed, with duplicates
};

// One of the equal steps that a substep is divided into.
struct SubstepPart {
  double began_s = 0.0;  // offset from the start of the substep
  double duration_s = 0.0;
};

struct ParticleState {
  Eigen::Vector3d position_m, velocity_m_s;
  double mass_kg;
  Eigen::Matrix3d deformation_gradient;  // rest object frame to world
};

// Contact impulses since the last query: sum of magnitudes, and first moment for the mean point.
struct ContactTotal {
  double impulse_n_s = 0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  // sum of magnitude times point, world frame
};

struct BodyEnergy {
  double kinetic_j = 0, elastic_j = 0, gravity_j = 0;
  double plastic_work_j = 0;  // work of plastic flow since the start; never decreases
  Eigen::Vector3d linear_momentum = Eigen::Vector3d::Zero();   // kg m/s
  Eigen::Vector3d angular_momentum = Eigen::Vector3d::Zero();  // kg m²/s about the world's origin
};

// Predicted accuracy at the chosen cells and substeps; known before the simulation runs
// (elastic/resolution/modulus_band.cpp).
enum class ElasticBand {
  Exact,    // Young's modulus within 5 % in tension along the longest side
  Band,     // between modulus_ratio_low and modulus_ratio_high
  Clipped,  // the requested stiffness is not reachable; reached_youngs_modulus_pa is simulated
  Unknown,  // no prediction: another solver, or too few cells and too long steps to reach equilibrium
};
struct MaterialAccuracy {
  ElasticBand band = ElasticBand::Unknown;
  double youngs_modulus_pa = 0;          // E*, requested
  double reached_youngs_modulus_pa = 0;  // predicted; below the request when clipped
  // E_app / E*, predicted, in tension along the longest side.
  double modulus_ratio_low = 0, modulus_ratio_high = 0;
  double modulus_ratio_across = 0;  // upper bound across the shortest side; 0: unknown
  bool clipped = false;
};
struct RegionAccuracy : MaterialAccuracy {
  std::string name;  // of the region, or "region 2" by its index
};
struct ElasticAccuracy : MaterialAccuracy {  // of the body's own material
  std::vector<RegionAccuracy> regions;       // regions with a material
  double cell_width_m = 0;
  int substeps = 0;    // per frame, of this body
  double courant = 0;  // sqrt(E/rho) h / a, largest over the materials
  size_t nodes = 0, cells = 0, particles = 0;
  size_t bytes = 0;          // size of the solver state: nodes, cells, contact samples
  double node_substeps = 0;  // nodes times substeps per frame, from the bounding box
  // Cell width if the body had the scene's whole budget; 0: the same as now.
  double unbudgeted_cell_width_m = 0;
  double unbudgeted_reached_pa = 0;  // stiffness reached with unbudgeted_cell_width_m
  // Cells are too wide for the thickness, or a frame costs too much (lattice_resolution.h)
  bool over_budget = false;
  // rho g L / E with L the shortest side and g = 9.81 m/s²: strain under the body's own weight on a table.
  double sag = 0;
  // Volume fraction of sheets and cords with unpredicted bending stiffness (lattice_resolution.h)
  double thin_part = 0;
  int recovery_count = 0;  // number of resets to the rest shape after the simulation diverged
};
const char* name_of(ElasticBand band);

// One elastic body. Not thread-safe; different bodies may run on different threads. Internal lengths are
// relative to an origin that follows the body, so precision does not depend on the position in the world.
class ElasticBody {
 public:
  virtual ~ElasticBody() = default;

  void substep(const SubstepContext& context);  // for a body without neighbours
  // A substep in parts, for bodies that step together (step_elastic_bodies.h). begin_substep returns the
  // number of steps that the body needs; 0: nothing left to do (asleep, or advanced as a rigid body). The
  // caller then takes at least that many steps. Each is:
  //
  // - begin_step: everything except contact
  // - prepare_contact_step, on several threads: it changes only its own body
  // - list_contacts: contact with moving bodies; bodies may run on different threads
  // - separate, one body after the other
  // - read_contact_impulses; on several threads unless rigid bodies take part
  // - end_step: contact with colliders, then the update of positions and velocities
  virtual int begin_substep(const SubstepContext& context) = 0;
  virtual void begin_step(const SubstepPart& part, const SubstepContext& context) = 0;
  // Afterwards other bodies may read the surface of this one while they list their contacts.
  virtual void prepare_contact_step(double step_s) { (void)step_s; }
  virtual void list_contacts(const SubstepPart& part, const SubstepContext& context,
                             std::vector<ContactConstraint>& rows) = 0;
  // Removes the rows with bodies on which this body is stuck, and pulls it away from them.
  virtual void separate(const SubstepPart& part, const SubstepContext& context,
                        std::vector<ContactConstraint>& rows) {
    (void)part, (void)context, (void)rows;
  }
  // Receives the rows that this body listed, after the solve. Called between separate and end_step.
  virtual void read_contact_impulses(std::span<const ContactConstraint> rows) { (void)rows; }
  virtual void end_step(const SubstepPart& part, const SubstepContext& context) = 0;
  virtual void end_substep(const SubstepContext& context) = 0;
  virtual void end_frame(double frame_s) = 0;  // includes plastic flow and the sleep test

  virtual ContactTotal take_contact_total() { return {}; }
  // Whether PointForce::spring is integrated; otherwise only force_n acts.
  virtual bool takes_springs() const { return false; }

  // Contact queries. The defaults are those of a solver without contact between moving bodies.
  virtual double reach_m() const { return 0.0; }  // radius about the centre of mass that encloses the body
  virtual Eigen::AlignedBox3d bounds_m() const { return {}; }  // enclosing box, world axes
  virtual void prepare_bounds() {}  // stores what surface_bounds_m reads; changes only this body
  // Bounds of the surface within a box; empty if the surface does not reach into it. After prepare_bounds,
  // until the next step, several threads may call it.
  virtual Eigen::AlignedBox3d surface_bounds_m(const Eigen::AlignedBox3d& within) const {
    return bounds_m().intersection(within);
  }
  // Called when another body is near; the surface must match the drawn shape.
  virtual void prepare_for_contact() {}
  // Surface elements within a box. During a step: at the current (corrected) positions; between steps: at the
  // positions.
  virtual void surface_elements(const Eigen::AlignedBox3d& within,
                                std::vector<SurfaceElement>& elements) const;
  virtual double element_reach_m() const { return 0.0; }  // see PointSurface
  // Anchor of the material point at `point_m`, near an element, at the same time.
  virtual ContactAnchor anchor_at(uint32_t element, const Eigen::Vector3d& point_m) const;
  // Receiver of impulses in a step, after prepare_contact_step: during the body's own step, or while it
  // sleeps (an impulse wakes it). Precondition: the body has surface elements.
  virtual ContactParticipant& contact_participant();

  // Whether the body is stuck on that body (RigidProxy::body_id) and separates without contact.
  virtual bool is_separating(uint64_t body_id) const {
    (void)body_id;
    return false;
  }
  // A uniform velocity change, without deformation; during a step of `step_s` or between steps.
  virtual void apply_uniform_impulse(const Eigen::Vector3d& impulse_n_s, double step_s) {
    (void)impulse_n_s, (void)step_s;
  }

  // Sleep of islands: with `wait` the body does not fall asleep on its own. It reports can_sleep() until
  // sleep() is called.
  virtual void defer_sleep(bool wait);
  virtual bool can_sleep() const { return asleep(); }
  virtual void sleep() {}

  // Sets the rest shape at a pose, with the motion of a rigid body. False: this solver cannot.
  virtual bool place(const Pose& world_from_object, const Eigen::Vector3d& velocity_m_s,
                     const Eigen::Vector3d& angular_velocity_rad_s) {
    (void)world_from_object, (void)velocity_m_s, (void)angular_velocity_rad_s;
    return false;
  }

  // Permanently releases a fixed or moved region; its other properties stay. False if there is no such
  // region.
  virtual bool release_region(const std::string& name) = 0;
  virtual void set_material(const Material& material) = 0;
  // Node-substeps per frame; applies from the next set_material on. Ignored if the cell width was given.
  virtual void set_node_substep_budget(double node_substeps) { (void)node_substeps; }
  virtual double node_substeps() const { return 0.0; }  // current cost per frame
  virtual const Material& material() const = 0;
  virtual bool asleep() const = 0;
  virtual int recovery_count() const { return 0; }  // ElasticAccuracy::recovery_count
  virtual void wake() = 0;
  // Whether the body moves as a rigid body because its deformation is not visible.
  virtual bool frozen() const { return false; }

  // RestBody without object_from_asset, which the owner sets. Drivers are in the world frame.
  virtual RestBody rest_body() const = 0;
  virtual void write_drivers(ObjectDrivers& drivers) const = 0;

  virtual Pose centre_pose() const = 0;  // centre of mass and best-fit rotation of the body as a whole
  virtual Eigen::Vector3d centre_m() const { return centre_pose().position_m; }  // centre of mass; cheap
  // Includes regions of another density.
  virtual double mass_kg() const { return material().mass_kg; }
  virtual Eigen::Vector3d velocity_m_s() const = 0;  // of the centre of mass
  virtual Eigen::Vector3d angular_velocity_rad_s() const = 0;
  virtual std::vector<ParticleState> particles() const = 0;
  virtual BodyEnergy energy(const Eigen::Vector3d& gravity_m_s2) const = 0;
  virtual ElasticAccuracy accuracy() const = 0;

  // Current position and velocity of a material point (rest frame of the object).
  virtual Eigen::Vector3d world_point(const Eigen::Vector3d& rest_point_m) const = 0;
  virtual Eigen::Vector3d point_velocity_m_s(const Eigen::Vector3d& rest_point_m) const = 0;
  // First particle hit by a ray, within the particle spacing, as a rest point; empty if the ray misses.
  struct RayHit {
    double distance_m;
    Eigen::Vector3d rest_point_m;
  };
  virtual std::optional<RayHit> ray_cast(const Eigen::Vector3d& origin_m,
                                         const Eigen::Vector3d& direction) const = 0;
};

// Fails with the reason if the description is not physical (no particles, a value out of range, …).
Result<void> check_elastic_body(const ElasticBodyDescription& description);
// Also fails if `rate_hz` or `substeps` is out of range.
Result<void> check_elastic_body(const ElasticBodyDescription& description, double rate_hz, int substeps);

// Makes a body of one solver; fails as check_elastic_body. `rate_hz` and `substeps` are the scene's. A body
// may take more substeps, never fewer.
using ElasticBodyFactory = Result<std::unique_ptr<ElasticBody>> (*)(const ElasticBodyDescription& description,
                                                                    double rate_hz, int substeps,
                                                                    bool may_sleep);
// The product's solver, `cells`; for others see server/baseline and server/study/peers.
Result<std::unique_ptr<ElasticBody>> make_elastic_body(const ElasticBodyDescription& description,
                                                       double rate_hz, int substeps, bool may_sleep);

}  // namespace livegs
