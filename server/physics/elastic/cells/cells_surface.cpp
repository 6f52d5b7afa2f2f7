// SPDX-License-Identifier: GPL-3.0-or-later
// The contact surface of the body: points of its mesh, embedded in the cells, with the curvature about them.
#include <algorithm>
#include <cmath>

#include "physics/ablation/ablation.h"
#include "physics/collision/surface_points.h"
#include "physics/elastic/cells/cells_body.h"

namespace livegs::cells {
namespace {

// Largest local coordinate of a touching point that stays in the cell of its surface point.
constexpr double kMaxOwnLocal = 1.05;

}  // namespace

void CellsBody::make_surface(const std::vector<SurfacePatch>& patches) {
  struct Point {
    EmbeddedPoint at;
    const SurfacePatch* patch;
  };
  std::vector<Point> points;
  bool round = false;
  for (const SurfacePatch& patch : patches) {
    points.push_back({lattice_.embed(patch.rest_m), &patch});
    round = round || (patch.reach_m > 0.0 && !without(Mechanism::CurvedPatches));
  }
  std::ranges::stable_sort(points, {}, [](const Point& point) { return point.at.cell; });
  const Matrix3d lattice_from_object = extent_.object_from_lattice.conjugate().toRotationMatrix();
  const bool even_friction = std::ranges::all_of(materials_.regions, [](const RegionMaterial& one) {
    return !one.friction && one.friction_factor == 1.0;
  });
  for (uint32_t i = 0; i < points.size(); ++i) {
    const SurfacePatch& patch = *points[i].patch;
    surface_.points.push_back(sample_at(points[i].at));
    if (!even_friction) surface_.lattice_cells.push_back(static_cast<uint32_t>(points[i].at.cell));
    surface_.local.push_back(points[i].at.local.cast<float>());
    surface_.face_begins.push_back(static_cast<uint32_t>(surface_.face_normals.size()));
    for (const Vector3d& normal : patch.normals) {
      surface_.face_normals.push_back((lattice_from_object * normal).cast<float>());
    }
    if (i == 0 || points[i].at.cell != points[i - 1].at.cell) {
      surface_.cells.push_back({lattice_.cells[points[i].at.cell].nodes, i, i, {}});
    }
    surface_.cells.back().end = i + 1;
    surface_.cells.back().points.extend(surface_.local.back());
    if (!round) continue;
    CurvedPatch curved;
    if (patch.reach_m > 0.0) {
      const auto in_lattice = [&](const Matrix3d& m) {
        return (lattice_from_object * m * lattice_from_object.transpose()).cast<float>().eval();
      };
      curved.bulge = (lattice_from_object * patch.bulge).cast<float>();
      curved.curvature = in_lattice(patch.curvature);
      curved.flatten = in_lattice(patch.flatten);
      curved.reach_m = static_cast<float>(patch.reach_m);
      curved.radius_m = static_cast<float>(patch.flatten.squaredNorm() / patch.flatten.trace());
      curved.lowest_m =
          static_cast<float>(std::min(1.0, patch.curvature.norm() * patch.reach_m) * patch.reach_m);
      // The box of the cell's points covers the patches.
      const Vector3d across = (1.0 - curved.bulge.cast<double>().array().square()).max(0.0).sqrt();
      const Eigen::Vector3f room = (2.0 * patch.reach_m / lattice_.cell_width_m * across).cast<float>();
      surface_.cells.back().points.extend(Eigen::Vector3f(surface_.local.back() + room));
      surface_.cells.back().points.extend(Eigen::Vector3f(surface_.local.back() - room));
    }
    surface_.patches.push_back(curved);
  }
  surface_.face_begins.push_back(static_cast<uint32_t>(surface_.face_normals.size()));
}

NodeSample CellsBody::touching_sample(uint32_t i, const Vector3d& normal) const {
  const CurvedPatch& patch = surface_.patches[i];
  const NodeSample& own = surface_.points[i];
  // The deformed surface is lowest against the normal where the surface at rest is against F^T normal.
  const auto gradients = trilinear_gradients(surface_.local[i].cast<double>(), lattice_.cell_width_m);
  Vector3d direction = Vector3d::Zero();
  for (int c = 0; c < 8; ++c) direction += normal.dot(nodes_.corrected_m(own.nodes[c])) * gradients[c];
  const double length = direction.norm();
  if (!(length > 0.0)) return own;
  // Hertz: a contact with this load and radius of curvature has this radius.
  const double contact_m = std::cbrt(0.75 * loads_.pressed_n * patch.radius_m / plane_strain_modulus_pa());
  const double share = std::clamp(2.0 - contact_m / patch.reach_m, 0.0, 1.0);
  const Vector3d offset = share * touching_offset({{},
                                                   {},
                                                   patch.bulge.cast<double>(),
                                                   patch.curvature.cast<double>(),
                                                   patch.flatten.cast<double>(),
                                                   patch.reach_m},
                                                  direction / length);
  const Vector3d local = surface_.local[i].cast<double>() + 2.0 / lattice_.cell_width_m * offset;
  if (local.cwiseAbs().maxCoeff() > std::max<double>(kMaxOwnLocal, surface_.local[i].cwiseAbs().maxCoeff())) {
    Vector3d rest = lattice_.object_from_lattice.orientation * offset;
    for (int c = 0; c < 8; ++c) rest += own.weights[c] * lattice_.node_position_m(own.nodes[c]);
    return sample_at(lattice_.embed(rest));
  }
  return sample_of(own.nodes, local);
}

}  // namespace livegs::cells
