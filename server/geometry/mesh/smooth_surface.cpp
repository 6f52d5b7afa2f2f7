// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/mesh/smooth_surface.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Faces at a larger angle meet at a sharp edge: cosine of 30 degrees.
constexpr double kCreaseCosine = 0.866;
// Barycentric coordinate below which a foot is on an edge.
constexpr double kOnEdge = 1e-6;

}  // namespace

SmoothSurface::SmoothSurface(TriangleMesh mesh) : mesh_(std::move(mesh)), tree_(mesh_) {
  triangles_at_.resize(mesh_.vertices_m.size());
  std::vector<Vector3d> normals;
  for (uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
    normals.push_back(face_normal(t));
    for (const uint32_t vertex : mesh_.triangles[t]) triangles_at_[vertex].push_back(t);
  }
  const auto angle_at = [&](uint32_t triangle, uint32_t vertex) {
    const auto& corners = mesh_.triangles[triangle];
    const size_t k = std::find(corners.begin(), corners.end(), vertex) - corners.begin();
    const Vector3d &at = mesh_.vertices_m[vertex], &next = mesh_.vertices_m[corners[(k + 1) % 3]],
                   &last = mesh_.vertices_m[corners[(k + 2) % 3]];
    return std::atan2((next - at).cross(last - at).norm(), (next - at).dot(last - at));
  };
  corner_normals_.resize(mesh_.triangles.size());
  for (uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      Vector3d sum = Vector3d::Zero();
      for (const uint32_t other : triangles_at_[mesh_.triangles[t][k]]) {
        if (normals[other].dot(normals[t]) >= kCreaseCosine)
          sum += angle_at(other, mesh_.triangles[t][k]) * normals[other];
      }
      corner_normals_[t][k] = sum.norm() > 0.0 ? Vector3d(sum.normalized()) : normals[t];
    }
  }
}

Vector3d SmoothSurface::face_normal(uint32_t triangle) const {
  const auto& [a, b, c] = mesh_.triangles[triangle];
  const Vector3d& at = mesh_.vertices_m[a];
  return (mesh_.vertices_m[b] - at).cross(mesh_.vertices_m[c] - at).normalized();
}

Vector3d SmoothSurface::barycentric(uint32_t triangle, const Vector3d& point_m) const {
  const auto& [a, b, c] = mesh_.triangles[triangle];
  const Vector3d &p = mesh_.vertices_m[a], &q = mesh_.vertices_m[b], &r = mesh_.vertices_m[c];
  const Vector3d area = (q - p).cross(r - p);
  const double square = area.squaredNorm();
  if (!(square > 0.0)) return {1.0, 0.0, 0.0};
  const double of_q = (point_m - p).cross(r - p).dot(area) / square,
               of_r = (q - p).cross(point_m - p).dot(area) / square;
  return Vector3d(1.0 - of_q - of_r, of_q, of_r).cwiseMax(0.0).cwiseMin(1.0);
}

// Least squares over the edges (Rusinkiewicz 2004, Estimating curvatures and their derivatives on triangle
// meshes).
Matrix3d SmoothSurface::curvature(uint32_t triangle, const Vector3d& normal) const {
  Eigen::Matrix<double, 3, 2> plane;
  plane.col(0) = normal.unitOrthogonal();
  plane.col(1) = normal.cross(plane.col(0));
  Matrix3d squares = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    const auto& corners = mesh_.triangles[triangle];
    const Eigen::Vector2d along =
        plane.transpose() * (mesh_.vertices_m[corners[next]] - mesh_.vertices_m[corners[k]]);
    const Eigen::Vector2d turn =
        plane.transpose() * (corner_normals_[triangle][next] - corner_normals_[triangle][k]);
    Eigen::Matrix<double, 2, 3> rows;  // of the operator's entries xx, xy, yy
    rows << along.x(), along.y(), 0.0, 0.0, along.x(), along.y();
    squares += rows.transpose() * rows;
    right += rows.transpose() * turn;
  }
  const Vector3d entries = squares.ldlt().solve(right);
  if (!entries.allFinite()) return Matrix3d::Zero();
  Eigen::Matrix2d operator_2d;
  operator_2d << entries[0], entries[1], entries[1], entries[2];
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> principal;
  principal.computeDirect(operator_2d);
  const Eigen::Matrix<double, 3, 2> axes = plane * principal.eigenvectors();
  return axes * principal.eigenvalues().cwiseMax(0.0).asDiagonal() * axes.transpose();
}

SmoothSurface::Foot SmoothSurface::nearest(const Vector3d& point_m) const {
  const TriangleTree::Nearest found = tree_.nearest(point_m);
  const Vector3d parts = barycentric(found.triangle, found.foot_m);
  std::vector<uint32_t> touching = {found.triangle};
  const auto& corners = mesh_.triangles[found.triangle];
  std::vector<uint32_t> ends;  // of the edge, or the vertex, that the foot is on
  for (int k = 0; k < 3; ++k) {
    if (parts[k] > kOnEdge) ends.push_back(corners[k]);
  }
  if (ends.size() < 3) {
    for (const uint32_t other : triangles_at_[ends.front()]) {
      const auto& its = mesh_.triangles[other];
      const bool shares = std::find(its.begin(), its.end(), ends.back()) != its.end();
      if (shares && other != found.triangle) touching.push_back(other);
    }
  }
  Foot foot{found.foot_m, {}, Matrix3d::Zero(), Vector3d::Zero()};
  std::vector<uint32_t> faces;  // by normal
  double farthest = 0.0;
  for (const uint32_t triangle : touching) {
    const Vector3d shares = barycentric(triangle, found.foot_m);
    Vector3d normal = Vector3d::Zero(), shift = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const Vector3d& at = corner_normals_[triangle][k];
      normal += shares[k] * at;
      shift -= 0.5 * shares[k] * at.dot(found.foot_m - mesh_.vertices_m[mesh_.triangles[triangle][k]]) * at;
    }
    normal.normalize();
    // At the rim of a cylinder, the triangles of its end would leave the point on the chord.
    if (shift.norm() > farthest) {
      farthest = shift.norm();
      foot.point_m = found.foot_m + shift;
    }
    const bool own_face = std::none_of(foot.normals.begin(), foot.normals.end(), [&](const Vector3d& other) {
      return other.dot(normal) >= kCreaseCosine;
    });
    if (!own_face) continue;
    foot.normals.push_back(normal);
    faces.push_back(triangle);
  }
  foot.bulge = foot.normals[0];
  if (foot.normals.size() == 1) foot.curvature = curvature(found.triangle, foot.normals[0]);
  if (foot.normals.size() == 2) {
    // The curve lies in both faces: its curvature vector along each normal is the face's curvature along the
    // edge.
    const Vector3d &a = foot.normals[0], &b = foot.normals[1], edge = a.cross(b).normalized();
    const double cosine = a.dot(b), bend_a = edge.dot(curvature(faces[0], a) * edge),
                 bend_b = edge.dot(curvature(faces[1], b) * edge), square = 1.0 - cosine * cosine;
    const Vector3d bend = ((bend_a - cosine * bend_b) * a + (bend_b - cosine * bend_a) * b) / square;
    const double size = bend.norm();
    if (size > 0.0 && std::isfinite(size)) {
      foot.curvature = size * edge * edge.transpose();
      foot.bulge = bend / size;
    }
  }
  return foot;
}

SmoothSurface::SharpPoints SmoothSurface::sharp_points(double spacing_m) const {
  std::map<std::pair<uint32_t, uint32_t>, std::vector<uint32_t>> edges;
  for (uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
    const auto& corners = mesh_.triangles[t];
    for (int k = 0; k < 3; ++k) edges[std::minmax(corners[k], corners[(k + 1) % 3])].push_back(t);
  }
  SharpPoints points;
  std::map<uint32_t, std::vector<Vector3d>> directions;  // of the sharp edges at each vertex, outwards
  for (const auto& [ends, faces] : edges) {
    if (faces.size() != 2 || face_normal(faces[0]).dot(face_normal(faces[1])) >= kCreaseCosine) continue;
    const Vector3d &from = mesh_.vertices_m[ends.first], &to = mesh_.vertices_m[ends.second];
    directions[ends.first].push_back((to - from).normalized());
    directions[ends.second].push_back((from - to).normalized());
    const int parts = static_cast<int>(std::ceil((to - from).norm() / spacing_m));
    for (int k = 1; k < parts; ++k)
      points.edges_m.push_back(from + static_cast<double>(k) / parts * (to - from));
  }
  for (const auto& [vertex, sharp] : directions) {
    const bool smooth = sharp.size() == 2 && sharp[0].dot(sharp[1]) <= -kCreaseCosine;
    (smooth ? points.edges_m : points.corners_m).push_back(mesh_.vertices_m[vertex]);
  }
  return points;
}

}  // namespace livegs
