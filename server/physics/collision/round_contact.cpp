// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/collision/round_contact.h"

#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

// Cosine between normal and axis above which the contact is with an end, not with the side.
constexpr double kEndCosine = 0.5;
// Cosine of the largest angle, about the axis, between a mesh point and the lowest line of the side: a facet
// of a cylinder with 24 segments.
constexpr double kFacetCosine = 0.966;
// Sine of the angle between a contact normal and the flat end of a cylinder below which the contact is with
// the end as a whole.
constexpr double kFlatEnd = 1e-3;
// Points closer than this fraction of the radius are one.
constexpr double kSamePoint = 1e-3;

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
  if (sine < kFlatEnd) return false;
  const Eigen::Vector3d lowest = across / sine;
  const Eigen::Vector3d radial = from_centre - axis.dot(from_centre) * axis;
  if (std::abs(end_cosine) > kEndCosine && radial.dot(lowest) < kFacetCosine * round.radius_m) return false;
  point = centre + along * axis + round.radius_m * lowest;
  return true;
}

}  // namespace

void move_to_round_surface(const RoundShape& round, const Pose& world_from_body, PairSide side,
                           std::vector<ContactCandidate>& candidates) {
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
    if (move_point(round, world_from_body, outward, after, feature)) {
      const bool same = std::any_of(moved.begin(), moved.end(), [&](const Eigen::Vector3d& other) {
        return (other - after).norm() < kSamePoint * round.radius_m;
      });
      if (same) continue;
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
