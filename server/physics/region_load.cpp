// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/region_load.h"

#include "physics/cut_boxes.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

struct Bounds {
  Vector3d min_m = Vector3d::Constant(1e300), max_m = Vector3d::Constant(-1e300);
};

Bounds bounds_in_object_axes(const BodyExtent& extent) {
  if (along_object_axes(extent)) return {extent.min_m, extent.max_m};
  Bounds bounds;
  for (const MassBox& box : extent.boxes) {
    for (int c = 0; c < 8; ++c) {
      const Vector3d sign(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1);
      const Vector3d corner = extent.object_from_lattice * (box.centre_m + sign.cwiseProduct(box.half_m));
      bounds.min_m = bounds.min_m.cwiseMin(corner);
      bounds.max_m = bounds.max_m.cwiseMax(corner);
    }
  }
  return bounds;
}

}  // namespace

std::vector<LoadPoint> load_points(const BodyExtent& extent, const Lattice& lattice, const BodyRegion& region) {
  const Bounds body = bounds_in_object_axes(extent);
  // The cutter tells pieces inside a region by its material.
  BodyRegion loaded;
  loaded.min_m = region.min_m.cwiseMax(body.min_m);
  loaded.max_m = region.max_m.cwiseMin(body.max_m);
  loaded.material.emplace();
  const Vector3d size_m = loaded.max_m - loaded.min_m;
  if ((size_m.array() <= 0.0).any()) return {};
  int across = 0;
  for (int d = 1; d < 3; ++d) {
    if (size_m[d] < (1.0 - 1e-9) * size_m[across]) across = d;
  }
  const bool upper = body.max_m[across] - loaded.max_m[across] <= loaded.min_m[across] - body.min_m[across];
  const double face_m = upper ? loaded.max_m[across] : loaded.min_m[across];

  std::vector<LoadPoint> points;
  const Vector3d origin_m = lattice.object_from_lattice.orientation.conjugate() * lattice.object_from_lattice.position_m;
  cut_boxes(extent, origin_m, lattice.cell_width_m, {&loaded, 1}, [&](const BoxPiece& piece) {
    if (piece.material != 1) return;
    Vector3d point_m = lattice.object_from_lattice *
                       (lattice.cell_width_m * (piece.cell.cast<double>() + 0.5 * (piece.mean + Vector3d::Ones())));
    point_m[across] = face_m;
    points.push_back({lattice.embed(point_m), piece.volume_m3 / size_m[across]});
  });
  return points;
}

}  // namespace livegs
