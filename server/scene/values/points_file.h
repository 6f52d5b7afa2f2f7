// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "core/result.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

// A list of particles: CSV with the header x,y,z or x,y,z,vx,vy,vz, metres and metres a second.
struct PointList {
  std::vector<Eigen::Vector3d> positions_m;
  std::vector<Eigen::Vector3d> velocities_m_s;  // empty or one a point
};
inline constexpr size_t kMaxPoints = 1'000'000;

// Errors name the file, the line and the column.
Result<PointList> read_points_file(const std::filesystem::path& path);

// The median distance to the nearest other point: the spacing of a regular list. 0 for fewer than two points.
double median_spacing_m(const std::vector<Eigen::Vector3d>& points_m);

// The edge of the cubes, one a point, that together have the volume the points fill: the median distance
// where all are alike; in an irregular list, whose nearest neighbours are nearer than that, the step of the
// grid that its points strayed from (grid_step.h), or without one from the volume of the surface through its
// outermost points, grown by half a spacing.
double filling_spacing_m(const std::vector<Eigen::Vector3d>& points_m, const TriangleMesh& through_outermost);

}  // namespace livegs
