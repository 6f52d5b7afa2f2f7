// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/reconstruct_surface.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/text/format_text.h"
#include "geometry/mesh/convex_hull.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/surface/alpha_complex.h"
#include "geometry/surface/remove_small_components.h"
#include "geometry/surface/shape_mesh.h"
#include "geometry/surface/voxel_thinning.h"

namespace livegs {
namespace {

// Values are relative to the bounding-box diagonal, or to the alpha radius where noted.

// Voxel size for thinning before the triangulation, relative to the alpha radius. A third keeps the volume
// within 2 % and each vertex within a third of the radius; smaller voxels cost quadratically more time.
constexpr double kThinning = 1.0 / 3.0;
// Minimum ball radius in median gaps between points, so that the ball does not pass through random holes. For
// n random points the largest empty disc is about sqrt(ln n / pi) mean spacings, and the median nearest
// neighbour is 0.47 of one. A value of 4 covers n = 60 000.
constexpr double kGapsPerRadius = 4.0;
// Thickness of sheets and threads without volume, relative to the alpha radius.
constexpr double kSheetThickness = 0.1;
// Growth of the radius per retry, and maximum number of tries: 0.03 of the diagonal becomes 0.34.
constexpr double kRadiusGrowth = 1.5;
constexpr int kRadiusTries = 7;
// Minimum fraction of the points that a body must contain.
constexpr double kMinCoveredShare = 0.8;
// Maximum growth of the volume for a larger radius that joins all pieces.
constexpr double kMaxSwelling = 1.25;
// A skin with holes wider than the ball: the ball gets inside, and the body is a shell, at most kMaxSkin
// radii thick. It is closed by a larger radius, if that is what happens there: the volume grows at once by
// kLeakGrowth, nearly all points are near the surface (those of a plant, filled by a large ball, are not),
// the body is thicker than the ball, and the next radius changes the volume by at most kClosedChange. Near is
// kSkinDepth of 3 V / A, which is the radius of a ball: the points of round kernels fill a layer.
constexpr int kLeakTries = 4;
constexpr double kMaxSkin = 2.0;
constexpr double kLeakGrowth = 2.0;
constexpr double kNearSurface = 0.95;
constexpr double kSkinDepth = 0.25;
constexpr double kClosedChange = 1.15;
// Minimum number of kernels in a voxel of the coarse surface, relative to the median. A rigid body stands on
// its lowest points, so stray kernels under a captured base would make it rock and fall.
constexpr double kMinVoxelShare = 0.15;
// Maximum volume of a hull that is treated as flat, for a diagonal of 1.
constexpr double kMinVolume = 1e-7;
// Minimum edge of a box that replaces a flat or straight cloud, relative to its longest edge.
constexpr double kMinBoxEdge = 0.02;
// Edge of the box that replaces a single point, metres.
constexpr double kPointBox_m = 0.01;

void add_note(std::string& note, const std::string& more) { note += (note.empty() ? "" : "; ") + more; }

// Returns a box along the principal axes of the cloud, with no edge of zero length.
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
  double area = 0.0;
  int pieces = 0;
  SmallComponents dropped;
  double leak_radius = 0.0;      // of the ball that got inside; 0: no leak
  double unclosed_growth = 0.0;  // of the volume at larger radii that may, but need not, close a leak
};

double area_of(const TriangleMesh& mesh) {
  double twice = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d& p = mesh.vertices_m[a];
    twice += (mesh.vertices_m[b] - p).cross(mesh.vertices_m[c] - p).norm();
  }
  return 0.5 * twice;
}

// Returns the alpha shape at this radius, or nothing if it is empty or omits too much of the cloud.
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
  candidate.area = area_of(candidate.mesh);
  candidate.pieces = mesh_topology(candidate.mesh).piece_count;
  return candidate;
}

// Returns the first radius that contains the cloud, or a larger one that joins its pieces at little cost.
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

// Replaces a thin shell by the body behind it, if a larger ball stays outside.
void close_leak(AlphaComplex& complex, Candidate& shell) {
  if (2.0 * shell.volume >= kMaxSkin * shell.radius * shell.area) return;
  double radius = shell.radius, growth = 0.0;
  std::optional<Candidate> closed;
  for (int attempt = 0; attempt < kLeakTries; ++attempt) {
    radius *= kRadiusGrowth;
    std::optional<Candidate> next = try_radius(complex, radius);
    if (!next) continue;
    if (closed) {
      if (next->volume > kClosedChange * closed->volume) break;
      closed->leak_radius = shell.radius;
      shell = std::move(*closed);
      return;
    }
    if (next->volume < kLeakGrowth * shell.volume || 2.0 * next->volume < radius * next->area ||
        complex.near_surface(std::max(shell.radius, kSkinDepth * 3.0 * next->volume / next->area)) <
            kNearSurface)
      continue;
    growth = next->volume / shell.volume;
    closed = std::move(next);
  }
  shell.unclosed_growth = growth;
}

}  // namespace

SurfaceOptions elastic_surface_options() { return {.alpha_radius = 0.03, .downsample = 0.0}; }
SurfaceOptions rigid_surface_options() { return {.alpha_radius = 0.1, .downsample = 0.02}; }

Result<Surface> reconstruct_surface(std::span<const Eigen::Vector3d> points_m,
                                    const SurfaceOptions& options) {
  if (points_m.empty())
    return invalid_argument("surface: no points; check that the object is opaque and not empty");
  if (!(options.alpha_radius > 1e-4 && options.alpha_radius <= 10.0) ||
      !(options.downsample >= 0.0 && options.downsample <= 1.0)) {
    return invalid_argument(
        "surface: alpha_radius or downsample is out of range; give 1e-4 to 10 and 0 to 1 diagonals");
  }
  Eigen::AlignedBox3d bounds;
  for (size_t p = 0; p < points_m.size(); ++p) {
    if (!points_m[p].allFinite())
      return invalid_data("surface: point " + std::to_string(p) + " is not finite");
    bounds.extend(points_m[p]);
  }
  const double diagonal_m = bounds.diagonal().norm();
  if (!(diagonal_m <= 1e12))
    return invalid_data("surface: points are more than 1e12 m apart; check their unit");

  Surface surface;
  if (!(diagonal_m > 1e-9 * (1.0 + bounds.center().norm()))) {
    surface.mesh = box_mesh(Eigen::Vector3d::Constant(kPointBox_m));
    for (auto& vertex : surface.mesh.vertices_m) vertex += bounds.center();
    surface.source = SurfaceSource::Box;
    surface.note =
        format_text("all %zu points coincide: replaced by a box of %g m", points_m.size(), kPointBox_m);
    return surface;
  }

  // Triangulated at unit size about the origin, so that the result does not depend on unit and position.
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
    add_note(surface.note, format_text("flat: thickened to %.3g m", kSheetThickness * radius * diagonal_m));
  }
  if (complex.dimension() == 3) {
    const double gap = complex.median_gap();
    const double least_radius = kGapsPerRadius * gap;
    if (least_radius > radius && gap > voxel && surface.note.empty()) {  // smaller gaps come from thinning
      add_note(surface.note, format_text("points are %.3g m apart, too sparse for a radius of %.3g m",
                                         gap * diagonal_m, radius * diagonal_m));
      radius = least_radius;
    }
    body = alpha_body(complex, radius);
    if (body && options.close_leaks) close_leak(complex, *body);
  }
  if (body) {
    surface.mesh = std::move(body->mesh);
    surface.alpha_radius_m = body->radius * diagonal_m;
    surface.source =
        body->radius > options.alpha_radius ? SurfaceSource::LargerAlphaShape : SurfaceSource::AlphaShape;
    if (body->leak_radius > 0.0) {
      add_note(
          surface.note,
          format_text("the skin has holes wider than %.3g m, through which its inside leaks: closed with an "
                      "alpha radius of %.3g m",
                      2.0 * body->leak_radius * diagonal_m, surface.alpha_radius_m));
    } else if (surface.source == SurfaceSource::LargerAlphaShape) {
      add_note(surface.note, format_text("alpha radius raised to %.3g m from %.3g m to connect the points",
                                         surface.alpha_radius_m, options.alpha_radius * diagonal_m));
    }
    if (body->unclosed_growth > 0.0) {
      add_note(surface.note,
               format_text(
                   "a thin shell: if it is a closed skin, it leaks through holes wider than %.3g m, and its "
                   "volume is %.2g times as large; give it more kernels",
                   2.0 * surface.alpha_radius_m, body->unclosed_growth));
    }
    if (body->pieces > 1) add_note(surface.note, format_text("in %d pieces", body->pieces));
    if (body->dropped.count > 0) {
      add_note(surface.note, format_text("%d small parts removed, %.2g of the volume", body->dropped.count,
                                         body->dropped.volume_share));
    }
  } else {
    surface.note.clear();
    surface.mesh = convex_hull(cloud);
    if (signed_volume_m3(surface.mesh) >= kMinVolume) {
      surface.source = SurfaceSource::ConvexHull;
      surface.note =
          format_text("no alpha shape up to %.3g m contains the points: replaced by their convex hull",
                      radius * diagonal_m);
    } else {
      surface.source = SurfaceSource::Box;
      surface.mesh = principal_box(cloud);
      surface.note =
          format_text("the %zu points lie on a line or in a sliver: replaced by a box", points_m.size());
    }
  }
  for (auto& vertex : surface.mesh.vertices_m) vertex = bounds.center() + diagonal_m * vertex;
  return surface;
}

}  // namespace livegs
