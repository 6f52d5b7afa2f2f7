// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <vector>

// Loads that may break a rigid body: impacts, summed over a window, and sustained loads.
//
// An impact (impact_phase.h) is recorded as its impulse, m v (1 + e) for a single body that closes with v,
// independent of the substep. The impulse per tick of a sustained force (weight, hand, joint) grows with the
// tick, so it counts as the impulse during kImpactDuration_s. Equal stress then breaks equal bonds.

namespace livegs {

struct ContactManifold;
struct ContactPoint;

// Duration of an impulse: over the step, or at once.
enum class ImpulseKind { Support, Impact };

// Duration of an impact of hard objects of a cup's size, s. Hertz, 2.87 (m² / (R E² v))^(1/5) (Johnson 1985,
// Contact mechanics, 11.24), gives 0.1 to 1 ms for a quarter of a kilogram of ceramics at 3 m/s on wood or
// stone. Larger: sustained loads count more.
inline constexpr double kImpactDuration_s = 1e-3;
// Impacts within this window are summed, s: the frame time of the paper, independent of the tick. A cup that
// rocks from corner to corner lands once. Larger: more impacts count together.
inline constexpr double kImpactWindow_s = 1.0 / 60.0;

// Sum of impulses with location and direction. Body axes, relative to the centre of mass.
struct ImpulseAccumulator {
  double impulse_n_s = 0.0;                          // sum of magnitudes
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  // impulse times point
  Eigen::Vector3d push_n_s = Eigen::Vector3d::Zero();
  // Total contact impulse including friction and twist, and its moment. Subtracting both restores the motion
  // before the contacts.
  Eigen::Vector3d total_n_s = Eigen::Vector3d::Zero(), total_moment = Eigen::Vector3d::Zero();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();  // magnitude times direction times direction transposed
  bool from_colliders = true;                        // true if all impulses are from static objects
  // Maximum over the impulses; 1 for loads that dissipate no energy, such as forces.
  double restitution = 0.0;

  void add(double size_n_s, const Eigen::Vector3d& direction, const Eigen::Vector3d& point_m);
  void add(const ImpulseAccumulator& other, double share);
};

// Unit direction of a sum. If the impulses cancel (a squeezed body), the axis of compression.
Eigen::Vector3d direction_of(const ImpulseAccumulator& sum);

// Impact history of one body, kept for breakable bodies only.
class ImpactRecord {
 public:
  // The record_ functions are called during a substep. Impulses act on this body; they and `point_m` (from
  // the centre of mass) are in world axes, and `world_from_body` is the orientation of this body. Forces and
  // hands count as sustained loads, however abrupt.
  void record_force(const Eigen::Quaterniond& world_from_body, const Eigen::Vector3d& impulse_n_s,
                    const Eigen::Vector3d& point_m);
  // A joint transmits impulses from other bodies, including impacts, like a contact.
  void record_joint(const Eigen::Quaterniond& world_from_body, const Eigen::Vector3d& impulse_n_s,
                    const Eigen::Vector3d& point_m, ImpulseKind kind, double remaining_s);
  // `normal` points towards this body. `remaining_s`: from an impact to the end of the substep.
  void record_contact(const Eigen::Quaterniond& world_from_body, const ContactManifold& manifold,
                      const ContactPoint& point, const Eigen::Vector3d& normal,
                      const Eigen::Vector3d& point_m, ImpulseKind kind, double remaining_s);
  // Friction impulse and twist of a manifold on this body at `point_m`.
  void record_friction(const Eigen::Quaterniond& world_from_body, const Eigen::Vector3d& impulse_n_s,
                       const Eigen::Vector3d& twist, const Eigen::Vector3d& point_m, ImpulseKind kind);
  void end_substep(double duration_s);
  // Load of the tick: the strongest kImpactWindow_s of impacts, plus kImpactDuration_s of sustained loads.
  // Contacts count with their mean, because a first touch may be abrupt; forces with their maximum.
  ImpulseAccumulator take(double tick_s);
  // The strongest kImpactWindow_s of an episode of impacts, returned once, after kImpactWindow_s without
  // impact. Excludes sustained loads.
  ImpulseAccumulator take_ended_episode();

 private:
  struct RecentImpact {
    double age_s;
    ImpulseAccumulator sum;
  };
  std::vector<RecentImpact> recent_;  // impacts of the last kImpactWindow_s, one per substep
  // The tick's strongest sum of impacts; sum of the tick's supporting contacts.
  ImpulseAccumulator strongest_, sustained_;
  // Strongest sum of the current episode; strongest of the episodes that ended in this tick.
  ImpulseAccumulator episode_, ended_episode_;
  ImpulseAccumulator forced_;  // of forces, the maximum of the tick, for kImpactDuration_s
  // Sums of the substep: supporting contacts and joints, forces, and impacts with the time from the first one
  // to its end.
  ImpulseAccumulator contacts_, forces_, impacts_;
  double impact_age_s_ = 0.0;
};

}  // namespace livegs
