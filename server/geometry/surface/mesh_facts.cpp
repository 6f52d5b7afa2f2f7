// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/mesh_facts.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "core/parallel_for.h"
#include "geometry/field/distance_field.h"
#include "geometry/field/inside_grid.h"
#include "geometry/mesh/convex_hull.h"
#include "geometry/mesh/mass_properties.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/mesh/smallest_box.h"

namespace livegs {
namespace {

// Resolution of the openness: cells along the longest side, and rays per cell. 24 cells resolve the mouth of
// a cup; more cells change the result only slightly.
constexpr int kOpennessCells = 24;
constexpr int kOpennessRays = 48;
// Minimum fraction of rays that hit the body from a point in a cavity. It is 0.5 in the mouth of a cup and
// 0.9 at half its depth, 0.72 halfway into a hemispherical bowl, and below 0.5 in front of a plate.
constexpr double kMaxHollowFill = 0.65;
constexpr int kMaxSteps = 64;

// Returns 0 at `low` and 1 at `high`, linear in the logarithm.
double score(double value, double low, double high) {
  if (!(value > 0.0)) return 0.0;
  return std::clamp(std::log(value / low) / std::log(high / low), 0.0, 1.0);
}

// Returns directions distributed evenly over the sphere (a Fibonacci lattice).
std::vector<Eigen::Vector3d> ray_directions() {
  std::vector<Eigen::Vector3d> directions;
  for (int n = 0; n < kOpennessRays; ++n) {
    const double y = 1.0 - (2.0 * n + 1.0) / kOpennessRays;
    const double radius = std::sqrt(1.0 - y * y);
    const double turn = 2.0 * std::numbers::pi * n / std::numbers::phi;
    directions.emplace_back(radius * std::cos(turn), y, radius * std::sin(turn));
  }
  return directions;
}

// Returns whether the ray hits the surface inside the box, by sphere tracing. A sheet thinner than a cell
// appears in the field as a minimum of at most half a cell.
bool meets_body(const DistanceField& field, const Eigen::AlignedBox3d& box, Eigen::Vector3d place,
                const Eigen::Vector3d& way) {
  for (int step = 0; step < kMaxSteps && box.contains(place); ++step) {
    const double distance_m = field.sample(place).distance_m;
    if (distance_m < 0.55 * field.cell_m()) return true;
    place += std::max(0.9 * distance_m, 0.5 * field.cell_m()) * way;
  }
  return false;
}

// Returns the volume outside the body and inside its hull from which most rays hit the body.
double hollow_volume_m3(const TriangleMesh& mesh, const TriangleMesh& hull) {
  const Eigen::AlignedBox3d bounds = mesh_bounds_m(mesh);
  const double cell_m = bounds.sizes().maxCoeff() / kOpennessCells;
  const DistanceField field(mesh, cell_m, cell_m);
  RegularGrid grid;
  grid.cell_m = cell_m;
  grid.origin_m = bounds.min().array() + 0.5 * cell_m;
  grid.counts = ((bounds.sizes() / cell_m).array() - 1e-6).ceil().cast<int>().max(1);
  const std::vector<uint8_t> in_hull = nodes_inside(hull, grid);
  const std::vector<Eigen::Vector3d> directions = ray_directions();
  std::vector<uint8_t> hollow(grid.size(), 0);
  parallel_for(grid.size(), 256, [&](size_t begin, size_t end) {
    for (size_t node = begin; node < end; ++node) {
      if (!in_hull[node]) continue;
      const auto row = node / grid.counts.x();
      const Eigen::Vector3d place =
          grid.point_m(static_cast<int>(node % grid.counts.x()), static_cast<int>(row % grid.counts.y()),
                       static_cast<int>(row / grid.counts.y()));
      if (field.sample(place).distance_m < 0.55 * cell_m) continue;
      int met = 0;
      for (const auto& way : directions) met += meets_body(field, bounds, place, way);
      hollow[node] = met >= kMaxHollowFill * kOpennessRays;
    }
  });
  return static_cast<double>(std::count(hollow.begin(), hollow.end(), 1)) * cell_m * cell_m * cell_m;
}

}  // namespace

MeshFacts mesh_facts(const TriangleMesh& mesh) {
  const MassProperties solid = solid_mass_properties(mesh);
  MeshFacts facts;
  facts.size_m = mesh_bounds_m(mesh).sizes();
  facts.volume_m3 = solid.volume_m3;
  facts.area_m2 = solid.area_m2;
  facts.mean_wall_m = 2.0 * solid.volume_m3 / solid.area_m2;
  const std::vector<int> pieces = mesh_pieces(mesh);
  facts.piece_count = *std::max_element(pieces.begin(), pieces.end()) + 1;

  // A box of edge e has a variance of e²/12 along it.
  const Eigen::Matrix3d spread =
      0.5 * solid.inertia_m2.trace() * Eigen::Matrix3d::Identity() - solid.inertia_m2;
  const Eigen::Vector3d variances =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread, Eigen::EigenvaluesOnly).eigenvalues();
  facts.principal_size_m = (12.0 * variances.cwiseMax(0.0).reverse()).cwiseSqrt();

  const TriangleMesh hull = convex_hull(mesh.vertices_m);
  facts.hull_volume_m3 = hull.triangles.empty() ? solid.volume_m3 : signed_volume_m3(hull);
  facts.box_m = facts.size_m;
  std::sort(facts.box_m.data(), facts.box_m.data() + 3, std::greater<>());
  if (!hull.triangles.empty()) facts.box_m = smallest_box_m(hull);
  facts.solidity = std::clamp(solid.volume_m3 / facts.hull_volume_m3, 0.0, 1.0);
  if (!hull.triangles.empty()) {
    const double hollow_m3 = hollow_volume_m3(mesh, hull);
    facts.openness = hollow_m3 / (hollow_m3 + solid.volume_m3);
  }
  facts.rod = score(facts.principal_size_m[0] / facts.principal_size_m[1], 2.5, 10.0);
  // Width of the unrolled sheet of half the area. For a rod it equals the thickness.
  const double width_m = facts.area_m2 / (2.0 * facts.principal_size_m[0]);
  facts.thin_sheet = score(width_m / facts.mean_wall_m, 12.0, 50.0);
  return facts;
}

}  // namespace livegs
