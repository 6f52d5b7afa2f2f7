// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/lattice/region_load.h"

#include <Eigen/Geometry>
#include <map>
#include <utility>

#include "geometry/field/inside_grid.h"
#include "physics/lattice/cut_boxes.h"

namespace livegs {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

// For meshes: columns across a face along each edge. Each has a third as many samples along its depth.
constexpr int kColumns = 48;

struct BoxFace {
  Vector3d min_m, max_m;  // of the region, clipped to the body's bounds
  int across;
  double at_m;
};

BoxFace face_of(const AlignedBox3d& body, const BodyRegion& region) {
  BoxFace face{region.min_m.cwiseMax(body.min()), region.max_m.cwiseMin(body.max()), 0, 0.0};
  const Vector3d size_m = face.max_m - face.min_m;
  for (int d = 1; d < 3; ++d) {
    if (size_m[d] < (1.0 - 1e-9) * size_m[face.across]) face.across = d;
  }
  const int d = face.across;
  face.at_m = body.max()[d] - face.max_m[d] <= face.min_m[d] - body.min()[d] ? face.max_m[d] : face.min_m[d];
  return face;
}

// Load points from the mesh itself: boxes about the particles of a body thinner than a voxel are not where
// the mesh is. Each column of the region has the area of its face times the fraction of its depth that is
// inside. The columns in a quarter of a cell act as one point. A full face has four, so that a cell held by
// them cannot rotate.
std::vector<LoadPoint> load_mesh(const ParticleSet& particles, const Lattice& lattice,
                                 const BodyRegion& region) {
  AlignedBox3d body;
  for (const Vector3d& vertex : particles.mesh_vertices_m) body.extend(vertex);
  const BoxFace face = face_of(body, region);
  const Vector3d size_m = face.max_m - face.min_m;
  if ((size_m.array() <= 0.0).any()) return {};
  RegularGrid grid;
  grid.counts.setConstant(kColumns);
  grid.counts[face.across] = kColumns / 3;
  grid.origin_m = Vector3d::Constant(0.5);
  const Vector3d edge_m = size_m.cwiseQuotient(grid.counts.cast<double>());
  TriangleMesh mesh;
  mesh.triangles = particles.mesh_triangles;
  for (const Vector3d& vertex : particles.mesh_vertices_m) {
    mesh.vertices_m.push_back((vertex - face.min_m).cwiseQuotient(edge_m));
  }
  const std::vector<uint8_t> inside = nodes_inside(mesh, grid);

  struct Quarter {
    double area_m2 = 0.0;
    Vector3d local = Vector3d::Zero();
  };
  std::map<std::pair<uint32_t, int>, Quarter> quarters;
  const int a = face.across, u = (a + 1) % 3, v = (a + 2) % 3;
  for (int i = 0; i < kColumns; ++i) {
    for (int j = 0; j < kColumns; ++j) {
      Eigen::Vector3i at;
      at[u] = i;
      at[v] = j;
      int deep = 0;
      for (at[a] = 0; at[a] < grid.counts[a]; ++at[a]) deep += inside[grid.index(at.x(), at.y(), at.z())];
      if (deep == 0) continue;
      Vector3d point_m = face.min_m + edge_m.cwiseProduct(at.cast<double>() + grid.origin_m);
      point_m[a] = face.at_m;
      const EmbeddedPoint point = lattice.embed(point_m);
      const int part = (point.local.x() > 0.0) + 2 * (point.local.y() > 0.0) + 4 * (point.local.z() > 0.0);
      Quarter& quarter = quarters[{point.cell, part}];
      const double area_m2 = edge_m[u] * edge_m[v] * deep / grid.counts[a];
      quarter.area_m2 += area_m2;
      quarter.local += area_m2 * point.local;
    }
  }
  std::vector<LoadPoint> points;
  for (const auto& [place, quarter] : quarters) {
    points.push_back({{place.first, quarter.local / quarter.area_m2}, quarter.area_m2});
  }
  return points;
}

AlignedBox3d bounds_in_object_axes(const BodyExtent& extent) {
  if (along_object_axes(extent)) return {extent.min_m, extent.max_m};
  AlignedBox3d bounds;
  for (const MassBox& box : extent.boxes) bounds.extend(in_object_axes(extent, box));
  return bounds;
}

}  // namespace

std::vector<LoadPoint> load_points(const ParticleSet& particles, const BodyExtent& extent,
                                   const Lattice& lattice, const BodyRegion& region) {
  std::vector<LoadPoint> points;
  if (!particles.mesh_triangles.empty()) points = load_mesh(particles, lattice, region);
  if (!points.empty()) return points;
  const BoxFace face = face_of(bounds_in_object_axes(extent), region);
  // The cutter marks pieces inside a region by its material.
  BodyRegion loaded;
  loaded.min_m = face.min_m;
  loaded.max_m = face.max_m;
  loaded.material.emplace();
  const Vector3d size_m = loaded.max_m - loaded.min_m;
  if ((size_m.array() <= 0.0).any()) return {};

  const Vector3d origin_m =
      lattice.object_from_lattice.orientation.conjugate() * lattice.object_from_lattice.position_m;
  cut_boxes(extent, origin_m, lattice.cell_width_m, {&loaded, 1}, [&](const BoxPiece& piece) {
    if (piece.material != 1) return;
    Vector3d point_m =
        lattice.object_from_lattice *
        (lattice.cell_width_m * (piece.cell.cast<double>() + 0.5 * (piece.mean + Vector3d::Ones())));
    point_m[face.across] = face.at_m;
    points.push_back({lattice.embed(point_m), piece.volume_m3 / size_m[face.across]});
  });
  return points;
}

}  // namespace livegs
