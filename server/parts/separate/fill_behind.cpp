// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/separate/fill_behind.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel_for.h"
#include "parts/graph/kernel_tree.h"
#include "parts/label/choose_kernels.h"
#include "parts/views/room_view.h"

namespace livegs {
namespace {

using Eigen::Vector2i;
using Eigen::Vector3d;

constexpr double kFoot_voxels = 2.5;      // height of a thing that counts as its foot
constexpr double kFootCell_voxels = 1.2;  // cells of the area of a foot; below one it falls apart
constexpr double kOffPlane_voxels = 1.5;  // of a surface that is not the plane
constexpr int kRing_px = 4;               // width of the rim that is compared
constexpr double kAround_radii = 3.0;     // half width of the picture, in radii of the foot
constexpr double kMinAround_px = 40, kMaxAround_px = 480;
constexpr double kCameraHeight = 6.0;  // in half widths of the picture: nearly parallel rays
constexpr int kSearchStep_px = 2;
constexpr int kKernelStep_px = 2;
constexpr double kFillAcross = 0.62, kFillThick = 0.06;  // deviations in kernel distances
constexpr float kFillOpacity = 0.97f;
constexpr int kLaplaceRounds = 400;
constexpr size_t kMinFootKernels = 8;

enum PixelKind : uint8_t { kOutside, kPlane, kHole };

// The picture of a plane from the front.
struct PlanePicture {
  int width = 0, height = 0;
  std::vector<Eigen::Vector3f> rgb;
  std::vector<uint8_t> kind;
  std::vector<Vector3d> point_m;  // on the plane

  size_t at(const Vector2i& p) const { return static_cast<size_t>(p.y()) * width + p.x(); }
  bool inside(const Vector2i& p) const { return p.x() >= 0 && p.y() >= 0 && p.x() < width && p.y() < height; }
};

void add_flat_kernel(GaussianAsset& asset, const Vector3d& point_m, const Vector3d& u, const Vector3d& normal,
                     double distance_m, const Eigen::Vector3f& rgb) {
  Eigen::Matrix3d axes;
  axes.col(0) = u;
  axes.col(2) = normal;
  axes.col(1) = normal.cross(u);
  asset.positions.push_back(point_m.cast<float>());
  asset.rotations.push_back(Eigen::Quaterniond(axes).normalized().cast<float>());
  const auto across = static_cast<float>(std::log(kFillAcross * distance_m));
  asset.log_scales.push_back({across, across, static_cast<float>(std::log(kFillThick * distance_m))});
  asset.opacity_logits.push_back(std::log(kFillOpacity / (1 - kFillOpacity)));
  asset.sh_dc.push_back((rgb.array() - 0.5f).matrix() / kShBand0);
  asset.sh_rest.resize(asset.sh_rest.size() + asset.sh_rest_count(), Eigen::Vector3f::Zero());
}

// Where a thing meets a plane: its kernels within a few voxels of it.
std::vector<Eigen::Vector3f> foot_points(const SplitRoom& room, const RoomPlane& plane, uint16_t label,
                                         double reach_m) {
  std::vector<Eigen::Vector3f> foot;
  for (size_t k = 0; k < room.asset.size(); ++k)
    if (room.label[k] == label && plane.height_m(room.asset.positions[k].cast<double>()) < reach_m)
      foot.push_back(room.asset.positions[k]);
  return foot;
}

// A point whose surroundings are all below the foot.
bool inside_foot(const PlaneRegion& foot, const RoomPlane& plane, const Vector3d& point_m) {
  const Vector3d u = foot.cell_m() * foot.u(), v = foot.cell_m() * foot.v();
  const Vector3d at = point_m - plane.height_m(point_m) * plane.normal;
  return foot.contains(at) && foot.contains(at + u) && foot.contains(at - u) && foot.contains(at + v) &&
         foot.contains(at - v);
}

PlanePicture look_at_plane(const SplitRoom& room, const RoomParts& parts, const RoomPlane& plane,
                           const PlaneRegion& foot, const Vector3d& middle_m, double half_m,
                           std::vector<uint32_t>& hidden) {
  const double pixel_m = parts.footprint_m;
  const int edge =
      2 * static_cast<int>(std::ceil(std::clamp(half_m / pixel_m, kMinAround_px, kMaxAround_px)));
  const double height_m = kCameraHeight * half_m;
  Camera camera = look_at(middle_m + height_m * plane.normal, middle_m, plane.region.u(), 0.5, edge, edge);
  camera.focal_x_px = camera.focal_y_px = 0.5 * edge * height_m / half_m;
  camera.near_m = 0.05 * height_m;
  // Only what is near the plane: a shelf or a lamp above it must not hide it.
  GaussianAsset near;
  near.sh_degree = room.asset.sh_degree;
  near.antialiased = room.asset.antialiased;
  std::vector<uint32_t> source;
  const double reach_m = kOffPlane_voxels * parts.voxel_m + 3 * plane.deviation_m;
  for (size_t k = 0; k < room.asset.size(); ++k) {
    if (room.label[k] != kRoomLabel) continue;
    const Vector3d p = room.asset.positions[k].cast<double>();
    if ((p - middle_m).norm() > 3 * half_m || plane.height_m(p) > 4 * reach_m) continue;
    append_kernel(near, room.asset, k);
    source.push_back(static_cast<uint32_t>(k));
  }
  const PosedKernels posed = pose_in_place(near);
  KernelRasteriser rasteriser;
  KernelView view;
  rasteriser.draw({&near, &posed, 0}, camera, view);
  PlanePicture picture;
  picture.width = picture.height = edge;
  const size_t pixels = static_cast<size_t>(edge) * edge;
  picture.rgb.resize(pixels);
  picture.kind.resize(pixels);
  picture.point_m.resize(pixels);
  const ViewRays rays(camera);
  for (int y = 0; y < edge; ++y)
    for (int x = 0; x < edge; ++x) {
      const size_t i = static_cast<size_t>(y) * edge + x;
      const Vector3d far = rays.point_m(x, y, height_m);
      picture.point_m[i] = far - plane.height_m(far) * plane.normal;
      const float* rgba = view.image.at(x, y);
      picture.rgb[i] = Eigen::Vector3f(rgba[0], rgba[1], rgba[2]) / std::max(rgba[3], 0.5f);
      const uint32_t kernel = view.kernel[i];
      const bool seen = kernel != kNoKernel && parts.share[room.source[source[kernel]]] > 0 &&
                        std::abs(plane.height_m(rays.point_m(x, y, view.depth_m[i]))) < reach_m;
      // Below the inside of the foot no view can look; kernels there show only after the thing is gone.
      picture.kind[i] = inside_foot(foot, plane, picture.point_m[i]) ? kHole
                        : seen                                       ? kPlane
                        : foot.contains(picture.point_m[i])          ? kHole
                                                                     : kOutside;
    }
  // Kernels near the plane that only the thing hid.
  for (size_t n = 0; n < near.size(); ++n) {
    const Vector3d p = near.positions[n].cast<double>();
    if (std::abs(plane.height_m(p)) < 2 * reach_m &&
        (inside_foot(foot, plane, p) || (parts.share[room.source[source[n]]] == 0 && foot.contains(p))))
      hidden.push_back(source[n]);
  }
  return picture;
}

// Pixels within a few pixels of the hole that show the plane.
std::vector<Vector2i> rim_of(const PlanePicture& picture, const std::vector<Vector2i>& hole, int width_px) {
  std::vector<uint8_t> marked(picture.kind.size(), 0);
  std::vector<Vector2i> rim;
  for (const Vector2i& p : hole)
    for (int y = -width_px; y <= width_px; ++y)
      for (int x = -width_px; x <= width_px; ++x) {
        const Vector2i q = p + Vector2i(x, y);
        if (x * x + y * y > width_px * width_px || !picture.inside(q) || marked[picture.at(q)] ||
            picture.kind[picture.at(q)] != kPlane)
          continue;
        marked[picture.at(q)] = 1;
        rim.push_back(q);
      }
  return rim;
}

// Fills the colours of the hole; true if a disc of the plane gave its texture.
bool texture_hole(PlanePicture& picture, const std::vector<Vector2i>& hole) {
  const std::vector<Vector2i> rim = rim_of(picture, hole, kRing_px);
  if (rim.empty()) return false;
  Vector2i low = hole[0], high = hole[0];
  for (const Vector2i& p : hole) low = low.cwiseMin(p), high = high.cwiseMax(p);
  // Offsets for which the hole and its rim lie on the plane.
  std::vector<Vector2i> offsets;
  for (int dy = -picture.height; dy < picture.height; dy += kSearchStep_px)
    for (int dx = -picture.width; dx < picture.width; dx += kSearchStep_px)
      if (picture.inside(low + Vector2i(dx, dy)) && picture.inside(high + Vector2i(dx, dy)))
        offsets.emplace_back(dx, dy);
  std::vector<double> error(offsets.size(), std::numeric_limits<double>::infinity());
  const auto usable = [&](const Vector2i& p) {
    return picture.inside(p) && picture.kind[picture.at(p)] == kPlane;
  };
  parallel_for(offsets.size(), 16, [&](size_t begin, size_t end) {
    for (size_t o = begin; o < end; ++o) {
      if (!std::all_of(hole.begin(), hole.end(), [&](const Vector2i& p) { return usable(p + offsets[o]); }))
        continue;
      double sum = 0;
      size_t count = 0;
      for (const Vector2i& p : rim) {
        if (!usable(p + offsets[o])) continue;
        sum += (picture.rgb[picture.at(p)] - picture.rgb[picture.at(p + offsets[o])]).squaredNorm();
        ++count;
      }
      if (2 * count >= rim.size()) error[o] = sum / static_cast<double>(count);
    }
  });
  const size_t best =
      offsets.empty() ? 0 : static_cast<size_t>(std::min_element(error.begin(), error.end()) - error.begin());
  const bool textured = !offsets.empty() && std::isfinite(error[best]);
  const std::vector<Vector2i> edge = rim_of(picture, hole, 1);
  // The difference between the picture and the exemplar, known at the rim and harmonic in the hole.
  std::vector<Eigen::Vector3f> difference(picture.kind.size(), Eigen::Vector3f::Zero());
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  const auto exemplar = [&](const Vector2i& p) -> Eigen::Vector3f {
    if (!textured) return Eigen::Vector3f::Zero();
    const Vector2i q = p + offsets[best];
    return usable(q) ? picture.rgb[picture.at(q)] : picture.rgb[picture.at(p)];
  };
  for (const Vector2i& p : edge) {
    difference[picture.at(p)] = picture.rgb[picture.at(p)] - exemplar(p);
    mean += difference[picture.at(p)];
  }
  if (!edge.empty()) mean /= static_cast<float>(edge.size());
  for (const Vector2i& p : hole) difference[picture.at(p)] = mean;
  std::vector<uint8_t> known(picture.kind.size(), 0);
  for (const Vector2i& p : hole) known[picture.at(p)] = 1;
  for (const Vector2i& p : edge) known[picture.at(p)] = 1;
  const Vector2i steps[] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  for (int round = 0; round < kLaplaceRounds; ++round)
    for (const Vector2i& p : hole) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      int count = 0;
      for (const Vector2i& step : steps) {
        const Vector2i q = p + step;
        if (!picture.inside(q) || !known[picture.at(q)]) continue;
        sum += difference[picture.at(q)];
        ++count;
      }
      if (count > 0) difference[picture.at(p)] = sum / static_cast<float>(count);
    }
  std::vector<Eigen::Vector3f> filled;
  for (const Vector2i& p : hole) filled.push_back(exemplar(p) + difference[picture.at(p)]);
  for (size_t i = 0; i < hole.size(); ++i)
    picture.rgb[picture.at(hole[i])] = filled[i].cwiseMax(0.0f).cwiseMin(1.0f);
  return textured;
}

}  // namespace

BehindThing fill_behind(const SplitRoom& room, const RoomParts& parts, size_t part) {
  BehindThing out;
  out.fill.sh_degree = out.underside.sh_degree = room.asset.sh_degree;
  out.fill.antialiased = out.underside.antialiased = room.asset.antialiased;
  const RoomPart& thing = parts.parts[part];
  const auto cover = [&](const RoomPlane& plane, bool wall, size_t index) {
    const std::vector<Eigen::Vector3f> points =
        foot_points(room, plane, thing.label, kFoot_voxels * parts.voxel_m);
    if (points.size() < kMinFootKernels) return;
    const PlaneRegion foot(plane.normal, kFootCell_voxels * parts.voxel_m, points);
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3f& p : points) box.extend(p.cast<double>());
    Vector3d middle_m = box.center();
    middle_m -= plane.height_m(middle_m) * plane.normal;
    const double half_m = kAround_radii * (0.5 * box.diagonal().norm() + 2 * parts.voxel_m);
    PlanePicture picture = look_at_plane(room, parts, plane, foot, middle_m, half_m, out.hidden);
    std::vector<Vector2i> hole;
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x)
        if (picture.kind[picture.at({x, y})] == kHole) hole.emplace_back(x, y);
    FilledPlane filled{wall, index, hole.size(), false};
    if (hole.empty()) return;
    filled.textured = texture_hole(picture, hole);
    // The colours of the foot for the underside.
    std::vector<Eigen::Vector3f> places, colours;
    for (size_t k = 0; k < room.asset.size(); ++k)
      if (room.label[k] == thing.label &&
          plane.height_m(room.asset.positions[k].cast<double>()) < kFoot_voxels * parts.voxel_m) {
        places.push_back(room.asset.positions[k]);
        colours.push_back(Eigen::Vector3f::Constant(0.5f) + kShBand0 * room.asset.sh_dc[k]);
      }
    const KernelTree tree(places);
    const double pixel_m =
        picture.width > 1 ? (picture.point_m[1] - picture.point_m[0]).norm() : parts.footprint_m;
    std::vector<KernelTree::Neighbour> nearest;
    for (const Vector2i& p : hole) {
      if (p.x() % kKernelStep_px || p.y() % kKernelStep_px) continue;
      const Vector3d& at = picture.point_m[picture.at(p)];
      add_flat_kernel(out.fill, at, plane.region.u(), plane.normal, kKernelStep_px * pixel_m,
                      picture.rgb[picture.at(p)]);
      if (!inside_foot(foot, plane, at)) continue;
      tree.nearest(at.cast<float>(), 8, nearest);
      Eigen::Vector3f rgb = Eigen::Vector3f::Zero();
      for (const auto& n : nearest) rgb += colours[n.index];
      add_flat_kernel(out.underside, at + 0.25 * pixel_m * plane.normal, plane.region.u(), -plane.normal,
                      kKernelStep_px * pixel_m, rgb / static_cast<float>(nearest.size()));
    }
    out.planes.push_back(filled);
  };
  if (thing.support) cover(parts.planes.supports[*thing.support], false, *thing.support);
  if (thing.wall) cover(parts.planes.walls[*thing.wall], true, *thing.wall);
  out.unfilled = out.planes.empty();
  return out;
}

}  // namespace livegs
