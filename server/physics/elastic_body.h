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

// The seam between the world's substep loop and an elastic solver. Two solvers stand behind it: `cells` (an
// embedded lattice of eight-node cells) and `livegs-v1` (the paper's shape-matching blend, the baseline of
// every chart).

namespace livegs {

struct RigidProxy;

// Nodes times substeps a frame that elastic bodies may take unless a scene says otherwise: 6.5 ms of one core
// at 26 ns.
inline constexpr double kMaxNodeSubsteps = 250e3;

// What studies switch off to show what it is worth; `cells` only.
struct CellsOptions {
  bool second_order = true;  // BDF2; false: BDF1 throughout
  bool compensate = true;    // subtract the numerical compliance of the sweep
  bool thin = true;          // cells that hold a thin sheet or cord know how it lies (thin_cell.h)
  uint64_t scramble = 0;     // > 0: a seed; every free node starts anywhere in twice the body's box
  bool choose =
      true;  // more substeps, or a clipped stiffness, where it needs them; false: as given, however wrong
};

struct ElasticBodyDescription {
  uint32_t object_id = 0;
  ParticleSet particles;  // object frame, at rest
  Material material;
  Pose world_from_object;                                            // where the rest shape starts
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();            // world frame, of the centre of mass
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();  // world frame
  std::vector<Eigen::Vector3d> particle_velocities_m_s;  // added to the above; empty or one a particle
  Eigen::Matrix3d initial_deformation = Eigen::Matrix3d::Identity();  // of the rest shape about its centre
  std::vector<BodyRegion> regions;  // of two materials in one place the later one counts
  double cell_width_m = 0.0;        // 0: chosen from the material and the rate
  double max_node_substeps =
      kMaxNodeSubsteps;  // a frame (elastic_budget.h); a body whose cells are given takes any
  double scene_node_substeps = kMaxNodeSubsteps;  // for all bodies of its scene; only told
  CellsOptions cells;
};

// A damped spring from a material point to a moving place, world frame. The body solves it in each of its own
// steps: the force goes to what positions and velocities at the end of the step ask for, as far as the mass
// at the point bears it.
struct PointSpring {
  Eigen::Vector3d target_m = Eigen::Vector3d::Zero(),
                  target_velocity_m_s = Eigen::Vector3d::Zero();  // as the substep begins
  double stiffness_n_m = 0.0, damping_n_s_m = 0.0, max_force_n = 0.0;
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  // of the last step; the next one starts from it
};

// A force on one material point, constant over the substep, or a spring's. The point is in the object's rest
// frame.
struct PointForce {
  Eigen::Vector3d point_m;
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  // world frame
  PointSpring* spring = nullptr;                      // of a body that takes springs
};

class ElasticBody;
struct ElasticNeighbour {
  ElasticBody* body;
  uint64_t body_id;  // as RigidProxy
};

// What acts on a body in one substep. Moving bodies and neighbours get, at once, the opposite of every
// impulse that this body gets from them; nobody else may use them meanwhile. Neighbours take their steps
// together with it.
struct SubstepContext {
  double start_s = 0.0;  // time of simulation when the substep begins
  double duration_s = 0.0;
  Eigen::Vector3d gravity_m_s2;
  std::span<const Collider> colliders;
  std::span<RigidProxy* const> bodies;       // rigid ones it may touch in this substep
  std::span<const ElasticNeighbour> others;  // elastic ones, of the same solver
  std::span<const PointForce> forces;
  std::vector<uint64_t>* touched_ids = nullptr;  // gets the ids of those it pushed, once or oftener
};

// One of the equal steps that a substep is taken in.
struct SubstepPart {
  double began_s = 0.0;  // since the substep began
  double duration_s = 0.0;
};

struct ParticleState {
  Eigen::Vector3d position_m, velocity_m_s;
  double mass_kg;
  Eigen::Matrix3d deformation_gradient;  // rest object frame to world
};

// What colliders gave a body since it was last asked: sizes of impulses, and where they acted on average.
struct ContactTotal {
  double impulse_n_s = 0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  // sum of size times point, world
};

struct BodyEnergy {
  double kinetic_j = 0, elastic_j = 0, gravity_j = 0;
  double plastic_work_j = 0;                                  // spent on flowing since the start; never falls
  Eigen::Vector3d linear_momentum = Eigen::Vector3d::Zero();  // kg m/s
  Eigen::Vector3d angular_momentum = Eigen::Vector3d::Zero();  // kg m²/s about the world's origin
};

// How far the numbers can be trusted at the chosen cells and substeps, known before anything runs
// (elastic-study.md 2.4, 2.7).
enum class ElasticBand {
  Exact,    // Young's modulus within 5 %, pulled along the longest side
  Band,     // between modulus_ratio_low and modulus_ratio_high
  Clipped,  // the stiffness asked for is out of reach; reached_youngs_modulus_pa is simulated
  Unknown,  // no law is known: another solver, or cells and steps that never rest
};
struct MaterialAccuracy {
  ElasticBand band = ElasticBand::Unknown;
  double youngs_modulus_pa = 0;          // E*, asked for
  double reached_youngs_modulus_pa = 0;  // predicted; less than asked for when clipped
  double modulus_ratio_low = 0,
         modulus_ratio_high = 0;    // E_app / E*, predicted, pulled along its longest side
  double modulus_ratio_across = 0;  // the most that it shows across its shortest one; 0: unknown
  bool clipped = false;
};
struct RegionAccuracy : MaterialAccuracy {
  std::string name;  // of the region, or "region 2" by its place
};
struct ElasticAccuracy : MaterialAccuracy {  // of the body's own material
  std::vector<RegionAccuracy> regions;       // those with a material
  double cell_width_m = 0;
  int substeps = 0;    // a frame, of this body
  double courant = 0;  // sqrt(E/rho) h / a, of the material with the fastest waves
  size_t nodes = 0, cells = 0, particles = 0;
  size_t bytes = 0;          // of solver state: nodes, cells, contact samples
  double node_substeps = 0;  // nodes times substeps, a frame, by its bounding box
  double unbudgeted_cell_width_m =
      0;  // what it would have with a scene's whole budget to itself; 0: what it has
  double unbudgeted_reached_pa = 0;  // and the stiffness; with unbudgeted_cell_width_m
  bool over_budget =
      false;       // its cells are wider than its detail asks, or a frame would not do (cell_choice.h)
  double sag = 0;  // rho g L / E, L its shortest side, g 9.81: what its own weight strains it by on a table
  double thin_part = 0;    // of its volume: of sheets and cords whose bending is not known (cell_choice.h)
  int recovery_count = 0;  // times that its motion ran out of bounds, and it was put back at rest
};
const char* name_of(ElasticBand band);

// One elastic body. One thread at a time; different bodies may run on different threads. All lengths inside
// are relative to an origin that follows the body, so precision does not depend on where it stands.
class ElasticBody {
 public:
  virtual ~ElasticBody() = default;

  void substep(const SubstepContext& context);  // of a body without neighbours
  // The same in parts, for bodies that take it together (step_elastic_bodies.h): begin_substep tells how many
  // steps the body needs, 0 when there is no more to do (it sleeps, or has flown on as a rigid body). Each
  // step of as many or more is begin_step (all but contact), list_contacts with what moves,
  // read_contact_impulses, end_step (colliders, and what they all did).
  virtual int begin_substep(const SubstepContext& context) = 0;
  virtual void begin_step(const SubstepPart& part, const SubstepContext& context) = 0;
  virtual void list_contacts(const SubstepPart& part, const SubstepContext& context,
                             std::vector<ContactConstraint>& rows) = 0;
  // The rows it listed, solved. After list_contacts, before end_step.
  virtual void read_contact_impulses(std::span<const ContactConstraint> rows) { (void)rows; }
  virtual void end_step(const SubstepPart& part, const SubstepContext& context) = 0;
  virtual void end_substep(const SubstepContext& context) = 0;
  virtual void end_frame(double frame_s) = 0;  // plasticity and the sleep test happen here

  virtual ContactTotal take_contact_total() { return {}; }
  virtual bool takes_springs() const {
    return false;
  }  // PointForce::spring; one that does not gets forces alone

  // For bodies that touch. Defaults: a solver that meets nothing that moves.
  virtual double reach_m() const { return 0.0; }  // about the centre; nothing of it is farther away
  virtual Eigen::AlignedBox3d bounds_m() const { return {}; }  // world axes; nothing of it is outside
  // Of what of its surface may be within a box; empty: none is.
  virtual Eigen::AlignedBox3d surface_bounds_m(const Eigen::AlignedBox3d& within) const {
    return bounds_m().intersection(within);
  }
  virtual void prepare_for_contact() {}  // something is near: its surface must be where it is drawn
  // Elements of the surface within a box: in the middle of a step where it has come to, between steps where
  // it stands.
  virtual void surface_elements(const Eigen::AlignedBox3d& within,
                                std::vector<SurfaceElement>& elements) const;
  virtual double element_reach_m() const { return 0.0; }  // see PointSurface
  // The material point at `point_m`, near an element, at the same moment.
  virtual ContactAnchor anchor_at(uint32_t element, const Eigen::Vector3d& point_m) const;
  // Takes impulses in a step of `step_s`: in the middle of its own, or as a sleeper, which wakes. Valid for
  // that step.
  virtual ContactParticipant& contact_participant(double step_s);  // is not asked of a body without elements

  // Whether it is stuck on that body, by RigidProxy::body_id, and comes off without contact meanwhile.
  virtual bool is_separating(uint64_t body_id) const {
    (void)body_id;
    return false;
  }
  // An impulse to all of it alike, which deforms nothing; in a step of `step_s` or between two.
  virtual void apply_uniform_impulse(const Eigen::Vector3d& impulse_n_s, double step_s) {
    (void)impulse_n_s, (void)step_s;
  }

  // Sleep in company: with `wait` the body does not fall asleep by itself when it has been still for long
  // enough, but says so, until it is told to.
  virtual void defer_sleep(bool wait);
  virtual bool can_sleep() const { return asleep(); }
  virtual void sleep() {}

  // Lets go of a fixed or moved region for good; its other properties stay. False when there is none of that
  // name.
  virtual bool release_region(const std::string& name) = 0;
  virtual void set_material(const Material& material) = 0;
  // In node-substeps a frame, from its next material on; no matter where its cells were given.
  virtual void set_node_substep_budget(double node_substeps) { (void)node_substeps; }
  virtual double node_substeps() const { return 0.0; }  // that it takes
  virtual const Material& material() const = 0;
  virtual bool asleep() const = 0;
  virtual int recovery_count() const { return 0; }  // ElasticAccuracy::recovery_count
  virtual void wake() = 0;
  virtual bool frozen() const {
    return false;
  }  // flies as a rigid body, because its deformation cannot be seen

  // RestBody without object_from_asset, which its owner fills in. Drivers in the world frame.
  virtual RestBody rest_body() const = 0;
  virtual void write_drivers(ObjectDrivers& drivers) const = 0;

  virtual Pose centre_pose() const = 0;  // centre of mass and best-fit rotation of the body as a whole
  virtual Eigen::Vector3d centre_m() const { return centre_pose().position_m; }  // of mass; cheap
  virtual double mass_kg() const {
    return material().mass_kg;
  }                                                  // with what regions of another density change
  virtual Eigen::Vector3d velocity_m_s() const = 0;  // of the centre of mass
  virtual Eigen::Vector3d angular_velocity_rad_s() const = 0;
  virtual std::vector<ParticleState> particles() const = 0;
  virtual BodyEnergy energy(const Eigen::Vector3d& gravity_m_s2) const = 0;
  virtual ElasticAccuracy accuracy() const = 0;

  // Where a material point (rest object frame) is now, and its velocity.
  virtual Eigen::Vector3d world_point(const Eigen::Vector3d& rest_point_m) const = 0;
  virtual Eigen::Vector3d point_velocity_m_s(const Eigen::Vector3d& rest_point_m) const = 0;
  // The particle met first by a ray (within its spacing), as its rest point; nothing if the ray misses.
  struct RayHit {
    double distance_m;
    Eigen::Vector3d rest_point_m;
  };
  virtual std::optional<RayHit> ray_cast(const Eigen::Vector3d& origin_m,
                                         const Eigen::Vector3d& direction) const = 0;
};

enum class ElasticSolver {
  Cells,
  LivegsV1,        // literally: the same blend whatever the substep
  LivegsV1Steady,  // its blend converted once to a stiffness at the paper's own step, 1/240 s
};

// Fails on a description that is not physical (no particles, mass <= 0, …), with the reason.
Result<void> check_elastic_body(const ElasticBodyDescription& description);

}  // namespace livegs
