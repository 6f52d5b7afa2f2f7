// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "physics/collider.h"
#include "physics/collision/conservative_advancement.h"
#include "physics/collision/contact_candidate.h"
#include "physics/collision/convex_polyhedron.h"
#include "physics/rigid/rigid_body.h"

// Contact candidates of two surfaces that touch or will touch within one substep, one function for each kind
// of surface. Normals point from the other body towards the first.

namespace livegs {

// Parameters of a contact search.
struct ContactSearch {
  double duration_s = 0;  // of the substep
  double margin_m = 0;    // closer surfaces are in contact at any speed
};

// A ball of `radius_m` against any surface: the current contact, and the contact ahead of a fast ball.
// `sample` returns the signed distance at a world point; `marching` times it is a lower bound of the true
// distance.
template <class Sample>
void ball_candidates(const Eigen::Vector3d& centre_m, double radius_m, const Sample& sample,
                     const Eigen::Vector3d& relative_velocity_m_s, double marching,
                     const ContactSearch& search, std::vector<ContactCandidate>& candidates) {
  const Eigen::Vector3d displacement = search.duration_s * relative_velocity_m_s;
  const SurfaceSample here = sample(centre_m);
  const double gap = here.distance_m - radius_m;
  if (marching * here.distance_m - radius_m > displacement.norm() + search.margin_m) return;
  if (gap < search.margin_m) {
    candidates.push_back({kBallFeature, centre_m - radius_m * here.normal, here.normal, gap});
  }
  const double slack = displacement.norm() + std::min(0.0, displacement.dot(here.normal));
  if (gap < search.margin_m && slack < 0.5 * radius_m) return;
  const auto bounded = [&](const Eigen::Vector3d& point) {
    SurfaceSample surface = sample(point);
    if (surface.distance_m > 0.0) surface.distance_m = radius_m + marching * (surface.distance_m - radius_m);
    return surface;
  };
  const auto hit = cast_sphere(bounded, centre_m, displacement, radius_m, 0.1 * search.margin_m);
  if (!hit) return;
  if (!candidates.empty() && hit->normal.dot(candidates.front().normal) > kSameDirectionCosine) return;
  candidates.push_back({kAheadFeature, centre_m - radius_m * hit->normal, hit->normal, hit->separation_m});
}

// Surface of a body in its current pose at a world point.
SurfaceSample sample_body(const RigidBody& body, const Eigen::Vector3d& point_m);

// Contacts of the inscribed ball (core) of a body with surfaces that it approaches so far in a substep, or
// rotates so far in, that points found at its start are invalid at its end. Prevents thin bodies from passing
// its centre. Appends.
template <class Sample>
void core_candidates(const RigidBody& body, const Sample& sample,
                     const Eigen::Vector3d& relative_velocity_m_s, double marching,
                     const ContactSearch& search, std::vector<ContactCandidate>& candidates) {
  const double radius = body.shape.inner_radius_m;
  const Eigen::Vector3d displacement = search.duration_s * relative_velocity_m_s;
  const bool turns = search.duration_s * body.angular_velocity_rad_s.norm() >= 0.5;
  const double far_m = 0.5 * radius;
  if (body.shape.is_ball() || !(radius > 0.0) || (displacement.norm() < far_m && !turns)) return;
  std::vector<ContactCandidate> found;
  ball_candidates(body.world_from_body.position_m, radius, sample, relative_velocity_m_s, marching, search,
                  found);
  for (ContactCandidate& candidate : found) {
    if (-displacement.dot(candidate.normal) < far_m && !turns) continue;
    candidate.feature_id += kCoreFeature;
    candidates.push_back(candidate);
  }
}

// One point that moves by `displacement_m` relative to a surface in the substep. The normal is that of the
// surface.
template <class Sample>
std::optional<ContactCandidate> point_candidate(uint64_t id, const Eigen::Vector3d& point_m,
                                                const Sample& sample, const Eigen::Vector3d& displacement_m,
                                                double marching, const ContactSearch& search) {
  const SurfaceSample here = sample(point_m);
  if (here.distance_m < search.margin_m) return ContactCandidate{id, point_m, here.normal, here.distance_m};
  if (marching * here.distance_m > displacement_m.norm()) return std::nullopt;
  const auto bounded = [&](const Eigen::Vector3d& at) {
    SurfaceSample surface = sample(at);
    if (surface.distance_m > 0.0) surface.distance_m *= marching;
    return surface;
  };
  const auto hit = cast_sphere(bounded, point_m, displacement_m, 0.0, 0.1 * search.margin_m);
  if (!hit) return std::nullopt;
  return ContactCandidate{id, point_m, hit->normal, hit->separation_m};
}

// Contact points of each mesh against the surface of the other.
void mesh_candidates(const RigidBody& a, const RigidBody& b, const ContactSearch& search,
                     std::vector<ContactCandidate>& candidates);

// Cores of two meshes, each against the surface of the other.
std::vector<ContactCandidate> core_candidates_of_pair(const RigidBody& a, const RigidBody& b,
                                                      const ContactSearch& search);

// Contacts of two convex polyhedra, or of one and a box collider, whose velocities are zero. A fast pair is
// advanced to its time of impact.
struct MovingPolyhedron {
  PlacedPolyhedron placed;
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();
  double reach_m = 0;  // bounding radius about the origin
};
MovingPolyhedron moving_polyhedron(const RigidBody& body);
void polyhedron_candidates(const MovingPolyhedron& a, const MovingPolyhedron& b, const ContactSearch& search,
                           std::vector<ContactCandidate>& candidates);

// Contacts of a cylinder or capsule are found on its mesh, which has facets. Moves the points of `candidates`
// to the exact surface, so that the body rolls, and joins those that coincide. The body is the first of the
// pair, or else the other one. Contacts with the flat ends of a cylinder, away from their lowest point, stay
// as they are. No effect on other shapes.
enum class PairSide { First, Other };
void move_to_round_surface(const RigidBody& body, PairSide side, std::vector<ContactCandidate>& candidates);

}  // namespace livegs
