// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "core/result.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

// A list of particles from a CSV file with the header x,y,z or x,y,z,vx,vy,vz; metres and metres per second.
struct PointList {
  std::vector<Eigen::Vector3d> positions_m;
  std::vector<Eigen::Vector3d> velocities_m_s;  // empty or one per point
};
inline constexpr size_t kMaxPoints = 1'000'000;

// Errors name the file, the line and the column.
Result<PointList> read_points_file(const std::filesystem::path& path);

// Returns the median distance to the nearest other point, metres. 0 for fewer than two points.
double median_spacing_m(const std::vector<Eigen::Vector3d>& points_m);

// Returns the edge of the cubes, one per point, whose total volume is the volume that the points fill:
// - In a regular list, the median distance to the nearest point.
// - In an irregular list, the step of the grid that the points were jittered from (grid_spacing.h).
// - Without such a grid, from the volume inside the surface through the outermost points, grown by half a
//   spacing.
double filling_spacing_m(const std::vector<Eigen::Vector3d>& points_m, const TriangleMesh& through_outermost);

}  // namespace livegs
