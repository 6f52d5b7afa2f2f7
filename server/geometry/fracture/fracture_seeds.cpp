// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/fracture/fracture_seeds.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "geometry/field/inside_grid.h"
#include "geometry/mesh/mesh_topology.h"

namespace livegs {
namespace {

// Approximate number of nodes of the grid of inside points; candidates are jittered nodes. With 64 nodes per
// side, walls of a 60th of the size are still sampled.
constexpr double kGridNodes = 64.0 * 64.0 * 64.0;
constexpr size_t kMinInsidePoints = 4000;
// Candidates per seed. A larger value distributes seeds more evenly, a smaller one more randomly.
constexpr size_t kCandidates = 12;

class Random {
 public:
  explicit Random(uint64_t seed) : bits_(seed * 0x9E3779B97F4A7C15ull + 0x2545F4914F6CDD1Dull) {}
  double uniform() { return static_cast<double>(bits_() >> 11) * 0x1.0p-53; }
  size_t below(size_t count) { return static_cast<size_t>(uniform() * static_cast<double>(count)); }

 private:
  std::mt19937_64 bits_;
};

double density(const Eigen::Vector3d& point, const SeedOptions& options, double reach_m) {
  double nearest = 0.0;
  for (const auto& impact : options.impacts_m) {
    nearest = std::max(nearest, std::exp(-(point - impact).squaredNorm() / (reach_m * reach_m)));
  }
  return 1.0 + (options.impact_density - 1.0) * nearest;
}

// Returns the inside nodes of a grid that is refined until it has at least kMinInsidePoints of them.
std::vector<Eigen::Vector3d> inside_points(const TriangleMesh& mesh, const Eigen::AlignedBox3d& bounds,
                                           double& cell_m) {
  const Eigen::Vector3d size = bounds.sizes().cwiseMax(1e-3 * bounds.sizes().maxCoeff());
  std::vector<Eigen::Vector3d> points;
  cell_m = std::cbrt(size.prod() / kGridNodes);
  for (int attempt = 0; attempt < 4 && points.size() < kMinInsidePoints; ++attempt, cell_m *= 0.6) {
    points.clear();
    RegularGrid grid;
    grid.cell_m = affordable_cell_m(cell_m, bounds.sizes());
    grid.origin_m = bounds.min().array() + 0.37 * grid.cell_m;  // offset from axis-aligned faces
    grid.counts = (bounds.sizes() / grid.cell_m).array().ceil().cast<int>().max(1);
    const std::vector<uint8_t> inside = nodes_inside(mesh, grid);
    for (int k = 0; k < grid.counts.z(); ++k) {
      for (int j = 0; j < grid.counts.y(); ++j) {
        for (int i = 0; i < grid.counts.x(); ++i) {
          if (inside[grid.index(i, j, k)]) points.push_back(grid.point_m(i, j, k));
        }
      }
    }
  }
  return points;
}

}  // namespace

Result<std::vector<Eigen::Vector3d>> fracture_seeds(const TriangleMesh& mesh, const SeedOptions& options) {
  if (options.count < 1 || options.count > kMaxSeeds) {
    return invalid_argument("fracture: " + std::to_string(options.count) + " pieces requested; give 1 to " +
                            std::to_string(kMaxSeeds));
  }
  if (!(options.impact_density >= 1.0 && options.impact_density <= 1e3) ||
      !(options.impact_reach > 0.0 && options.impact_reach <= 1e3)) {
    return invalid_argument(
        "fracture: impact_density or impact_reach is out of range; give 1 to 1000 and 0 to 1000");
  }
  for (const auto& impact : options.impacts_m) {
    if (!impact.allFinite()) return invalid_argument("fracture: an impact point is not finite");
  }
  const Eigen::AlignedBox3d bounds = mesh_bounds_m(mesh);
  if (mesh.triangles.empty() || !bounds.sizes().allFinite()) {
    return invalid_data("fracture: the mesh is empty or not finite");
  }
  double cell_m = 0.0;
  std::vector<Eigen::Vector3d> points = inside_points(mesh, bounds, cell_m);
  if (points.empty()) {
    return invalid_data("fracture: the mesh encloses no volume; make a closed one with reconstruct_surface");
  }

  Random random(options.seed);
  const double reach_m = options.impact_reach * bounds.diagonal().norm();
  std::vector<Eigen::Vector3d> seeds;
  while (seeds.size() < options.count) {
    // Rejection sampling, with a probability proportional to the local density.
    Eigen::Vector3d best = points[0];
    double best_score = -1.0;
    for (size_t tried = 0; tried < kCandidates; ++tried) {
      Eigen::Vector3d candidate;
      double weight = 0.0;
      do {
        candidate = points[random.below(points.size())];
        weight = density(candidate, options, reach_m);
      } while (random.uniform() * options.impact_density > weight);
      // A jitter of a tenth of a cell, so that seeds and bisector planes do not coincide with the grid.
      for (int axis = 0; axis < 3; ++axis) candidate[axis] += 0.1 * cell_m * (random.uniform() - 0.5);
      double nearest = 1e300;
      for (const auto& seed : seeds) nearest = std::min(nearest, (candidate - seed).norm());
      const double score = nearest * std::cbrt(weight);
      if (score > best_score) best_score = score, best = candidate;
    }
    seeds.push_back(best);
  }
  return seeds;
}

}  // namespace livegs
