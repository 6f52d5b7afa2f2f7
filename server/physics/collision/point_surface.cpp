// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/collision/point_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "physics/collision/contact_candidate.h"

namespace livegs {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kFacingCosine = -0.3;  // maximum cosine between normals of opposite faces
// Maximum distance behind a facing face, over the distance behind the nearest face. Makes the distance of a
// point that passes an edge sideways continuous, as far as it is searched for again. Larger: corners beside
// an edge are thrown up and flutter. Smaller: bodies overlap at their edges.
constexpr double kMaxEdgeSlope = 10.0;

bool faces(std::span<const SurfaceElement> own, const Vector3d& normal) {
  for (const SurfaceElement& face : own) {
    if (face.normal.dot(normal) < kFacingCosine) return true;
  }
  return false;
}

}  // namespace

PointSurface::PointSurface(const std::vector<SurfaceElement>& elements, double reach_m)
    : elements_(elements), reach_m_(reach_m) {
  Eigen::AlignedBox3d box;
  for (const SurfaceElement& element : elements) box.extend(element.position_m);
  if (elements.empty()) box.extend(Vector3d::Zero().eval());
  low_m_ = box.min();
  const Vector3d size = box.sizes();
  cell_m_ = std::max(reach_m, size.maxCoeff() / 31);  // at most 32 cells an axis
  counts_ = (size / cell_m_).array().floor().cast<int>() + 1;
  const auto cell_of = [&](const Vector3d& p) {
    const Vector3i at = ((p - low_m_) / cell_m_).array().floor().cast<int>().min(counts_.array() - 1).max(0);
    return at.x() + counts_.x() * (at.y() + counts_.y() * at.z());
  };
  begins_.assign(static_cast<size_t>(counts_.prod()) + 1, 0);
  for (const SurfaceElement& element : elements) ++begins_[cell_of(element.position_m) + 1];
  for (size_t i = 1; i < begins_.size(); ++i) begins_[i] += begins_[i - 1];
  sorted_.resize(elements.size());
  std::vector<uint32_t> next(begins_.begin(), begins_.end() - 1);
  for (uint32_t i = 0; i < elements.size(); ++i) sorted_[next[cell_of(elements[i].position_m)]++] = i;
  x_m_.reserve(elements.size());
  y_m_.reserve(elements.size());
  z_m_.reserve(elements.size());
  for (const uint32_t i : sorted_) {
    x_m_.push_back(elements[i].position_m.x());
    y_m_.push_back(elements[i].position_m.y());
    z_m_.push_back(elements[i].position_m.z());
  }
}

template <class Visit>
void PointSurface::visit_near(const Vector3d& point_m, const Visit& visit) const {
  if (elements_.empty()) return;
  const Vector3d low = (point_m - low_m_).array() - reach_m_, high = (point_m - low_m_).array() + reach_m_;
  const Eigen::Array3i first = (low / cell_m_).array().floor().max(-1.0).min(1e6).cast<int>().max(0);
  const Eigen::Array3i last =
      (high / cell_m_).array().floor().max(-1.0).min(1e6).cast<int>().min(counts_.array() - 1);
  for (int z = first.z(); z <= last.z(); ++z) {
    for (int y = first.y(); y <= last.y(); ++y) {
      if (first.x() > last.x()) continue;
      const int row = counts_.x() * (y + counts_.y() * z);  // its cells are next to each other
      const uint32_t end = begins_[row + last.x() + 1];
      std::array<double, 64> squares;
      for (uint32_t block = begins_[row + first.x()]; block < end; block += squares.size()) {
        const uint32_t count = std::min<uint32_t>(squares.size(), end - block);
        for (uint32_t k = 0; k < count; ++k) {
          const double dx = x_m_[block + k] - point_m.x(), dy = y_m_[block + k] - point_m.y(),
                       dz = z_m_[block + k] - point_m.z();
          squares[k] = dx * dx + dy * dy + dz * dz;
        }
        for (uint32_t k = 0; k < count; ++k) {
          if (squares[k] < reach_m_ * reach_m_) visit(sorted_[block + k], squares[k]);
        }
      }
    }
  }
}

std::optional<SurfaceDepth> PointSurface::depth(const Vector3d& point_m,
                                                std::span<const SurfaceElement> own) const {
  std::array<uint32_t, 48> near;
  std::array<double, near.size()> squares;
  int count = 0, nearest = -1;
  double least = reach_m_ * reach_m_;
  visit_near(point_m, [&](uint32_t i, double square) {
    if (count < std::ssize(near)) {
      near[count] = i;
      squares[count] = square;
      if (square < least) {
        least = square;
        nearest = count;
      }
      ++count;
    } else if (square < least) {
      near[nearest] = i;
      squares[nearest] = least = square;
    }
  });
  if (nearest < 0) return std::nullopt;
  const SurfaceElement& first_lead = elements_[near[nearest]];
  if (first_lead.normal.squaredNorm() < 0.5) {  // balls: only the nearest counts
    const Vector3d away = point_m - first_lead.position_m;
    const double distance = away.norm();
    return SurfaceDepth{distance - first_lead.radius_m,
                        distance > 0.0 ? Vector3d(away / distance) : Vector3d::UnitY(), first_lead.index};
  }
  // Groups elements into faces, nearest first. Faces beyond a concave edge do not count.
  std::optional<SurfaceDepth> deepest, facing;
  std::array<bool, near.size()> taken{};
  const double hollow_m = 1e-3 * reach_m_;  // an edge less concave than this counts as convex
  int leader = nearest;
  for (int face = 0; face < 3 && leader >= 0; ++face) {  // at most three meet at a point
    const SurfaceElement& lead = elements_[near[leader]];
    double weights = 0.0, distance = 0.0;
    Vector3d normal = Vector3d::Zero();
    for (int k = 0; k < count; ++k) {
      const SurfaceElement& element = elements_[near[k]];
      if (element.normal.dot(lead.normal) < kSameSideCosine) continue;
      taken[k] = true;
      const double part = 1.0 - squares[k] / (reach_m_ * reach_m_), weight = part * part;
      weights += weight;
      distance += weight * element.normal.dot(point_m - element.position_m);
      normal += weight * element.normal;
    }
    const Vector3d across = lead.position_m - first_lead.position_m;
    const bool convex = across.dot(first_lead.normal) <= hollow_m && across.dot(lead.normal) >= -hollow_m;
    if (convex) {
      const double length = normal.norm();
      SurfaceDepth found{distance / weights, normal / length, lead.index};
      if (!(length > 0.0)) found = {lead.normal.dot(point_m - lead.position_m), lead.normal, lead.index};
      if (!deepest || found.distance_m > deepest->distance_m) deepest = found;
      if (faces(own, found.normal) && (!facing || found.distance_m > facing->distance_m)) facing = found;
    }
    leader = -1;
    for (int k = 0; k < count; ++k) {
      if (!taken[k] && (leader < 0 || squares[k] < squares[leader])) leader = k;
    }
  }
  if (own.empty() || deepest->distance_m > 0.0) return deepest;
  // The two sides of a sheet have no edge in common.
  if (facing && facing->normal.dot(deepest->normal) > kFacingCosine)
    facing->distance_m = std::max(facing->distance_m, kMaxEdgeSlope * deepest->distance_m);
  return facing;
}

std::optional<SurfaceDepth> PointSurface::swept_depth(const Vector3d& end_m, const Vector3d& displacement_m,
                                                      std::span<const SurfaceElement> own) const {
  const double length = displacement_m.norm();
  if (length > 0.5 * reach_m_) {
    // Longer paths than 32 reaches are sampled more coarsely.
    const int probes = static_cast<int>(std::min(64.0, std::ceil(length / (0.5 * reach_m_))));
    for (int k = 0; k < probes; ++k) {
      const Vector3d rest = (1.0 - static_cast<double>(k) / probes) * displacement_m;
      auto found = depth(end_m - rest, own);
      if (!found || found->distance_m > 0.0 || found->normal.dot(displacement_m) >= 0.0) continue;
      found->distance_m += found->normal.dot(rest);
      return found;
    }
  }
  return depth(end_m, own);
}

}  // namespace livegs
