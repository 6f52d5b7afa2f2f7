// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/mesh/triangulate_polygon.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace livegs {
namespace {

using Points = std::span<const Eigen::Vector2d>;
using Loop = std::vector<uint32_t>;

double cross_of(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

bool inside_loop(const Eigen::Vector2d& p, const Loop& loop, Points points) {
  bool inside = false;
  for (size_t i = 0, j = loop.size() - 1; i < loop.size(); j = i++) {
    const Eigen::Vector2d &a = points[loop[i]], &b = points[loop[j]];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside;
}

bool same_place(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() == b.x() && a.y() == b.y();
}

// Returns whether the segment from a to b crosses an edge of the loop, except at its own ends.
bool crosses(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Loop& loop, Points points) {
  for (size_t i = 0, j = loop.size() - 1; i < loop.size(); j = i++) {
    const Eigen::Vector2d &c = points[loop[j]], &d = points[loop[i]];
    if (same_place(c, a) || same_place(c, b) || same_place(d, a) || same_place(d, b)) continue;
    if ((cross_of(a, b, c) > 0) != (cross_of(a, b, d) > 0) &&
        (cross_of(c, d, a) > 0) != (cross_of(c, d, b) > 0))
      return true;
  }
  return false;
}

// Returns whether the direction to p points into the polygon at corner `at`.
bool opens_towards(const Loop& loop, size_t at, const Eigen::Vector2d& p, Points points) {
  const Eigen::Vector2d &before = points[loop[(at + loop.size() - 1) % loop.size()]],
                        &here = points[loop[at]], &after = points[loop[(at + 1) % loop.size()]];
  if (cross_of(before, here, after) > 0) return cross_of(before, here, p) > 0 && cross_of(here, after, p) > 0;
  return cross_of(before, here, p) > 0 || cross_of(here, after, p) > 0;
}

// Joins a hole to the polygon by the shortest bridge that crosses no edge.
void join_hole(Loop& polygon, const Loop& hole, const std::vector<Loop>& others, Points points) {
  // Starts at the rightmost corner of the hole: the region to its right belongs to the polygon or to holes
  // that are already joined.
  size_t from = 0;
  for (size_t h = 1; h < hole.size(); ++h) {
    if (points[hole[h]].x() > points[hole[from]].x()) from = h;
  }
  const Eigen::Vector2d& start = points[hole[from]];
  std::vector<size_t> order(polygon.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    const double da = (points[polygon[a]] - start).squaredNorm(),
                 db = (points[polygon[b]] - start).squaredNorm();
    return da != db ? da < db : a < b;
  });
  size_t to = order[0];
  for (size_t candidate : order) {
    const Eigen::Vector2d& end = points[polygon[candidate]];
    if (!opens_towards(polygon, candidate, start, points)) continue;
    if (crosses(start, end, polygon, points) || crosses(start, end, hole, points)) continue;
    bool clear = true;
    for (const Loop& other : others) clear = clear && !crosses(start, end, other, points);
    if (!clear) continue;
    to = candidate;
    break;
  }
  Loop joined(polygon.begin(), polygon.begin() + static_cast<std::ptrdiff_t>(to) + 1);
  for (size_t h = 0; h <= hole.size(); ++h) joined.push_back(hole[(from + h) % hole.size()]);
  joined.insert(joined.end(), polygon.begin() + static_cast<std::ptrdiff_t>(to), polygon.end());
  polygon = std::move(joined);
}

// Returns whether no reflex corner of the polygon lies in the ear (a, b, c).
bool is_ear(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c, const Loop& polygon,
            const std::vector<uint8_t>& reflex, Points points) {
  if (!(cross_of(a, b, c) > 0)) return false;
  for (size_t i = 0; i < polygon.size(); ++i) {
    if (!reflex[i]) continue;
    const Eigen::Vector2d& p = points[polygon[i]];
    if (same_place(p, a) || same_place(p, b) || same_place(p, c)) continue;
    if (cross_of(a, b, p) >= 0 && cross_of(b, c, p) >= 0 && cross_of(c, a, p) >= 0) return false;
  }
  return true;
}

}  // namespace

double twice_area(const Loop& loop, Points points) {
  double sum = 0.0;
  for (size_t i = 1; i + 1 < loop.size(); ++i)
    sum += cross_of(points[loop[0]], points[loop[i]], points[loop[i + 1]]);
  return sum;
}

std::vector<PolygonRegion> nest_loops(std::vector<Loop> loops, Points points) {
  std::vector<PolygonRegion> regions;
  std::vector<double> areas;
  std::vector<size_t> holes;
  for (size_t l = 0; l < loops.size(); ++l) {
    const double area = twice_area(loops[l], points);
    if (area > 0) {
      regions.push_back({{loops[l]}});
      areas.push_back(area);
    } else {
      holes.push_back(l);
    }
  }
  const size_t outer_count = regions.size();
  for (size_t l : holes) {
    size_t best = outer_count, best_votes = 0;
    double best_area = std::numeric_limits<double>::max();
    for (size_t r = 0; r < outer_count; ++r) {
      // Decided by the majority of corners, because some may touch the outer loop.
      size_t votes = 0;
      for (uint32_t corner : loops[l]) votes += inside_loop(points[corner], regions[r].loops[0], points);
      if (2 * votes <= loops[l].size() || areas[r] >= best_area) continue;
      best = r, best_votes = votes, best_area = areas[r];
    }
    if (best_votes > 0 && -twice_area(loops[l], points) < best_area) {
      regions[best].loops.push_back(std::move(loops[l]));
    } else {
      regions.push_back({{std::move(loops[l])}});
    }
  }
  return regions;
}

std::vector<std::array<uint32_t, 3>> triangulate(const PolygonRegion& region, Points points) {
  Loop polygon = region.loops[0];
  std::vector<Loop> holes(region.loops.begin() + 1, region.loops.end());
  const auto right = [&](const Loop& loop) {
    double most = -std::numeric_limits<double>::max();
    for (uint32_t corner : loop) most = std::max(most, points[corner].x());
    return most;
  };
  std::stable_sort(holes.begin(), holes.end(),
                   [&](const Loop& a, const Loop& b) { return right(a) > right(b); });
  while (!holes.empty()) {
    const Loop hole = std::move(holes.front());
    holes.erase(holes.begin());
    join_hole(polygon, hole, holes, points);
  }

  std::vector<std::array<uint32_t, 3>> triangles;
  triangles.reserve(polygon.size());
  std::vector<uint8_t> reflex(polygon.size());
  const auto corner_points = [&](size_t i) {
    const size_t n = polygon.size();
    return std::array{points[polygon[(i + n - 1) % n]], points[polygon[i]], points[polygon[(i + 1) % n]]};
  };
  const auto update = [&](size_t i) {
    const auto [a, b, c] = corner_points(i);
    reflex[i] = !(cross_of(a, b, c) > 0);
  };
  for (size_t i = 0; i < polygon.size(); ++i) update(i);
  size_t at = 0;
  while (polygon.size() > 3) {
    const size_t n = polygon.size();
    size_t ear = n;
    for (size_t tried = 0; tried < n && ear == n; ++tried) {
      const size_t i = (at + tried) % n;
      const auto [a, b, c] = corner_points(i);
      if (!reflex[i] && is_ear(a, b, c, polygon, reflex, points)) ear = i;
    }
    if (ear == n) {
      // Only rounding errors are left: the corner with the smallest area is removed, which changes the shape
      // least.
      double least = std::numeric_limits<double>::max();
      for (size_t i = 0; i < n; ++i) {
        const auto [a, b, c] = corner_points(i);
        if (std::abs(cross_of(a, b, c)) < least) least = std::abs(cross_of(a, b, c)), ear = i;
      }
    }
    triangles.push_back({polygon[(ear + n - 1) % n], polygon[ear], polygon[(ear + 1) % n]});
    polygon.erase(polygon.begin() + static_cast<std::ptrdiff_t>(ear));
    reflex.erase(reflex.begin() + static_cast<std::ptrdiff_t>(ear));
    const size_t left = polygon.size();
    update(ear % left);
    update((ear + left - 1) % left);
    at = (ear + 1) % left;  // every other corner first, which avoids fans of thin triangles
  }
  if (polygon.size() == 3) triangles.push_back({polygon[0], polygon[1], polygon[2]});
  return triangles;
}

}  // namespace livegs
