// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/collision/collision_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "geometry/field/point_grid.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/mesh/triangle_distance.h"

namespace livegs {
namespace {

// Fills one triangle with a regular pattern of points, excluding corners. The step is at most `spacing_m`
// along each edge.
void fill_triangle(const std::array<Eigen::Vector3d, 3>& corner, double spacing_m,
                   std::vector<Eigen::Vector3d>& points) {
  const double longest = std::max(
      {(corner[1] - corner[0]).norm(), (corner[2] - corner[1]).norm(), (corner[0] - corner[2]).norm()});
  const int steps = static_cast<int>(std::ceil(longest / spacing_m));
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps - i; ++j) {
      const int k = steps - i - j;
      if (i == steps || j == steps || k == steps) continue;
      points.push_back((i * corner[0] + j * corner[1] + k * corner[2]) / steps);
    }
  }
}

void keep_extremes(const std::vector<Eigen::Vector3d>& vertices, std::vector<Eigen::Vector3d>& kept) {
  std::vector<size_t> extremes;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const Eigen::Vector3d direction(x, y, z);
        const auto along = [&](const Eigen::Vector3d& vertex) { return vertex.dot(direction); };
        const auto best = std::ranges::max_element(vertices, {}, along);
        extremes.push_back(static_cast<size_t>(best - vertices.begin()));
      }
    }
  }
  std::ranges::sort(extremes);
  extremes.erase(std::ranges::unique(extremes).begin(), extremes.end());
  for (const size_t index : extremes) kept.push_back(vertices[index]);
}

// Mean thickness: twice the volume divided by the surface area.
double mean_thickness_m(const TriangleMesh& mesh) {
  return 2.0 * std::abs(signed_volume_m3(mesh)) / surface_area_m2(mesh);
}

}  // namespace

double surface_area_m2(const TriangleMesh& mesh) {
  double area_m2 = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto& at = mesh.vertices_m;
    area_m2 += 0.5 * (at[b] - at[a]).cross(at[c] - at[a]).norm();
  }
  return area_m2;
}

double triangle_distance_m(const RigidShape& shape, const Eigen::Vector3d& point_m) {
  double least = INFINITY;
  for (const auto& [a, b, c] : shape.mesh.triangles) {
    const auto& at = shape.mesh.vertices_m;
    least =
        std::min(least, (closest_point_on_triangle(point_m, at[a], at[b], at[c]) - point_m).squaredNorm());
  }
  return std::sqrt(least);
}

ShapeBox turned_box(const RigidShape& shape, const Eigen::Matrix3d& turn, const Eigen::Vector3d& position_m) {
  if (shape.is_ball()) return {position_m, Eigen::Vector3d::Constant(shape.sphere_radius_m)};
  return {position_m + turn * (0.5 * (shape.min_m + shape.max_m)),
          turn.cwiseAbs() * (0.5 * (shape.max_m - shape.min_m))};
}

std::vector<Eigen::Vector3d> contact_points(const TriangleMesh& mesh, double spacing_m, size_t max_points) {
  std::vector<Eigen::Vector3d> kept;
  const bool few = mesh.vertices_m.size() <= max_points * 3 / 4;
  if (few) {
    kept = mesh.vertices_m;
  } else {
    keep_extremes(mesh.vertices_m, kept);
  }

  PointGrid taken(mesh_bounds_m(mesh), spacing_m);
  for (const Eigen::Vector3d& point : kept) taken.insert(point);
  // Farthest points first, so that the first points to touch are kept. Vertices are taken before filling
  // points because edges are sharp.
  const auto take = [&](std::vector<Eigen::Vector3d> points) {
    std::ranges::stable_sort(points, std::greater(),
                             [](const Eigen::Vector3d& p) { return p.squaredNorm(); });
    for (const Eigen::Vector3d& point : points) {
      if (taken.has_neighbour_within(point, spacing_m)) continue;
      kept.push_back(point);
      taken.insert(point);
    }
  };
  if (!few) take(mesh.vertices_m);
  std::vector<Eigen::Vector3d> filling;
  for (const auto& triangle : mesh.triangles) {
    const std::array<Eigen::Vector3d, 3> corner{mesh.vertices_m[triangle[0]], mesh.vertices_m[triangle[1]],
                                                mesh.vertices_m[triangle[2]]};
    fill_triangle(corner, spacing_m, filling);
  }
  take(std::move(filling));
  return kept;
}

double inner_radius_m(const RigidShape& shape) {
  const Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  const double inside = -shape.sample(centre).distance_m;
  if (!(inside > 0.0)) return 0.0;
  // A field has an error of up to one cell.
  return shape.field ? triangle_distance_m(shape, centre) : inside;
}

RigidShape mesh_shape(const TriangleMesh& object_mesh, const Eigen::Vector3d& centre_of_mass_m,
                      const ShapeDetail& detail) {
  RigidShape shape;
  shape.mesh = object_mesh;
  shape.min_m.setConstant(INFINITY);
  shape.max_m.setConstant(-INFINITY);
  for (Eigen::Vector3d& vertex : shape.mesh.vertices_m) {
    vertex -= centre_of_mass_m;
    shape.min_m = shape.min_m.cwiseMin(vertex);
    shape.max_m = shape.max_m.cwiseMax(vertex);
    shape.bounding_radius_m = std::max(shape.bounding_radius_m, vertex.norm());
  }
  const double longest = (shape.max_m - shape.min_m).maxCoeff();
  if (auto convex = convex_polyhedron(shape.mesh)) {
    shape.convex = std::make_shared<const ConvexPolyhedron>(std::move(*convex));
  } else {
    const double cell = longest / detail.field_cells;
    shape.field = std::make_shared<const DistanceField>(shape.mesh, cell, 3.0 * cell, detail.thin);
    shape.wall_m = mean_thickness_m(shape.mesh);
  }

  shape.contact_spacing_m = detail.point_spacing * longest;
  shape.contact_points_m = contact_points(shape.mesh, shape.contact_spacing_m, detail.max_points);
  while (shape.contact_points_m.size() > detail.max_points) {
    shape.contact_spacing_m *= 1.2;
    shape.contact_points_m = contact_points(shape.mesh, shape.contact_spacing_m, detail.max_points);
  }
  shape.contact_tree = BoundingSphereTree(shape.contact_points_m);
  shape.inner_radius_m = inner_radius_m(shape);
  return shape;
}

RigidShape ball_shape(double radius_m) {
  RigidShape shape;
  shape.sphere_radius_m = radius_m;
  shape.bounding_radius_m = radius_m;
  shape.min_m.setConstant(-radius_m);
  shape.max_m.setConstant(radius_m);
  return shape;
}

double RigidShape::sample_error_m() const {
  double error = field ? field->cell_m() : 0.0;
  for (const Part& part : parts) error = std::max(error, part.shape->sample_error_m());
  return error;
}

DistanceField::Sample RigidShape::sample(const Eigen::Vector3d& point_m) const {
  if (is_ball()) {
    const double length = point_m.norm();
    return {length - sphere_radius_m,
            length > 0.0 ? Eigen::Vector3d(point_m / length) : Eigen::Vector3d::UnitY()};
  }
  if (convex) {
    const ConvexPolyhedron::Sample found = convex->sample(point_m);
    return {found.distance_m, found.normal};
  }
  if (!parts.empty()) {
    DistanceField::Sample nearest{INFINITY, Eigen::Vector3d::UnitY()};
    for (const Part& part : parts) {
      const Eigen::Vector3d local = point_m - part.offset_m;
      const Eigen::Vector3d box = local.cwiseMax(part.shape->min_m).cwiseMin(part.shape->max_m);
      const double outside = (local - box).norm();
      if (outside > 0.0 && outside >= nearest.distance_m) continue;
      const DistanceField::Sample sample = part.shape->sample(local);
      if (sample.distance_m < nearest.distance_m) nearest = sample;
    }
    return nearest;
  }
  // Outside the grid's margin the field is only an upper bound; the distance to the bounding box is a lower
  // bound.
  const Eigen::Vector3d nearest = point_m.cwiseMax(min_m).cwiseMin(max_m);
  const Eigen::Vector3d away = point_m - nearest;
  const double length = away.norm();
  if (length > 2.0 * field->cell_m()) return {length, away / length};
  return field->sample(point_m);
}

}  // namespace livegs
