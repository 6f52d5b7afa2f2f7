// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/reconstruct_surface.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/format_text.h"
#include "geometry/mesh/convex_hull.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/surface/alpha_complex.h"
#include "geometry/surface/remove_small_components.h"
#include "geometry/surface/shape_mesh.h"
#include "geometry/surface/voxel_thinning.h"

namespace livegs {
namespace {

// All below in parts of the bounding-box diagonal, or of the alpha radius where it says so.

// Voxels in which one point is kept before triangulating, in parts of the alpha radius. A third keeps volume
// within 2 % and every vertex within a third of the radius; finer costs time with the square.
constexpr double kThinning = 1.0 / 3.0;
// A ball wider than this many median gaps between points slips through no hole that chance sampling leaves in
// a surface: of n random points the largest empty disc has about sqrt(ln n / pi) mean spacings, the median
// nearest neighbour 0.47 of one; 4 covers n = 60 000.
constexpr double kGapsPerRadius = 4.0;
// Thickness given to sheets and threads that bound no volume, in parts of the alpha radius.
constexpr double kSheetThickness = 0.1;
// The radius grows by this factor from try to try, at most this often: 0.03 of the diagonal becomes 0.34.
constexpr double kRadiusGrowth = 1.5;
constexpr int kRadiusTries = 7;
// A body must hold this part of the points.
constexpr double kMinCoveredShare = 0.8;
// A larger radius that joins all pieces is taken if it swells the body no more than this.
constexpr double kMaxSwelling = 1.25;
// A rigid body stands on its lowest points, so a few strays under a captured base would make it rock and
// fall: a voxel of the coarse surface with less than this part of the usual number of kernels is left out.
constexpr double kMinVoxelShare = 0.15;
// A hull thinner than a ball of this radius, over a diagonal of 1, is taken for flat.
constexpr double kMinVolume = 1e-7;
// The least edge of a box put in place of a flat or straight cloud, in parts of its longest edge.
constexpr double kMinBoxEdge = 0.02;
// Edge of the box put in place of a single place in space, for want of any other length.
constexpr double kPointBox_m = 0.01;

void add_note(std::string& note, const std::string& more) { note += (note.empty() ? "" : "; ") + more; }

// A box along the principal axes of the cloud, none of its edges nothing.
TriangleMesh principal_box(std::span<const Eigen::Vector3d> points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& point : points) mean += point;
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const auto& point : points) spread += (point - mean) * (point - mean).transpose();
  Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors();
  if (axes.determinant() < 0.0) axes.col(0) = -axes.col(0);
  Eigen::AlignedBox3d bounds;
  for (const auto& point : points) bounds.extend(axes.transpose() * (point - mean));
  const double longest = bounds.sizes().maxCoeff();
  TriangleMesh mesh = box_mesh(bounds.sizes().cwiseMax(kMinBoxEdge * longest));
  for (auto& vertex : mesh.vertices_m) vertex = mean + axes * (vertex + bounds.center());
  return mesh;
}

struct Candidate {
  TriangleMesh mesh;
  double radius = 0.0, volume = 0.0;
  int pieces = 0;
  SmallComponents dropped;
};

// What the alpha complex at this radius amounts to, or nothing if it is empty or leaves too much of the cloud
// out.
std::optional<Candidate> try_radius(AlphaComplex& complex, double radius) {
  complex.thicken_sheets(radius, kSheetThickness * radius);
  AlphaComplex::Body body = complex.body(radius);
  if (body.covered < kMinCoveredShare) return std::nullopt;
  Candidate candidate;
  candidate.dropped = remove_small_components(body.mesh);
  candidate.mesh = std::move(body.mesh);
  candidate.radius = radius;
  candidate.volume = signed_volume_m3(candidate.mesh);
  if (candidate.volume < kMinVolume) return std::nullopt;
  candidate.pieces = mesh_topology(candidate.mesh).piece_count;
  return candidate;
}

// The first radius that holds the cloud, or a larger one that holds it in one piece at little cost.
std::optional<Candidate> alpha_body(AlphaComplex& complex, double first_radius) {
  std::optional<Candidate> best;
  double radius = first_radius;
  for (int attempt = 0; attempt < kRadiusTries; ++attempt, radius *= kRadiusGrowth) {
    std::optional<Candidate> next = try_radius(complex, radius);
    if (!next) continue;
    if (best && next->volume > kMaxSwelling * best->volume) break;
    if (!best || next->pieces == 1) best = std::move(next);
    if (best->pieces == 1) break;
  }
  return best;
}

}  // namespace

SurfaceOptions elastic_surface_options() { return {.alpha_radius = 0.03, .downsample = 0.0}; }
SurfaceOptions rigid_surface_options() { return {.alpha_radius = 0.1, .downsample = 0.02}; }

Result<Surface> reconstruct_surface(std::span<const Eigen::Vector3d> points_m,
                                    const SurfaceOptions& options) {
  if (points_m.empty()) return invalid_argument("surface: no points; is the object transparent or empty?");
  if (!(options.alpha_radius > 1e-4 && options.alpha_radius <= 10.0) ||
      !(options.downsample >= 0.0 && options.downsample <= 1.0)) {
    return invalid_argument("surface: alpha_radius must lie in 1e-4 … 10 and downsample in 0 … 1 diagonals");
  }
  Eigen::AlignedBox3d bounds;
  for (size_t p = 0; p < points_m.size(); ++p) {
    if (!points_m[p].allFinite())
      return invalid_data("surface: point " + std::to_string(p) + " is not finite");
    bounds.extend(points_m[p]);
  }
  const double diagonal_m = bounds.diagonal().norm();
  if (!(diagonal_m <= 1e12))
    return invalid_data("surface: points are more than 1e12 m apart; what is their unit?");

  Surface surface;
  if (!(diagonal_m > 1e-9 * (1.0 + bounds.center().norm()))) {
    surface.mesh = box_mesh(Eigen::Vector3d::Constant(kPointBox_m));
    for (auto& vertex : surface.mesh.vertices_m) vertex += bounds.center();
    surface.source = SurfaceSource::Box;
    surface.note =
        format_text("all %zu points lie in one place: a box of %g m", points_m.size(), kPointBox_m);
    return surface;
  }

  // Triangulated at unit size about the origin, so that nothing depends on the unit or the place.
  std::vector<Eigen::Vector3d> cloud;
  cloud.reserve(points_m.size());
  for (const auto& point_m : points_m) cloud.push_back((point_m - bounds.center()) / diagonal_m);
  const double voxel =
      options.downsample > 0.0 ? std::max(options.downsample, 1e-5) : kThinning * options.alpha_radius;
  cloud = thin_by_voxels(cloud, voxel, options.downsample > 0.0 ? kMinVoxelShare : 0.0);
  AlphaComplex complex(cloud);
  std::optional<Candidate> body;
  double radius = options.alpha_radius;
  if (complex.dimension() == 2) {
    complex.thicken_plane(kSheetThickness * radius);
    add_note(surface.note,
             format_text("flat: given a thickness of %.3g m", kSheetThickness * radius * diagonal_m));
  }
  if (complex.dimension() == 3) {
    const double gap = complex.median_gap();
    const double least_radius = kGapsPerRadius * gap;
    if (least_radius > radius && gap > voxel && surface.note.empty()) {  // a gap below that is thinning's own
      add_note(surface.note, format_text("points are %.3g m apart, too far for a radius of %.3g m",
                                         gap * diagonal_m, radius * diagonal_m));
      radius = least_radius;
    }
    body = alpha_body(complex, radius);
  }
  if (body) {
    surface.mesh = std::move(body->mesh);
    surface.alpha_radius_m = body->radius * diagonal_m;
    surface.source =
        body->radius > options.alpha_radius ? SurfaceSource::LargerAlphaShape : SurfaceSource::AlphaShape;
    if (surface.source == SurfaceSource::LargerAlphaShape) {
      add_note(surface.note, format_text("alpha radius %.3g m instead of %.3g m to hold the points together",
                                         surface.alpha_radius_m, options.alpha_radius * diagonal_m));
    }
    if (body->pieces > 1) add_note(surface.note, format_text("in %d pieces", body->pieces));
    if (body->dropped.count > 0) {
      add_note(surface.note, format_text("%d specks dropped, %.2g of the volume", body->dropped.count,
                                         body->dropped.volume_share));
    }
  } else {
    surface.note.clear();
    surface.mesh = convex_hull(cloud);
    if (signed_volume_m3(surface.mesh) >= kMinVolume) {
      surface.source = SurfaceSource::ConvexHull;
      surface.note =
          format_text("no alpha shape up to %.3g m holds the points: their convex hull", radius * diagonal_m);
    } else {
      surface.source = SurfaceSource::Box;
      surface.mesh = principal_box(cloud);
      surface.note =
          format_text("the %zu points lie on a line or a sliver: a box round them", points_m.size());
    }
  }
  for (auto& vertex : surface.mesh.vertices_m) vertex = bounds.center() + diagonal_m * vertex;
  return surface;
}

}  // namespace livegs
