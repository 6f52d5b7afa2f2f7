// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/hollow_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>
#include <vector>

#include "core/parallel_for.h"
#include "geometry/field/distance_field.h"
#include "geometry/mesh/mesh_topology.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

constexpr double kMinCells = 32.0, kMaxHollowCells = 96.0;
constexpr double kCellsOfWall = 1.5;  // target number of cells across the wall
// Minimum distance of vertices from the ends of an edge, relative to the edge; keeps vertices distinct.
constexpr double kVertexClearance = 0.02;
// Minimum volume of a part of the cavity, relative to the cavity; smaller parts are dropped.
constexpr double kMinComponentShare = 0.01;
// Minimum volume of the cavity relative to the outer surface's; a body with less air is not a shell.
constexpr double kMinHollowShare = 0.1;

// Each cube is split into six tetrahedra around its diagonal (Kuhn 1960), so that neighbours share the
// diagonals of their faces. Corner bits: 1 along x, 2 along y, 4 along z.
constexpr std::array<std::array<int, 4>, 6> kTetrahedra{
    {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};

struct Grid {
  double cell_m;
  Vector3d origin_m;
  Eigen::Vector3i counts;
  std::vector<double> values;  // negative in the cavity

  size_t index(int x, int y, int z) const {
    return static_cast<size_t>(x) +
           static_cast<size_t>(counts.x()) *
               (static_cast<size_t>(y) + static_cast<size_t>(counts.y()) * static_cast<size_t>(z));
  }
  Vector3d node(size_t index) const {
    const auto nx = static_cast<size_t>(counts.x()), ny = static_cast<size_t>(counts.y());
    const Vector3d steps(static_cast<double>(index % nx), static_cast<double>(index / nx % ny),
                         static_cast<double>(index / (nx * ny)));
    return origin_m + cell_m * steps;
  }
};

Grid depth_grid(const TriangleMesh& mesh, double wall_m) {
  const Eigen::AlignedBox3d bounds = mesh_bounds_m(mesh);
  const double longest = bounds.sizes().maxCoeff();
  Grid grid;
  grid.cell_m = longest / std::clamp(kCellsOfWall * longest / wall_m, kMinCells, kMaxHollowCells);
  grid.origin_m = bounds.min() - Vector3d::Constant(0.5 * grid.cell_m);
  grid.counts = (bounds.sizes() / grid.cell_m).array().ceil().cast<int>() + 2;
  const DistanceField field(mesh, grid.cell_m, grid.cell_m);
  grid.values.resize(static_cast<size_t>(grid.counts.prod()));
  parallel_for(grid.values.size(), 4096, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) grid.values[i] = field.sample(grid.node(i)).distance_m + wall_m;
  });
  return grid;
}

// Returns the surface where the values are 0. It faces the negative side.
TriangleMesh level_set(const Grid& grid) {
  TriangleMesh mesh;
  std::map<std::pair<size_t, size_t>, uint32_t> vertices;
  const auto vertex = [&](size_t a, size_t b) {
    if (a > b) std::swap(a, b);
    const auto [at, fresh] = vertices.try_emplace({a, b}, static_cast<uint32_t>(mesh.vertices_m.size()));
    if (fresh) {
      const double share = std::clamp(grid.values[a] / (grid.values[a] - grid.values[b]), kVertexClearance,
                                      1.0 - kVertexClearance);
      mesh.vertices_m.push_back((1.0 - share) * grid.node(a) + share * grid.node(b));
    }
    return at->second;
  };
  const auto add = [&](uint32_t a, uint32_t b, uint32_t c, const Vector3d& towards) {
    const Vector3d& corner = mesh.vertices_m[a];
    const Vector3d normal = (mesh.vertices_m[b] - corner).cross(mesh.vertices_m[c] - corner);
    if (normal.dot(towards) > 0.0) {
      mesh.triangles.push_back({a, b, c});
    } else {
      mesh.triangles.push_back({a, c, b});
    }
  };
  for (int z = 0; z + 1 < grid.counts.z(); ++z) {
    for (int y = 0; y + 1 < grid.counts.y(); ++y) {
      for (int x = 0; x + 1 < grid.counts.x(); ++x) {
        for (const std::array<int, 4>& corners : kTetrahedra) {
          std::vector<size_t> in, out;
          for (const int corner : corners) {
            const size_t node = grid.index(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2 & 1));
            (grid.values[node] < 0.0 ? in : out).push_back(node);
          }
          if (in.empty() || out.empty()) continue;
          const Vector3d towards = grid.node(in[0]) - grid.node(out[0]);
          if (in.size() == 1)
            add(vertex(in[0], out[0]), vertex(in[0], out[1]), vertex(in[0], out[2]), towards);
          if (out.size() == 1)
            add(vertex(in[0], out[0]), vertex(in[1], out[0]), vertex(in[2], out[0]), towards);
          if (in.size() == 2) {
            const uint32_t a = vertex(in[0], out[0]), b = vertex(in[0], out[1]), c = vertex(in[1], out[1]),
                           d = vertex(in[1], out[0]);
            add(a, b, c, towards);
            add(a, c, d, towards);
          }
        }
      }
    }
  }
  return mesh;
}

// Returns the volume of each part of a mesh.
std::vector<double> part_volumes(const TriangleMesh& mesh, const std::vector<int>& part_of) {
  std::vector<double> volumes;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const auto part = static_cast<size_t>(part_of[t]);
    if (part >= volumes.size()) volumes.resize(part + 1, 0.0);
    volumes[part] += mesh.vertices_m[a].dot(mesh.vertices_m[b].cross(mesh.vertices_m[c])) / 6.0;
  }
  return volumes;
}

}  // namespace

Result<TriangleMesh> hollow_mesh(const TriangleMesh& mesh, double wall_m) {
  const double longest = mesh_bounds_m(mesh).sizes().maxCoeff();
  const auto refuse = [&](const char* why) {
    char text[160];
    std::snprintf(text, sizeof text, "wall_thickness_m %g of a shell %g m long %s", wall_m, longest, why);
    return invalid_argument(text);
  };
  if (!(wall_m >= kMinWallShare * longest))
    return refuse("is too thin to be cut; give at least a 64th of the length");
  const TriangleMesh inner = level_set(depth_grid(mesh, wall_m));
  if (inner.triangles.empty()) return refuse("leaves no cavity; set fill to SOLID");
  const std::vector<int> part_of = mesh_pieces(inner);
  const std::vector<double> volumes = part_volumes(inner, part_of);
  double hollow = 0.0;
  for (const double volume : volumes) hollow += std::abs(volume);

  TriangleMesh both = mesh;
  const auto first = static_cast<uint32_t>(both.vertices_m.size());
  both.vertices_m.insert(both.vertices_m.end(), inner.vertices_m.begin(), inner.vertices_m.end());
  for (size_t t = 0; t < inner.triangles.size(); ++t) {
    if (std::abs(volumes[static_cast<size_t>(part_of[t])]) < kMinComponentShare * hollow) continue;
    const auto& [a, b, c] = inner.triangles[t];
    both.triangles.push_back({first + a, first + b, first + c});
  }
  return both;
}

bool has_hollow(const TriangleMesh& mesh) {
  const std::vector<double> volumes = part_volumes(mesh, mesh_pieces(mesh));
  double outer = 0.0, hollow = 0.0;
  for (const double volume : volumes) (volume < 0.0 ? hollow : outer) += std::abs(volume);
  return hollow > kMinHollowShare * outer;
}

}  // namespace livegs
