// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid/contact/narrow_phase.h"

#include <algorithm>
#include <cmath>

#include "physics/motion/free_rotation.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

// Displacement per substep, relative to the smaller inner radius, above which a pair is advanced.
constexpr double kFastDisplacement = 0.5;

// Points of a round surface closer than this fraction of the radius are one.
constexpr double kSamePoint = 1e-3;

// Maximum approach of points of two bodies during the search.
double reach_m(const RigidBody& a, const RigidBody& b, const ContactSearch& search) {
  return search.duration_s * max_approach_m_s(a, b) + search.margin_m;
}

// Whether the oriented boxes of `a` and `b` are farther apart than `reach_m`, tested in the axes of `b`.
// Rejects most pairs in a pile that pass the broad phase.
bool boxes_apart(const RigidBody& a, const RigidBody& b, double reach_m) {
  const Eigen::Quaterniond b_axes = b.world_from_body.orientation.conjugate();
  const Eigen::Matrix3d into = (b_axes * a.world_from_body.orientation).toRotationMatrix();
  const auto [middle, half] =
      turned_box(a.shape, into, b_axes * (a.world_from_body.position_m - b.world_from_body.position_m));
  const double rounding = 1e-9;
  const double room =
      (1.0 + rounding) * reach_m + rounding * (a.shape.bounding_radius_m + b.shape.bounding_radius_m);
  return ((middle - half).array() > b.shape.max_m.array() + room).any() ||
         ((middle + half).array() < b.shape.min_m.array() - room).any();
}

// Contact points of `from` that are or come within reach of the surface of `to`.
template <class Take>
void points_near(const RigidBody& from, const RigidBody& to, const ContactSearch& search, const Take& take) {
  const Eigen::Quaterniond to_axes = to.world_from_body.orientation.conjugate();
  const Eigen::Matrix3d into = (to_axes * from.world_from_body.orientation).toRotationMatrix();
  const Vector3d shift = to_axes * (from.world_from_body.position_m - to.world_from_body.position_m);
  const Eigen::Matrix3d out = to.world_from_body.orientation.toRotationMatrix();
  const double reach = reach_m(from, to, search);
  const Vector3d low = to.shape.min_m.array() - reach, high = to.shape.max_m.array() + reach;
  const auto sample = [&](const Vector3d& local) {
    const DistanceField::Sample field = to.shape.sample(local);
    return SurfaceSample{field.distance_m, field.gradient};
  };
  std::vector<uint32_t> near;
  from.shape.contact_tree.near(
      [&](const Vector3d& point) { return to.shape.sample(into * point + shift).distance_m; },
      reach + 2.0 * to.shape.sample_error_m(), near);
  for (const uint32_t i : near) {
    const Vector3d local = into * from.shape.contact_points_m[i] + shift;
    if ((local.array() < low.array()).any() || (local.array() > high.array()).any()) continue;
    const Vector3d arm = out * local;  // from the origin of `to`
    const Vector3d point = to.world_from_body.position_m + arm;
    const Vector3d velocity =
        from.point_velocity(point - from.world_from_body.position_m) - to.point_velocity(arm);
    auto found = point_candidate(i, local, sample, to_axes * (search.duration_s * velocity), 1.0, search);
    if (!found) continue;
    found->point_m = point;
    found->normal = out * found->normal;
    take(*found);
  }
}

// Core of `from` against the surface of `to`; normals point to `from`.
void core_against(const RigidBody& from, const RigidBody& to, const ContactSearch& search,
                  std::vector<ContactCandidate>& candidates) {
  const Vector3d between = from.world_from_body.position_m - to.world_from_body.position_m;
  core_candidates(
      from, [&](const Vector3d& point) { return sample_body(to, point); },
      from.velocity_m_s - to.point_velocity(between), 1.0, search, candidates);
}

PlacedPolyhedron advanced(const MovingPolyhedron& body, double time_s) {
  PlacedPolyhedron placed = body.placed;
  placed.position_m += time_s * body.velocity_m_s;
  placed.rotation = rotation_exp(time_s * body.angular_velocity_rad_s).toRotationMatrix() * placed.rotation;
  return placed;
}

// First time within the substep when the distance is below the margin. Distances decrease at most at
// `speed_m_s`.
std::optional<double> time_of_impact(const MovingPolyhedron& a, const MovingPolyhedron& b, double speed_m_s,
                                     const ContactSearch& search) {
  double time = 0.0;
  for (int i = 0; i < 32; ++i) {
    const double left = speed_m_s * (search.duration_s - time);
    const double gap = polyhedron_gap_m(advanced(a, time), advanced(b, time), left + search.margin_m);
    if (gap < search.margin_m) return time;
    time += (gap - 0.5 * search.margin_m) / speed_m_s;
    if (time > search.duration_s) return std::nullopt;
  }
  return time;
}

// Moves `point`, which is near the surface, to the exact surface point that faces along `outward`. Returns
// false if it stays.
bool move_point(const RoundShape& round, const Pose& pose, const Eigen::Vector3d& outward,
                Eigen::Vector3d& point, uint64_t& feature) {
  const Eigen::Vector3d axis = pose.orientation * round.axis, centre = pose * round.centre_m;
  const Eigen::Vector3d from_centre = point - centre;
  const double along = std::clamp(axis.dot(from_centre), -round.half_length_m, round.half_length_m);
  const bool at_end = std::abs(along) > (1.0 - kSamePoint) * round.half_length_m;
  feature = kRoundFeature + (at_end ? (along > 0.0 ? 1u : 0u) : 2u);
  if (round.kind == RoundShape::Kind::Capsule) {
    point = centre + along * axis + round.radius_m * outward;
    return true;
  }
  const double end_cosine = outward.dot(axis);
  const Eigen::Vector3d across = outward - end_cosine * axis;
  const double sine = across.norm();
  if (sine < 1e-3) return false;  // the contact is with a flat end as a whole
  const Eigen::Vector3d lowest = across / sine;
  const Eigen::Vector3d radial = from_centre - axis.dot(from_centre) * axis;
  // At an end only points near the lowest line move: within cos 15 degrees about the axis, a facet of a
  // cylinder with 24 segments.
  if (std::abs(end_cosine) > kSameSideCosine && radial.dot(lowest) < 0.966 * round.radius_m) return false;
  point = centre + along * axis + round.radius_m * lowest;
  return true;
}

}  // namespace

SurfaceSample sample_body(const RigidBody& body, const Vector3d& point_m) {
  const Pose& pose = body.world_from_body;
  const DistanceField::Sample field =
      body.shape.sample(pose.orientation.conjugate() * (point_m - pose.position_m));
  return {field.distance_m, pose.orientation * field.gradient};
}

void mesh_candidates(const RigidBody& a, const RigidBody& b, const ContactSearch& search,
                     std::vector<ContactCandidate>& candidates) {
  const double reach = reach_m(a, b, search);
  if (boxes_apart(a, b, reach) || boxes_apart(b, a, reach)) return;
  points_near(a, b, search, [&](const ContactCandidate& found) { candidates.push_back(found); });
  points_near(b, a, search, [&](ContactCandidate found) {
    found.feature_id += kOtherPoint;
    found.normal = -found.normal;
    candidates.push_back(found);
  });
}

std::vector<ContactCandidate> core_candidates_of_pair(const RigidBody& a, const RigidBody& b,
                                                      const ContactSearch& search) {
  std::vector<ContactCandidate> candidates, seen_from_other;
  core_against(a, b, search, candidates);
  core_against(b, a, search, seen_from_other);
  for (ContactCandidate& candidate : seen_from_other) {
    candidate.feature_id += kOtherPoint - kForeignFeature;
    candidate.normal = -candidate.normal;
    candidates.push_back(candidate);
  }
  return candidates;
}

MovingPolyhedron moving_polyhedron(const RigidBody& body) {
  return {{body.shape.convex.get(), body.world_from_body.orientation.toRotationMatrix(),
           body.world_from_body.position_m},
          body.velocity_m_s,
          body.angular_velocity_rad_s,
          body.shape.bounding_radius_m};
}

void polyhedron_candidates(const MovingPolyhedron& a, const MovingPolyhedron& b, const ContactSearch& search,
                           std::vector<ContactCandidate>& candidates) {
  const double speed = (a.velocity_m_s - b.velocity_m_s).norm() +
                       a.angular_velocity_rad_s.norm() * a.reach_m +
                       b.angular_velocity_rad_s.norm() * b.reach_m;
  const double displacement = search.duration_s * speed;
  const double tolerance = 0.1 * search.margin_m;  // a face is preferred to an edge: its contacts persist
  const double inner = std::min(a.placed.shape->inner_radius_m, b.placed.shape->inner_radius_m);
  if (displacement <= kFastDisplacement * inner) {
    polyhedron_contacts(a.placed, b.placed, search.margin_m + displacement, tolerance, candidates);
    return;
  }
  const auto time = time_of_impact(a, b, speed, search);
  if (!time) return;
  const PlacedPolyhedron a_then = advanced(a, *time);
  // Includes features that may arrive in the rest of the substep, such as the far end of a rotating rod.
  const double left = std::max(kFastDisplacement * inner, speed * (search.duration_s - *time));
  polyhedron_contacts(a_then, advanced(b, *time), search.margin_m + left, tolerance, candidates);
  // The same material points in the current pose, with their separations along the normals.
  for (ContactCandidate& candidate : candidates) {
    const Vector3d arm_then = candidate.point_m - a_then.position_m;
    const Vector3d other_arm = candidate.point_m - b.placed.position_m - *time * b.velocity_m_s;
    const Vector3d velocity = a.velocity_m_s + a.angular_velocity_rad_s.cross(arm_then) - b.velocity_m_s -
                              b.angular_velocity_rad_s.cross(other_arm);
    candidate.separation_m -= *time * velocity.dot(candidate.normal);
    candidate.point_m = a.placed.position_m + a.placed.rotation * (a_then.rotation.transpose() * arm_then);
  }
}

void move_to_round_surface(const RigidBody& body, PairSide side, std::vector<ContactCandidate>& candidates) {
  if (!body.shape.round) return;
  const RoundShape& round = *body.shape.round;
  size_t kept = 0;
  std::vector<Eigen::Vector3d> moved;
  for (const ContactCandidate& found : candidates) {
    ContactCandidate candidate = found;
    const bool first = side == PairSide::First;
    // The point of the other body lies at the separation behind the point of the first.
    const Eigen::Vector3d outward = first ? Eigen::Vector3d(-candidate.normal) : candidate.normal;
    const Eigen::Vector3d before =
        first ? candidate.point_m : candidate.point_m - candidate.separation_m * candidate.normal;
    Eigen::Vector3d after = before;
    uint64_t feature = 0;
    if (move_point(round, body.world_from_body, outward, after, feature)) {
      const auto same = [&](const Vector3d& other) {
        return (other - after).norm() < kSamePoint * round.radius_m;
      };
      if (std::ranges::any_of(moved, same)) continue;
      moved.push_back(after);
      candidate.separation_m -= outward.dot(after - before);
      if (first) {
        candidate.point_m = after;
        candidate.feature_id = feature;
      }
    }
    candidates[kept++] = candidate;
  }
  candidates.resize(kept);
}

}  // namespace livegs
