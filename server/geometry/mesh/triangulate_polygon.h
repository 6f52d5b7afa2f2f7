// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace livegs {

// A polygon with holes. The outer loop is counter-clockwise, holes are clockwise.
struct PolygonRegion {
  std::vector<std::vector<uint32_t>> loops;  // [0] is the outer loop
};

// Groups loops into regions: each hole is assigned to the outer loop that contains it. A hole outside all
// outer loops (a polygon inverted by rounding) becomes a region.
std::vector<PolygonRegion> nest_loops(std::vector<std::vector<uint32_t>> loops,
                                      std::span<const Eigen::Vector2d> points);

// Triangulates a region. The triangles use each edge of the loops exactly once, in its direction, and each
// other edge once in both directions, for any point positions. So closed surfaces stay closed, and signed
// areas add up. For simple loops the triangles do not overlap. Ear clipping (Meisters 1975) with bridges to
// holes (Eberly 2002, Triangulation by ear clipping).
std::vector<std::array<uint32_t, 3>> triangulate(const PolygonRegion& region,
                                                 std::span<const Eigen::Vector2d> points);

// Returns twice the signed area of a loop.
double twice_area(const std::vector<uint32_t>& loop, std::span<const Eigen::Vector2d> points);

}  // namespace livegs
