// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/separate/fill_behind.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "core/parallel_for.h"
#include "parts/graph/kernel_tree.h"
#include "parts/label/choose_kernels.h"
#include "parts/views/room_view.h"

namespace livegs {
namespace {

using Eigen::Vector2i;
using Eigen::Vector3d;

constexpr double kThingFoot_voxels = 2.5;  // height of a thing that counts as its foot
constexpr double kFootCell_voxels = 1.2;   // cells of the area of a foot; below one it falls apart
// Width around the foot in which kernels of the room carry colours of the thing; less leaves a ring of them,
// more replaces visible surface.
constexpr double kMargin_voxels = 1.2;
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
// Lengths over which the light of a plane recovers from the shade of a thing, in radii of its foot.
constexpr double kShadeReach_radii[] = {0.1, 0.15, 0.2, 0.3, 0.4, 0.6};
constexpr double kMinShade = 0.05, kMaxShade = 0.7;  // loss of light at the foot that is taken for shade
constexpr double kMinRelit = 0.015;                  // loss of light below which a kernel keeps its colour
constexpr double kSameShade = 0.5;  // least ratio of the shades of two colour channels; a mat has other ones
constexpr size_t kMinShadePixels = 200;
// Distance from feet of other things within which the plane is in their shade or has their colour.
constexpr double kClear_voxels = 4.0;
// Around a hole, pixels of less coverage are filled too: the hidden kernels reached beyond it.
constexpr double kSeam_voxels = 4.0;
constexpr float kSeamCoverage = 0.97f;

enum PixelKind : uint8_t { kOutside, kPlane, kHole };

// The picture of a plane from the front.
struct PlanePicture {
  int width = 0, height = 0;
  std::vector<Eigen::Vector3f> rgb;
  std::vector<uint8_t> kind;
  std::vector<Vector3d> point_m;  // on the plane
  std::vector<float> foot_m;      // distance from the foot; 0 in it
  std::vector<float> other_m;     // distance from the feet of other things
  std::vector<uint8_t> thin;      // outside the hole: hardly covered once its kernels are hidden

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
  for (size_t k = 0; k < room.asset.size(); ++k) {
    if (room.label[k] != label) continue;
    const Vector3d p = room.asset.positions[k].cast<double>();
    if (plane.height_m(p) < reach_m && plane.region.contains(p)) foot.push_back(room.asset.positions[k]);
  }
  return foot;
}

// The area in which a thing covers a plane: the hull of its foot, as far as the thing is over it. The hull
// closes the side on which no view saw the thing; a bent thing does not fill its hull.
class Footprint {
 public:
  Footprint(const SplitRoom& room, const RoomPlane& plane, double cell_m,
            std::span<const Eigen::Vector3f> foot)
      : foot_(plane.normal, cell_m, foot), over_(plane.normal, cell_m, kernels_over(room, foot_)) {}

  bool contains(const Vector3d& point_m) const { return foot_.contains(point_m) && is_over(point_m); }
  // All its surroundings are below the thing: cells of the rim reach beyond it.
  bool inside(const Vector3d& point_m) const {
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y) {
        const Vector3d at = point_m + foot_.cell_m() * (x * foot_.u() + y * foot_.v());
        if (!foot_.contains(at) || !over_.seen(at)) return false;
      }
    return true;
  }

 private:
  static std::vector<Eigen::Vector3f> kernels_over(const SplitRoom& room, const PlaneRegion& foot) {
    std::vector<Eigen::Vector3f> points;
    for (size_t k = 0; k < room.asset.size(); ++k)
      if (room.label[k] != kRoomLabel && foot.contains(room.asset.positions[k].cast<double>()))
        points.push_back(room.asset.positions[k]);
    return points;
  }
  bool is_over(const Vector3d& point_m) const {
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        if (over_.seen(point_m + foot_.cell_m() * (x * foot_.u() + y * foot_.v()))) return true;
    return false;
  }
  PlaneRegion foot_, over_;
};

// Squared distance of each cell of a line from the nearest parabola's foot (Felzenszwalb and Huttenlocher
// 2012, Distance transforms of sampled functions).
void distances_along(std::vector<double>& line, std::vector<double>& result, std::vector<int>& from,
                     std::vector<double>& until) {
  const int count = static_cast<int>(line.size());
  int last = 0;
  from[0] = 0;
  until[0] = -std::numeric_limits<double>::infinity();
  until[1] = std::numeric_limits<double>::infinity();
  const auto meet = [&](int q, int p) {
    return (line[q] + q * q - line[p] - static_cast<double>(p) * p) / (2.0 * (q - p));
  };
  for (int q = 1; q < count; ++q) {
    double at = meet(q, from[last]);
    while (at <= until[last]) at = meet(q, from[--last]);
    from[++last] = q;
    until[last] = at;
    until[last + 1] = std::numeric_limits<double>::infinity();
  }
  for (int q = 0, p = 0; q < count; ++q) {
    while (until[p + 1] < q) ++p;
    result[q] = static_cast<double>(q - from[p]) * (q - from[p]) + line[from[p]];
  }
}

// Distance of each pixel from the marked ones, px; far beyond the picture if there are none.
std::vector<float> distance_from(const std::vector<uint8_t>& marks, int edge) {
  constexpr double kNoMark_px2 = 1e12;
  const size_t side = static_cast<size_t>(edge);
  std::vector<double> squared(marks.size()), line(side), result(side), until(side + 1);
  std::vector<int> from(side);
  for (size_t i = 0; i < marks.size(); ++i) squared[i] = marks[i] ? 0.0 : kNoMark_px2;
  for (const bool columns : {true, false})
    for (size_t a = 0; a < side; ++a) {
      const auto at = [&](size_t b) { return columns ? b * side + a : a * side + b; };
      for (size_t b = 0; b < side; ++b) line[b] = squared[at(b)];
      distances_along(line, result, from, until);
      for (size_t b = 0; b < side; ++b) squared[at(b)] = result[b];
    }
  std::vector<float> distance(marks.size());
  for (size_t i = 0; i < marks.size(); ++i) distance[i] = static_cast<float>(std::sqrt(squared[i]));
  return distance;
}

// The light that reaches the plane at a distance from a thing: 1 - shade exp(-distance / reach).
struct Shade {
  double shade = 0, reach_m = 1;
  double light(double distance_m) const { return 1 - shade * std::exp(-distance_m / reach_m); }
};

// Fits level * light to the colours of the plane around a thing by least squares.
Shade shade_of(const PlanePicture& picture, double margin_m, double clear_m, double radius_m) {
  Shade best;
  double least = std::numeric_limits<double>::infinity();
  for (const double reach_radii : kShadeReach_radii) {
    const double reach_m = reach_radii * radius_m;
    double n = 0, e = 0, ee = 0;
    Vector3d c = Vector3d::Zero(), ce = c, cc = c;
    for (size_t i = 0; i < picture.kind.size(); ++i) {
      if (picture.kind[i] != kPlane || picture.foot_m[i] < margin_m ||
          picture.other_m[i] < std::max<double>(picture.foot_m[i], clear_m) ||
          picture.foot_m[i] > kAround_radii * radius_m)
        continue;
      const double w = std::exp(-picture.foot_m[i] / reach_m);
      const Vector3d rgb = picture.rgb[i].cast<double>();
      n += 1, e += w, ee += w * w;
      c += rgb, ce += w * rgb, cc += rgb.cwiseProduct(rgb);
    }
    const double spread = n * ee - e * e;
    if (n < kMinShadePixels || spread <= 1e-9 * n * n) continue;
    const Vector3d slope = (n * ce - e * c) / spread, level = (c - e * slope) / n;
    const double error = (cc - level.cwiseProduct(c) - slope.cwiseProduct(ce)).sum();
    const Vector3d shades = -slope.cwiseQuotient(level.cwiseMax(1e-3));
    if (error >= least) continue;
    least = error;
    const double shade = -slope.sum() / std::max(level.sum(), 1e-3);
    const bool grey = shades.minCoeff() > kSameShade * shades.maxCoeff();
    best = {grey && shade > kMinShade ? std::min(shade, kMaxShade) : 0.0, reach_m};
  }
  return best;
}

PlanePicture look_at_plane(const SplitRoom& room, const RoomParts& parts, const RoomPlane& plane,
                           const Footprint& foot, uint16_t thing, const Vector3d& middle_m, double half_m,
                           BehindThing& out) {
  const double pixel_m = parts.footprint_m;
  const int edge =
      2 * static_cast<int>(std::ceil(std::clamp(half_m / pixel_m, kMinAround_px, kMaxAround_px)));
  const double height_m = kCameraHeight * half_m;
  Camera camera = look_at(middle_m + height_m * plane.normal, middle_m, plane.region.u(), 0.5, edge, edge);
  camera.focal_x_px = camera.focal_y_px = 0.5 * edge * height_m / half_m;
  camera.near_m = 0.05 * height_m;
  const ViewRays rays(camera);
  // Only kernels near the plane: a shelf or a lamp above it must not hide it.
  GaussianAsset near;
  near.sh_degree = room.asset.sh_degree;
  near.antialiased = room.asset.antialiased;
  std::vector<uint32_t> source;
  const size_t pixels = static_cast<size_t>(edge) * static_cast<size_t>(edge);
  std::vector<uint8_t> own(pixels, 0), others(pixels, 0);
  const double reach_m = kOffPlane_voxels * parts.voxel_m + 3 * plane.deviation_m;
  const auto pixel_of = [&](const Vector3d& p) -> std::optional<size_t> {
    ViewRays::Hit hit;
    if (!rays.project(p - plane.height_m(p) * plane.normal, hit)) return {};
    return static_cast<size_t>(hit.y) * static_cast<size_t>(edge) + static_cast<size_t>(hit.x);
  };
  for (size_t k = 0; k < room.asset.size(); ++k) {
    const Vector3d p = room.asset.positions[k].cast<double>();
    if ((p - middle_m).norm() > 3 * half_m || plane.height_m(p) > 4 * reach_m) continue;
    if (room.label[k] == kRoomLabel) {
      append_kernel(near, room.asset, k);
      source.push_back(static_cast<uint32_t>(k));
    } else if (room.label[k] != thing && plane.height_m(p) < kThingFoot_voxels * parts.voxel_m) {
      if (const auto pixel = pixel_of(p)) others[*pixel] = 1;
    }
  }
  const PosedKernels posed = pose_in_place(near);
  KernelRasteriser rasteriser;
  KernelView view;
  rasteriser.draw({&near, &posed, 0}, camera, view);
  PlanePicture picture;
  picture.width = picture.height = edge;
  picture.rgb.resize(pixels);
  picture.kind.resize(pixels);
  picture.point_m.resize(pixels);
  for (int y = 0; y < edge; ++y)
    for (int x = 0; x < edge; ++x) {
      const size_t i = picture.at({x, y});
      const Vector3d far = rays.point_m(x, y, height_m);
      picture.point_m[i] = far - plane.height_m(far) * plane.normal;
      own[i] = foot.contains(picture.point_m[i]);
    }
  const float pixel_edge_m = static_cast<float>(2 * half_m / edge);
  picture.foot_m = distance_from(own, edge);
  picture.other_m = distance_from(others, edge);
  for (float& distance : picture.foot_m) distance *= pixel_edge_m;
  for (float& distance : picture.other_m) distance *= pixel_edge_m;
  // Below the foot no view can look, and at its rim the kernels of the room carry colours of the thing.
  const double margin_m = kMargin_voxels * parts.voxel_m;
  // Where two planes meet, a pixel of one shows the other.
  const auto on_other = [&](const Vector3d& p) {
    const auto meets = [&](const RoomPlane& other) {
      return &other != &plane && std::abs(other.height_m(p)) < reach_m && other.region.contains(p);
    };
    return std::any_of(parts.planes.supports.begin(), parts.planes.supports.end(), meets) ||
           std::any_of(parts.planes.walls.begin(), parts.planes.walls.end(), meets);
  };
  for (int y = 0; y < edge; ++y)
    for (int x = 0; x < edge; ++x) {
      const size_t i = picture.at({x, y});
      const float* rgba = view.image.at(x, y);
      picture.rgb[i] = Eigen::Vector3f(rgba[0], rgba[1], rgba[2]) / std::max(rgba[3], 0.5f);
      const uint32_t kernel = view.kernel[i];
      const bool on_plane =
          kernel != kNoKernel && std::abs(plane.height_m(rays.point_m(x, y, view.depth_m[i]))) < reach_m;
      if (own[i] || (on_plane && picture.foot_m[i] <= margin_m))
        picture.kind[i] = kHole;
      else if (on_plane && parts.share[room.source[source[kernel]]] > 0 && picture.other_m[i] > margin_m &&
               !on_other(picture.point_m[i]))
        picture.kind[i] = kPlane;
      else
        picture.kind[i] = kOutside;
    }
  const Shade shade = shade_of(picture, margin_m, kClear_voxels * parts.voxel_m, half_m / kAround_radii);
  for (size_t i = 0; i < pixels; ++i) picture.rgb[i] /= static_cast<float>(shade.light(picture.foot_m[i]));
  std::vector<uint32_t> stay;
  for (uint32_t n = 0; n < near.size(); ++n) {
    const Vector3d p = near.positions[n].cast<double>();
    const auto pixel = pixel_of(p);
    if (pixel && picture.kind[*pixel] == kHole && std::abs(plane.height_m(p)) < 2 * reach_m) {
      out.hidden.push_back(source[n]);
      continue;
    }
    stay.push_back(n);
    if (!pixel || std::abs(plane.height_m(p)) > reach_m) continue;
    const double light = shade.light(picture.foot_m[*pixel]);
    if (light < 1 - kMinRelit) out.relit.push_back({source[n], static_cast<float>(light)});
  }
  const GaussianAsset rest = select_kernels(near, stay);
  const PosedKernels rest_posed = pose_in_place(rest);
  KernelView rest_view;
  rasteriser.draw({&rest, &rest_posed, 0}, camera, rest_view);
  picture.thin.assign(pixels, 0);
  const double seam_m = margin_m + kSeam_voxels * parts.voxel_m;
  for (size_t i = 0; i < pixels; ++i)
    picture.thin[i] = picture.kind[i] == kPlane && picture.foot_m[i] < seam_m &&
                      rest_view.image.pixels[4 * i + 3] < kSeamCoverage;
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

// Fills the colours of the hole: with the texture of a disc of the plane, or smoothly if none is free.
void texture_hole(PlanePicture& picture, const std::vector<Vector2i>& hole, double clear_m) {
  const std::vector<Vector2i> rim = rim_of(picture, hole, kRing_px);
  if (rim.empty()) return;
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
    return picture.inside(p) && picture.kind[picture.at(p)] == kPlane &&
           picture.other_m[picture.at(p)] > clear_m;
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
}

}  // namespace

BehindThing fill_behind(const SplitRoom& room, const RoomParts& parts, size_t part) {
  BehindThing out;
  out.fill.sh_degree = out.underside.sh_degree = room.asset.sh_degree;
  out.fill.antialiased = out.underside.antialiased = room.asset.antialiased;
  const RoomPart& thing = parts.parts[part];
  const auto cover = [&](const RoomPlane& plane) {
    const std::vector<Eigen::Vector3f> points =
        foot_points(room, plane, thing.label, kThingFoot_voxels * parts.voxel_m);
    if (points.size() < kMinFootKernels) return;
    const Footprint foot(room, plane, kFootCell_voxels * parts.voxel_m, points);
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3f& p : points) box.extend(p.cast<double>());
    Vector3d middle_m = box.center();
    middle_m -= plane.height_m(middle_m) * plane.normal;
    const double half_m = kAround_radii * (0.5 * box.diagonal().norm() + 2 * parts.voxel_m);
    PlanePicture picture = look_at_plane(room, parts, plane, foot, thing.label, middle_m, half_m, out);
    std::vector<Vector2i> hole;
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x)
        if (picture.kind[picture.at({x, y})] == kHole) hole.emplace_back(x, y);
    if (hole.empty()) return;
    texture_hole(picture, hole, kClear_voxels * parts.voxel_m);
    // The colours of the foot for the underside.
    std::vector<Eigen::Vector3f> places, colours;
    for (size_t k = 0; k < room.asset.size(); ++k)
      if (room.label[k] == thing.label &&
          plane.height_m(room.asset.positions[k].cast<double>()) < kThingFoot_voxels * parts.voxel_m) {
        places.push_back(room.asset.positions[k]);
        colours.push_back(Eigen::Vector3f::Constant(0.5f) + kShBand0 * room.asset.sh_dc[k]);
      }
    const KernelTree tree(places);
    const double pixel_m =
        picture.width > 1 ? (picture.point_m[1] - picture.point_m[0]).norm() : parts.footprint_m;
    std::vector<KernelTree::Neighbour> nearest;
    std::vector<Vector2i> filled_px = hole;
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x)
        if (picture.thin[picture.at({x, y})]) filled_px.emplace_back(x, y);
    for (const Vector2i& p : filled_px) {
      if (p.x() % kKernelStep_px || p.y() % kKernelStep_px) continue;
      const Vector3d& at = picture.point_m[picture.at(p)];
      add_flat_kernel(out.fill, at, plane.region.u(), plane.normal, kKernelStep_px * pixel_m,
                      picture.rgb[picture.at(p)]);
      if (!foot.inside(at)) continue;
      tree.nearest(at.cast<float>(), 8, nearest);
      Eigen::Vector3f rgb = Eigen::Vector3f::Zero();
      for (const auto& n : nearest) rgb += colours[n.index];
      add_flat_kernel(out.underside, at + 0.25 * pixel_m * plane.normal, plane.region.u(), -plane.normal,
                      kKernelStep_px * pixel_m, rgb / static_cast<float>(nearest.size()));
    }
  };
  if (thing.support) cover(parts.planes.supports[*thing.support]);
  for (const RoomPlane& wall : parts.planes.walls) cover(wall);
  return out;
}

}  // namespace livegs
