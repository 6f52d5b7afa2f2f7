// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "geometry/mesh/triangle_tree.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

// The smooth surface that a triangle mesh stands for: curved triangles between vertex normals (Boubekeur and
// Alexa 2008, Phong tessellation), with sharp edges where faces meet at more than 30 degrees. For the sphere
// and the cylinder of shape_mesh.h it is within 2e-4 of the radius of the exact surface. Immutable; any
// thread may query.
class SmoothSurface {
 public:
  // A closed mesh with shared vertices.
  explicit SmoothSurface(TriangleMesh mesh);

  struct Foot {
    Eigen::Vector3d point_m;               // on the smooth surface
    std::vector<Eigen::Vector3d> normals;  // outward, unit; one per face that meets at a sharp edge or corner
    // Convex curvature about the point: the surface is point_m + u - u.curvature u / 2 bulge for tangential
    // u, at a sharp edge for u along it. Symmetric, 1/m, eigenvalues >= 0, zero along `bulge`; zero at
    // corners.
    Eigen::Matrix3d curvature;
    Eigen::Vector3d bulge;  // unit; the normal, at a sharp edge the outward normal of its curve
  };
  // The point of the surface near the foot of `point_m` on the mesh.
  Foot nearest(const Eigen::Vector3d& point_m) const;

  // Ends of straight sharp edges, and points along sharp edges at most `spacing_m` apart.
  struct SharpPoints {
    std::vector<Eigen::Vector3d> corners_m, edges_m;
  };
  SharpPoints sharp_points(double spacing_m) const;

 private:
  Eigen::Vector3d face_normal(uint32_t triangle) const;
  Eigen::Vector3d barycentric(uint32_t triangle, const Eigen::Vector3d& point_m) const;
  // Curvature at a triangle, in the plane across `normal`.
  Eigen::Matrix3d curvature(uint32_t triangle, const Eigen::Vector3d& normal) const;

  TriangleMesh mesh_;
  TriangleTree tree_;
  std::vector<std::vector<uint32_t>> triangles_at_;             // by vertex
  std::vector<std::array<Eigen::Vector3d, 3>> corner_normals_;  // by triangle
};

}  // namespace livegs
