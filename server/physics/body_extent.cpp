// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "physics/lattice.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The principal axes are taken when their bounding box is smaller than this part of the object axes' one.
constexpr double kTighter = 0.9;

struct Bounds {
  Vector3d min = Vector3d::Constant(1e300), max = Vector3d::Constant(-1e300);
  void add(const Vector3d& point, double half = 0.0) {
    min = min.cwiseMin(point - Vector3d::Constant(half));
    max = max.cwiseMax(point + Vector3d::Constant(half));
  }
  double volume() const { return (max - min).prod(); }
};

Bounds bounds_along(const ParticleSet& particles, const Matrix3d& lattice_from_object) {
  Bounds bounds;
  for (size_t i = 0; i < particles.positions_m.size(); ++i) {
    bounds.add(lattice_from_object * particles.positions_m[i], 0.5 * std::cbrt(particles.volumes_m3[i]));
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
  Matrix3d axes = solver.eigenvectors();
  for (int d = 0; d < 3; ++d) {  // the sign of an eigenvector is arbitrary: its largest entry is made positive
    Eigen::Index largest;
    axes.col(d).cwiseAbs().maxCoeff(&largest);
    if (axes(largest, d) < 0.0) axes.col(d) = -axes.col(d);
  }
  if (axes.determinant() < 0.0) axes.col(2) = -axes.col(2);
  return axes;
}

// Whether the voxel centres alone describe the solid: they hold most of its volume, and reach to within a voxel of
// every face. Then mesh vertices, which would carry mass half outside the body, are contact samples only. A potted
// plant fails the second test: its leaves hold no voxel centre, and the pot must not be stretched over them.
bool voxels_fill(const ParticleSet& particles, double volume, const Matrix3d& lattice_from_object) {
  if (particles.on_surface.size() != particles.positions_m.size()) return false;
  Bounds voxels, all;
  size_t count = 0;
  for (size_t i = 0; i < particles.positions_m.size(); ++i) {
    const Vector3d centre = lattice_from_object * particles.positions_m[i];
    all.add(centre);
    if (particles.on_surface[i]) continue;
    voxels.add(centre, 0.5 * particles.spacing_m);
    ++count;
  }
  if (count == 0 || count == particles.positions_m.size()) return false;
  if (static_cast<double>(count) * std::pow(particles.spacing_m, 3) <= 0.5 * volume) return false;
  const double reach = particles.spacing_m;
  return ((voxels.min - all.min).cwiseAbs().array() <= reach).all() &&
         ((voxels.max - all.max).cwiseAbs().array() <= reach).all();
}

}  // namespace

BodyExtent measure_extent(const ParticleSet& particles) {
  BodyExtent extent;
  extent.spacing_m = particles.spacing_m;
  Matrix3d lattice_from_object = Matrix3d::Identity();
  const Matrix3d principal = principal_axes(particles).transpose();
  if (bounds_along(particles, principal).volume() < kTighter * bounds_along(particles, lattice_from_object).volume()) {
    lattice_from_object = principal;
  }
  extent.object_from_lattice = Eigen::Quaterniond(Matrix3d(lattice_from_object.transpose()));
  if (lattice_from_object.isIdentity()) extent.object_from_lattice.setIdentity();

  double volume = 0.0;
  for (const double v : particles.volumes_m3) volume += v;
  const bool voxels_only = voxels_fill(particles, volume, lattice_from_object);
  Bounds surface, material;
  double used = 0.0;
  for (size_t i = 0; i < particles.positions_m.size(); ++i) {
    const Vector3d centre = lattice_from_object * particles.positions_m[i];
    surface.add(centre);
    if (voxels_only && particles.on_surface[i]) continue;
    const double half = voxels_only ? 0.5 * particles.spacing_m : 0.5 * std::cbrt(particles.volumes_m3[i]);
    extent.boxes.push_back({centre, Vector3d::Constant(half), particles.volumes_m3[i]});
    material.add(centre, half);
    used += particles.volumes_m3[i];
  }
  extent.box_edge_m = voxels_only ? particles.spacing_m
                                  : std::cbrt(volume / static_cast<double>(particles.positions_m.size()));
  if (voxels_only) {
    // Whole voxels end before or after the true faces, which the mesh vertices know: stretched to them.
    const Vector3d stretch = (surface.max - surface.min).cwiseQuotient(material.max - material.min);
    for (MassBox& box : extent.boxes) {
      box.centre_m = surface.min + (box.centre_m - material.min).cwiseProduct(stretch);
      box.half_m = box.half_m.cwiseProduct(stretch);
      box.volume_m3 *= volume / used;
    }
    material = surface;
  }
  extent.min_m = material.min;
  extent.max_m = material.max;
  return extent;
}

}  // namespace livegs
