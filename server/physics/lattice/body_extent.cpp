// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/field/inside_grid.h"
#include "physics/lattice/build_lattice.h"
#include "physics/lattice/cut_boxes.h"

namespace livegs {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// The principal axes are used if their bounding box is smaller than this fraction of that along the object
// axes.
constexpr double kPrincipalAxesRatio = 0.9;

AlignedBox3d cube_at(const Vector3d& centre, double half) {
  return {centre - Vector3d::Constant(half), centre + Vector3d::Constant(half)};
}

// Bounds of the vertices if there is a mesh. Cubes about the few particles of a slender bar would fit tighter
// along some oblique axes.
AlignedBox3d bounds_along(const ParticleSet& particles, const Matrix3d& lattice_from_object) {
  AlignedBox3d bounds;
  for (const Vector3d& vertex : particles.mesh_vertices_m) bounds.extend(lattice_from_object * vertex);
  if (!particles.mesh_vertices_m.empty()) return bounds;
  for (size_t i = 0; i < particles.positions_m.size(); ++i) {
    bounds.extend(
        cube_at(lattice_from_object * particles.positions_m[i], 0.5 * std::cbrt(particles.volumes_m3[i])));
  }
  return bounds;
}

Matrix3d principal_axes(const ParticleSet& particles) {
  Vector3d centre = Vector3d::Zero();
  double volume = 0.0;
  for (size_t i = 0; i < particles.positions_m.size(); ++i) {
    centre += particles.volumes_m3[i] * particles.positions_m[i];
    volume += particles.volumes_m3[i];
  }
  centre /= volume;
  Matrix3d covariance = Matrix3d::Zero();
  for (size_t i = 0; i < particles.positions_m.size(); ++i) {
    const Vector3d r = particles.positions_m[i] - centre;
    covariance += particles.volumes_m3[i] * r * r.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(covariance);
  Matrix3d axes = with_positive_entries(solver.eigenvectors());
  if (axes.determinant() < 0.0) axes.col(2) = -axes.col(2);
  return axes;
}

// Bounds of the surface: of all mesh vertices, or of all points of a list.
AlignedBox3d surface_bounds(const ParticleSet& particles, const Matrix3d& lattice_from_object) {
  AlignedBox3d bounds;
  const auto& points = particles.mesh_vertices_m.empty() ? particles.positions_m : particles.mesh_vertices_m;
  for (const Vector3d& point : points) bounds.extend(lattice_from_object * point);
  return bounds;
}

// Whether the voxel centres alone describe the solid: they hold most of its volume and reach every face to
// within a voxel. Mesh vertices are then contact samples only; mass at them would lie half outside the body.
// A potted plant fails the second test: its leaves contain no voxel centre, and the pot must not be stretched
// over them.
bool voxels_fill(const ParticleSet& particles, double volume, const Matrix3d& lattice_from_object,
                 const AlignedBox3d& surface) {
  if (particles.surface_carries || particles.on_surface.size() != particles.positions_m.size()) return false;
  AlignedBox3d voxels;
  size_t count = 0;
  for (size_t i = 0; i < particles.positions_m.size(); ++i) {
    if (particles.on_surface[i]) continue;
    voxels.extend(cube_at(lattice_from_object * particles.positions_m[i], 0.5 * particles.spacing_m));
    ++count;
  }
  const bool of_mesh = !particles.mesh_vertices_m.empty();
  if (count == 0 || (count == particles.positions_m.size() && !of_mesh)) return false;
  if (static_cast<double>(count) * std::pow(particles.spacing_m, 3) <= 0.5 * volume) return false;
  const double reach = particles.spacing_m * (1.0 + 1e-6);
  return ((voxels.min() - surface.min()).cwiseAbs().array() <= reach).all() &&
         ((voxels.max() - surface.max()).cwiseAbs().array() <= reach).all();
}

// Whole voxels end before or after the true faces. The outermost voxels of a compact body along the object's
// axes are cut or extended to the faces, so that a box is filled exactly. Voxel volumes were estimated by
// sampling. A voxel near its full volume is set to full, and the other voxels absorb the difference. Returns
// false, without changes, unless nearly all voxels are full.
bool end_at_faces(const AlignedBox3d& surface, double volume, BodyExtent& extent) {
  constexpr double kEdgeTolerance = 0.25, kMinFullShare = 0.8;
  // A body that fills its bounding box has no partial voxels.
  const bool filled = volume >= 0.999 * surface.volume();
  std::vector<MassBox> boxes = extent.boxes;
  std::vector<char> full;
  double full_m3 = 0.0, partial_m3 = 0.0;
  for (MassBox& box : boxes) {
    Vector3d low = box.centre_m - box.half_m, high = box.centre_m + box.half_m;
    const double rounding_m = 1e-6 * (2.0 * box.half_m.x());
    for (int d = 0; d < 3; ++d) {
      if (low[d] < extent.min_m[d] + rounding_m) low[d] = surface.min()[d];
      if (high[d] > extent.max_m[d] - rounding_m) high[d] = surface.max()[d];
      low[d] = std::clamp(low[d], surface.min()[d], box.centre_m[d]);
      high[d] = std::clamp(high[d], box.centre_m[d], surface.max()[d]);
    }
    const double own_m3 = (high - low).prod();
    box.centre_m = 0.5 * (low + high);
    box.half_m = 0.5 * (high - low);
    full.push_back(filled || std::abs(box.volume_m3 - own_m3) <= kEdgeTolerance * own_m3);
    if (full.back()) box.volume_m3 = own_m3;
    (full.back() ? full_m3 : partial_m3) += box.volume_m3;
  }
  if (full_m3 < kMinFullShare * volume) return false;
  // The partial voxels absorb the whole change if they can.
  const bool bearable = partial_m3 > 0.0 && std::abs(volume - full_m3 - partial_m3) < 0.5 * partial_m3;
  for (size_t i = 0; i < boxes.size(); ++i) {
    if (!bearable) boxes[i].volume_m3 *= volume / (full_m3 + partial_m3);
    if (bearable && !full[i]) boxes[i].volume_m3 *= (volume - full_m3) / partial_m3;
  }
  extent.boxes = std::move(boxes);
  return true;
}

// Bars, rods and plates thinner than a few voxels contain few particles, and cubes about their vertices
// represent them poorly. A mesh that fills a good part of its bounds is instead cut into boxes along the
// lattice axes, no longer than a voxel and with a minimum number along each edge. Returns false, without
// changes, if the boxes do not match the volume.
bool cut_mesh(const ParticleSet& particles, double volume, const Matrix3d& lattice_from_object,
              const AlignedBox3d& surface, BodyExtent& extent) {
  constexpr double kSolid = 0.4, kVolumeTolerance = 0.1;
  constexpr int kMinEdge = 6, kMaxEdge = 64;
  const Vector3d size = surface.max() - surface.min();
  if (particles.mesh_triangles.empty() || !(volume > kSolid * size.prod())) return false;
  RegularGrid grid;
  for (int d = 0; d < 3; ++d) {
    grid.counts[d] = static_cast<int>(
        std::clamp(std::ceil(size[d] / particles.spacing_m), 1.0 * kMinEdge, 1.0 * kMaxEdge));
  }
  const Vector3d edge = size.cwiseQuotient(grid.counts.cast<double>());
  grid.origin_m = Vector3d::Constant(0.5);  // in box edges
  TriangleMesh mesh;
  mesh.triangles = particles.mesh_triangles;
  for (const Vector3d& vertex : particles.mesh_vertices_m) {
    mesh.vertices_m.push_back((lattice_from_object * vertex - surface.min()).cwiseQuotient(edge));
  }
  const std::vector<uint8_t> inside = nodes_inside(mesh, grid);
  const auto count = static_cast<double>(std::count(inside.begin(), inside.end(), 1));
  if (std::abs(count * edge.prod() - volume) > kVolumeTolerance * volume) return false;
  extent.boxes.clear();
  for (int k = 0; k < grid.counts.z(); ++k) {
    for (int j = 0; j < grid.counts.y(); ++j) {
      for (int i = 0; i < grid.counts.x(); ++i) {
        if (!inside[grid.index(i, j, k)]) continue;
        extent.boxes.push_back(
            {surface.min() + grid.point_m(i, j, k).cwiseProduct(edge), 0.5 * edge, volume / count});
      }
    }
  }
  extent.min_m = surface.min();
  extent.max_m = surface.max();
  return true;
}

}  // namespace

Matrix3d with_positive_entries(Matrix3d axes) {
  for (int d = 0; d < 3; ++d) {
    Eigen::Index largest;
    axes.col(d).cwiseAbs().maxCoeff(&largest);
    if (axes(largest, d) < 0.0) axes.col(d) = -axes.col(d);
  }
  return axes;
}

BodyExtent measure_extent(const ParticleSet& particles) {
  BodyExtent extent;
  extent.spacing_m = particles.spacing_m;
  extent.of_points = particles.mesh_vertices_m.empty();
  Matrix3d lattice_from_object = Matrix3d::Identity();
  const Matrix3d principal = principal_axes(particles).transpose();
  if (bounds_along(particles, principal).volume() <
      kPrincipalAxesRatio * bounds_along(particles, lattice_from_object).volume()) {
    lattice_from_object = principal;
  }
  extent.object_from_lattice = Eigen::Quaterniond(Matrix3d(lattice_from_object.transpose()));
  if (lattice_from_object.isIdentity()) extent.object_from_lattice.setIdentity();

  double volume = 0.0;
  for (const double v : particles.volumes_m3) volume += v;
  const AlignedBox3d surface = surface_bounds(particles, lattice_from_object);
  const bool voxels_only = voxels_fill(particles, volume, lattice_from_object, surface);
  AlignedBox3d material;
  double used = 0.0;
  for (size_t i = 0; i < particles.positions_m.size(); ++i) {
    const Vector3d centre = lattice_from_object * particles.positions_m[i];
    if (voxels_only && particles.on_surface[i]) continue;
    const double half = voxels_only ? 0.5 * particles.spacing_m : 0.5 * std::cbrt(particles.volumes_m3[i]);
    extent.boxes.push_back({centre, Vector3d::Constant(half), particles.volumes_m3[i]});
    material.extend(cube_at(centre, half));
    used += particles.volumes_m3[i];
  }
  extent.box_edge_m = voxels_only ? particles.spacing_m
                                  : std::cbrt(volume / static_cast<double>(particles.positions_m.size()));
  extent.min_m = material.min();
  extent.max_m = material.max();
  if (!voxels_only) {
    extent.loose =
        !cut_mesh(particles, volume, lattice_from_object, surface, extent) && particles.surface_carries;
    return extent;
  }
  for (MassBox& box : extent.boxes) box.volume_m3 *= volume / used;
  if (!along_object_axes(extent) || !end_at_faces(surface, volume, extent)) {
    // The voxels are oblique, or the body is little more than surface: stretch all boxes.
    const Vector3d stretch = (surface.max() - surface.min()).cwiseQuotient(material.max() - material.min());
    for (MassBox& box : extent.boxes) {
      box.centre_m = surface.min() + (box.centre_m - material.min()).cwiseProduct(stretch);
      box.half_m = box.half_m.cwiseProduct(stretch);
    }
  }
  extent.min_m = surface.min();
  extent.max_m = surface.max();
  return extent;
}

}  // namespace livegs
