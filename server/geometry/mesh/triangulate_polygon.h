// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace livegs {

// A polygon with holes: the outer loop runs counter-clockwise, holes clockwise.
struct PolygonRegion {
  std::vector<std::vector<uint32_t>> loops;  // [0] is the outer one
};

// Groups loops into regions by which outer loop holds which hole. A hole that no outer loop holds (a polygon
// that rounding has turned over) becomes a region of its own.
std::vector<PolygonRegion> nest_loops(std::vector<std::vector<uint32_t>> loops,
                                      std::span<const Eigen::Vector2d> points);

// Triangles that use every edge of the loops exactly once, in its direction, and every other edge both ways,
// whatever the points are: closed surfaces stay closed, and signed areas sum to the region's. For simple
// loops the triangles do not overlap. Ear clipping (Meisters 1975), holes joined by bridges (Eberly 2002,
// Triangulation by ear clipping).
std::vector<std::array<uint32_t, 3>> triangulate(const PolygonRegion& region,
                                                 std::span<const Eigen::Vector2d> points);

// Twice the signed area of a loop.
double twice_area(const std::vector<uint32_t>& loop, std::span<const Eigen::Vector2d> points);

}  // namespace livegs
