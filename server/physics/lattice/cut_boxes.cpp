// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/lattice/cut_boxes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace livegs {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Part of an interval within one cell and between two cuts: fraction of its length, mean and mean square of
// the local coordinate.
struct Slice {
  int cell;
  double part, mean, mean_square;
};

// `low`, `high` and `cuts` are in cells.
void cut_interval(double low, double high, std::span<const double> cuts, std::vector<double>& ends,
                  std::vector<Slice>& slices) {
  const auto snapped = [](double x) {
    const double plane = std::round(x);
    return std::abs(x - plane) < kMinSlice ? plane : x;
  };
  if (high - low > 4.0 * kMinSlice) {
    low = snapped(low);
    high = snapped(high);
  }
  ends.clear();
  for (double plane = std::floor(low) + 1.0; plane < high; plane += 1.0) ends.push_back(plane);
  const size_t planes = ends.size();
  const auto apart = [](double a, double b) { return std::abs(a - b) > 1e-9; };  // or merged
  for (const double cut : cuts) {
    if (cut <= low || cut >= high || !apart(cut, low) || !apart(cut, high)) continue;
    bool new_cut = true;
    for (const double end : ends) new_cut = new_cut && apart(cut, end);
    if (new_cut) ends.push_back(cut);
  }
  if (ends.size() > planes) std::ranges::sort(ends);
  ends.push_back(high);

  slices.clear();
  double begin = low;
  for (const double end : ends) {
    const double cell = std::floor(0.5 * (begin + end));
    const double from = 2.0 * (begin - cell) - 1.0, to = 2.0 * (end - cell) - 1.0;
    slices.push_back({static_cast<int>(cell), (end - begin) / (high - low), 0.5 * (from + to),
                      (from * from + from * to + to * to) / 3.0});
    begin = end;
  }
}

bool matters(const BodyRegion& region) { return !region.boundary && (region.fixed || region.material); }

// Whether a face of the region intersects the box.
bool straddles(const BodyExtent& extent, const MassBox& box, const BodyRegion& region) {
  const Eigen::AlignedBox3d bounds = in_object_axes(extent, box);
  const auto low = bounds.min().array(), high = bounds.max().array();
  const bool inside = (low >= region.min_m.array()).all() && (high <= region.max_m.array()).all();
  const bool outside = (low >= region.max_m.array()).any() || (high <= region.min_m.array()).any();
  return !inside && !outside;
}

}  // namespace

size_t material_count(std::span<const BodyRegion> regions) {
  size_t count = 1;
  for (const BodyRegion& region : regions) count += region.material.has_value();
  return count;
}

Eigen::AlignedBox3d in_object_axes(const BodyExtent& extent, const MassBox& box) {
  Eigen::AlignedBox3d bounds;
  for (int c = 0; c < 8; ++c)
    bounds.extend(extent.object_from_lattice * (box.centre_m + corner_sign(c).cwiseProduct(box.half_m)));
  return bounds;
}

bool along_object_axes(const BodyExtent& extent) {
  return extent.object_from_lattice.angularDistance(Eigen::Quaterniond::Identity()) <= 1e-9;
}

void cut_boxes(const BodyExtent& extent, const Vector3d& origin_m, double cell_width_m,
               std::span<const BodyRegion> regions, const std::function<void(const BoxPiece&)>& take) {
  const bool aligned = along_object_axes(extent);
  const double margin_m = 1e-6 * cell_width_m;

  std::array<std::vector<double>, 3> faces, cuts;  // in cells
  for (const BodyRegion& region : regions) {
    if (!matters(region) || !aligned) continue;
    for (int d = 0; d < 3; ++d) {
      for (const double face_m : {region.min_m[d], region.max_m[d]}) {
        faces[d].push_back((face_m - origin_m[d]) / cell_width_m);
      }
    }
  }

  std::array<std::vector<Slice>, 3> slices;
  std::vector<double> ends;
  for (uint32_t i = 0; i < extent.boxes.size(); ++i) {
    const MassBox& box = extent.boxes[i];
    bool straddling = false;
    if (!aligned) {
      for (const BodyRegion& region : regions)
        straddling = straddling || (matters(region) && straddles(extent, box, region));
    }
    for (int d = 0; d < 3; ++d) {
      const double centre = (box.centre_m[d] - origin_m[d]) / cell_width_m,
                   half = box.half_m[d] / cell_width_m;
      cuts[d].clear();
      for (int quarter = 1; straddling && quarter < 4; ++quarter) {
        cuts[d].push_back(centre + half * (0.5 * quarter - 1.0));
      }
      cut_interval(centre - half, centre + half, aligned ? faces[d] : cuts[d], ends, slices[d]);
    }
    for (const Slice& z : slices[2]) {
      for (const Slice& y : slices[1]) {
        for (const Slice& x : slices[0]) {
          BoxPiece piece{i,
                         {x.cell, y.cell, z.cell},
                         box.volume_m3 * x.part * y.part * z.part,
                         {x.mean, y.mean, z.mean},
                         {x.mean_square, y.mean_square, z.mean_square}};
          const Vector3d centre_m =
              extent.object_from_lattice *
              (origin_m + cell_width_m * (piece.cell.cast<double>() + 0.5 * (piece.mean + Vector3d::Ones())));
          uint16_t material = 0;
          for (const BodyRegion& region : regions) {
            if (region.material) ++material;
            if (!matters(region) || !region.contains(centre_m, margin_m)) continue;
            if (region.material) piece.material = material;
            piece.fixed = piece.fixed || region.fixed;
          }
          take(piece);
        }
      }
    }
  }
}

}  // namespace livegs
