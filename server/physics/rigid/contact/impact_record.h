// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

// What may break a rigid body: impacts, summed over a frame, and what lasts.
//
// An impact is recorded as an impulse: what ends the approach of two surfaces, m v (1 + e) for a body alone,
// whatever the substep is. Weight, piles and hands press on; what they give in a tick goes with its length
// and says nothing of how hard they press. A lasting force, a weight's, a hand's or a joint's, counts with
// what it gives in kImpactDuration_s, as long as an impact lasts: as much stress, as much broken.

namespace livegs {

struct RigidBody;
struct ContactManifold;
struct ContactPoint;

// How long hard things the size of a cup touch when they strike: Hertz, 2.87 (m² / (R E² v))^(1/5) (Johnson
// 1985, Contact mechanics, 11.24), is 0.1 to 1 ms for a quarter of a kilogram of ceramics at 3 m/s on wood or
// stone.
inline constexpr double kImpactDuration_s = 1e-3;
// Blows count together over the frame of the paper, whenever in it they come and however long a tick is: a
// cup that rocks from corner to corner lands once.
inline constexpr double kImpactWindow_s = 1.0 / 60.0;

// Impulses added up: how much, where and which way. Body axes, from the centre of mass.
struct ImpulseAccumulator {
  double impulse_n_s = 0.0;                          // sum of sizes
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  // impulse times point
  Eigen::Vector3d push_n_s = Eigen::Vector3d::Zero();
  // All that contacts gave with it, friction and twist too, and its moment: without them it moves as if
  // nothing had struck it.
  Eigen::Vector3d total_n_s = Eigen::Vector3d::Zero(), total_moment = Eigen::Vector3d::Zero();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();  // size times direction times direction transposed
  bool from_colliders = true;                        // all of it, from things that do not move
  double restitution = 0.0;  // the largest of them; 1: of something that takes no energy, as a force

  void add(double size_n_s, const Eigen::Vector3d& direction, const Eigen::Vector3d& point_m);
  void add(const ImpulseAccumulator& other, double share);
};

// Unit. Of what is squeezed, whose pushes cancel, the axis along which it is.
Eigen::Vector3d direction_of(const ImpulseAccumulator& sum);

// Sums are kept of bodies that can break only.
class ImpactRecord {
 public:
  // During a substep. Impulses on this body and `point_m` in world axes, the point from the centre of mass. A
  // force's and a hand's is what it gives, however abruptly.
  void record_force(const RigidBody& body, const Eigen::Vector3d& impulse_n_s,
                    const Eigen::Vector3d& point_m);
  // A joint passes on what comes from elsewhere, impacts among it, as a contact does that struck nothing
  // itself.
  void record_joint(const RigidBody& body, const Eigen::Vector3d& impulse_n_s,
                    const Eigen::Vector3d& point_m);
  // `normal`: towards this body.
  void record_contact(const RigidBody& body, const ContactManifold& manifold, const ContactPoint& point,
                      const Eigen::Vector3d& normal, const Eigen::Vector3d& point_m);
  // What a manifold's friction gave this body, at `point_m`, and its twist.
  void record_friction(const RigidBody& body, const Eigen::Vector3d& impulse_n_s,
                       const Eigen::Vector3d& twist, const Eigen::Vector3d& point_m);
  // The part of what this body's contacts gave in the substep that ended an approach, 0 … 1; the rest carried
  // what pressed on meanwhile.
  double impact_fraction() const { return impact_fraction_; }
  // `island_fraction`: the largest of its island; 0 where nothing in it struck anything.
  void end_substep(const RigidBody& body, double island_fraction, double duration_s);
  // The strongest kImpactWindow_s of impacts that ended within the tick, and kImpactDuration_s of what
  // lasted: of contacts the mean, as a first touch may be abrupt, of forces the largest.
  ImpulseAccumulator take(double tick_s);
  // The strongest kImpactWindow_s of impacts of an episode that is over, when nothing has struck it for as
  // long; once. Of what lasts there is nothing in it.
  ImpulseAccumulator take_ended_episode();

 private:
  struct RecentImpact {
    double age_s;
    ImpulseAccumulator sum;
  };
  std::vector<RecentImpact> recent_;            // impacts of the last kImpactWindow_s, one a substep
  ImpulseAccumulator strongest_, sustained_;    // of the tick: the strongest sum of them; contacts that bore
  ImpulseAccumulator episode_, ended_episode_;  // the strongest sum since nothing had struck it; that of
                                                // episodes that ended in the tick
  ImpulseAccumulator forced_;                   // by forces, the largest of the tick, for kImpactDuration_s
  ImpulseAccumulator contacts_, forces_;        // of the substep; joints are among the contacts
  double impact_fraction_ = 0.0;
  // Of the substep's impacts the one that ended the fastest approach: it is when they came. By the end of
  // substeps of 4 ms, a second landing 13 ms after the first was outside of kImpactWindow_s by turns.
  double fastest_approach_m_s_ = 0.0, impact_time_s_ = 0.0;
  // Of impacts that bounce, the struck share of this substep and of the one before. What such an impact
  // leaves of its approach, as it does when it comes in the last moment of a substep, is a part of the impact
  // however slow it is: v' of the speed V that it would have at the end of the substep, of which v at touch,
  // so that (V - v') v / V + v' v / V = v.
  double bounce_fraction_ = 0.0, previous_bounce_fraction_ = 0.0;
  double sustained_force_n_ = 0.0;  // by its contacts, as long as nothing strikes it
  bool sustained_force_known_ = false;
};

}  // namespace livegs
