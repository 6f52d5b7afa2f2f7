// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/planes/support_planes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace livegs {
namespace {

using Eigen::Vector3d;

// Least share of all points on a plane. Lower values take the top of a large box for a table, higher values
// miss a small table.
constexpr double kMinSupportShare = 0.07, kMinWallShare = 0.03;
constexpr size_t kMaxSupports = 6, kMaxWalls = 8;
constexpr int kTries = 3000;      // RANSAC hypotheses; a plane with a share of 7 % among its candidates is
                                  // missed with a probability of e^-1 at three points each
constexpr size_t kScored = 4000;  // points that score a hypothesis
constexpr double kTolerance_footprints = 2.0;  // of a point on a plane, while searching
constexpr double kMinDeviation_footprints = 0.2;
constexpr double kInlierDeviations = 3.0;
constexpr double kMaxTilt = 0.94;       // cosine of 20 degrees, of a plane against level or upright
constexpr double kMaxPointTilt = 0.87;  // cosine of 30 degrees, of the normal of a point against its plane
constexpr double kMaxBehind = 0.01;     // share of points behind a wall
constexpr double kRegionCell_footprints = 6.0;
constexpr int kAreaGap_cells = 2;         // between cells of one area of a plane
constexpr double kCornerGap_cells = 2.0;  // between a support and a wall that meet
constexpr double kMinCorner = 0.5;        // determinant of the normals of three planes that form a corner
constexpr double kMinAreaShare = 0.05;    // of an area, relative to the largest one of its plane

Vector3d any_perpendicular(const Vector3d& n) {
  const Vector3d axis = std::abs(n.x()) < 0.7 ? Vector3d::UnitX() : Vector3d::UnitZ();
  return (axis - n * n.dot(axis)).normalized();
}

double median_of(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Candidate {
  Vector3d normal;
  double offset_m;
  size_t score = 0;
};

bool on_plane(const ViewPoint& point, const Vector3d& normal, double offset_m, double tolerance_m) {
  return std::abs(normal.dot(point.position_m.cast<double>()) - offset_m) < tolerance_m &&
         point.normal.cast<double>().dot(normal) > kMaxPointTilt;
}

// Least squares on the points within three robust deviations, repeated.
RoomPlane refit(std::span<const ViewPoint> points, std::span<const uint32_t> open, const Candidate& start,
                double footprint_m) {
  RoomPlane plane;
  plane.normal = start.normal;
  plane.offset_m = start.offset_m;
  double tolerance_m = kTolerance_footprints * footprint_m;
  for (int round = 0; round < 6; ++round) {
    Vector3d mean = Vector3d::Zero();
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
    std::vector<double> distances;
    for (uint32_t i : open) {
      if (!on_plane(points[i], plane.normal, plane.offset_m, tolerance_m)) continue;
      const Vector3d p = points[i].position_m.cast<double>();
      mean += p;
      moment += p * p.transpose();
      distances.push_back(std::abs(plane.height_m(p)));
    }
    if (distances.size() < 3) return plane;
    mean /= static_cast<double>(distances.size());
    moment = moment / static_cast<double>(distances.size()) - mean * mean.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(moment);
    Vector3d normal = axes.eigenvectors().col(0);
    if (normal.dot(plane.normal) < 0) normal = -normal;
    plane.normal = normal.normalized();
    plane.offset_m = plane.normal.dot(mean);
    plane.deviation_m = std::max(1.4826 * median_of(distances), kMinDeviation_footprints * footprint_m);
    tolerance_m = std::min(kInlierDeviations * plane.deviation_m, kTolerance_footprints * footprint_m);
  }
  return plane;
}

// The best plane among the open points whose own normals pass `upright`.
template <class Fits>
Candidate best_plane(std::span<const ViewPoint> points, std::span<const uint32_t> open, double footprint_m,
                     std::mt19937_64& random, Fits&& fits) {
  Candidate best;
  if (open.size() < 3) return best;
  std::vector<uint32_t> scored;
  const size_t step = std::max<size_t>(1, open.size() / kScored);
  for (size_t i = 0; i < open.size(); i += step) scored.push_back(open[i]);
  const auto draw = [&] { return points[open[random() % open.size()]].position_m.cast<double>().eval(); };
  for (int attempt = 0; attempt < kTries; ++attempt) {
    const Vector3d a = draw(), b = draw(), c = draw();
    Vector3d normal = (b - a).cross(c - a);
    if (!(normal.norm() > 1e-12)) continue;
    normal.normalize();
    if (!fits(normal)) {
      normal = -normal;
      if (!fits(normal)) continue;
    }
    Candidate plane{normal, normal.dot(a)};
    for (uint32_t i : scored)
      plane.score += on_plane(points[i], normal, plane.offset_m, kTolerance_footprints * footprint_m);
    if (plane.score > best.score) best = plane;
  }
  best.score *= step;
  return best;
}

}  // namespace

PlaneRegion::PlaneRegion(const Vector3d& normal, double cell_m, std::span<const Eigen::Vector3f> points_m,
                         std::span<const Eigen::Vector3f> corners_m)
    : u_(any_perpendicular(normal)), v_(normal.cross(u_)), cell_m_(cell_m) {
  if (points_m.empty()) return;
  Eigen::AlignedBox2d box;
  for (const auto& some : {points_m, corners_m})
    for (const Eigen::Vector3f& p : some)
      box.extend(Eigen::Vector2d(u_.dot(p.cast<double>()), v_.dot(p.cast<double>())));
  constexpr double kMaxCells = 2048;
  cell_m_ = std::max(cell_m_, box.sizes().maxCoeff() / kMaxCells);
  low_ = box.min() - Eigen::Vector2d::Constant(2 * cell_m_);
  columns_ = static_cast<int>(box.sizes().x() / cell_m_) + 5;
  rows_ = static_cast<int>(box.sizes().y() / cell_m_) + 5;
  cells_.assign(static_cast<size_t>(columns_) * rows_, 0);
  for (const Eigen::Vector3f& p : points_m) {
    if (const int cell = cell_of(p.cast<double>()); cell >= 0) cells_[cell] = 2;
  }
  drop_specks();
  fill_hulls(corners_m);
}

std::vector<std::vector<int>> PlaneRegion::areas() const {
  std::vector<std::vector<int>> found;
  std::vector<uint8_t> visited(cells_.size(), 0);
  for (size_t start = 0; start < cells_.size(); ++start) {
    if (cells_[start] != 2 || visited[start]) continue;
    found.emplace_back(1, static_cast<int>(start));
    visited[start] = 1;
    for (size_t i = 0; i < found.back().size(); ++i) {
      const int x = found.back()[i] % columns_, y = found.back()[i] / columns_;
      for (int dy = -kAreaGap_cells; dy <= kAreaGap_cells; ++dy)
        for (int dx = -kAreaGap_cells; dx <= kAreaGap_cells; ++dx) {
          if (x + dx < 0 || y + dy < 0 || x + dx >= columns_ || y + dy >= rows_) continue;
          const int next = (y + dy) * columns_ + x + dx;
          if (cells_[next] != 2 || visited[next]) continue;
          visited[next] = 1;
          found.back().push_back(next);
        }
    }
  }
  return found;
}

void PlaneRegion::drop_specks() {
  const auto found = areas();
  size_t most = 0;
  for (const auto& area : found) most = std::max(most, area.size());
  for (const auto& area : found)
    if (static_cast<double>(area.size()) < kMinAreaShare * static_cast<double>(most))
      for (int cell : area) cells_[cell] = 0;
}

void PlaneRegion::fill_hulls(std::span<const Eigen::Vector3f> corners_m) {
  const auto all = areas();
  const auto largest = std::max_element(all.begin(), all.end(),
                                        [](const auto& a, const auto& b) { return a.size() < b.size(); });
  for (const auto& area : all) {
    // The convex hull by Andrew's monotone chain.
    std::vector<Eigen::Vector2i> corners;
    for (int cell : area) corners.emplace_back(cell % columns_, cell / columns_);
    if (&area == &*largest)
      for (const Eigen::Vector3f& p : corners_m)
        if (const int cell = cell_of(p.cast<double>()); cell >= 0)
          corners.emplace_back(cell % columns_, cell / columns_);
    std::sort(corners.begin(), corners.end(), [](const auto& a, const auto& b) {
      return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
    });
    const auto turn = [](const Eigen::Vector2i& a, const Eigen::Vector2i& b, const Eigen::Vector2i& c) {
      return static_cast<int64_t>(b.x() - a.x()) * (c.y() - a.y()) -
             static_cast<int64_t>(b.y() - a.y()) * (c.x() - a.x());
    };
    std::vector<Eigen::Vector2i> hull;
    for (int side = 0; side < 2; ++side) {
      const size_t start = hull.size();
      for (const auto& corner : corners) {
        while (hull.size() >= start + 2 && turn(hull[hull.size() - 2], hull.back(), corner) <= 0)
          hull.pop_back();
        hull.push_back(corner);
      }
      hull.pop_back();
      std::reverse(corners.begin(), corners.end());
    }
    if (hull.size() < 3) continue;
    for (int y = 0; y < rows_; ++y)
      for (int x = 0; x < columns_; ++x) {
        uint8_t& cell = cells_[static_cast<size_t>(y) * columns_ + x];
        if (cell != 0) continue;
        bool inside = true;
        for (size_t i = 0; inside && i < hull.size(); ++i)
          inside = turn(hull[i], hull[(i + 1) % hull.size()], {x, y}) >= 0;
        if (inside) cell = 1;
      }
  }
}

Eigen::AlignedBox2d PlaneRegion::bounds_m() const {
  Eigen::AlignedBox2d box;
  for (int y = 0; y < rows_; ++y)
    for (int x = 0; x < columns_; ++x) {
      if (cells_[static_cast<size_t>(y) * columns_ + x] == 0) continue;
      box.extend(low_ + cell_m_ * Eigen::Vector2d(x, y));
      box.extend(low_ + cell_m_ * Eigen::Vector2d(x + 1, y + 1));
    }
  return box;
}

int PlaneRegion::cell_of(const Vector3d& point_m) const {
  const double x = (u_.dot(point_m) - low_.x()) / cell_m_, y = (v_.dot(point_m) - low_.y()) / cell_m_;
  if (!(x >= 0 && y >= 0 && x < columns_ && y < rows_)) return -1;
  return static_cast<int>(y) * columns_ + static_cast<int>(x);
}

bool PlaneRegion::contains(const Vector3d& point_m) const {
  const int cell = cell_of(point_m);
  return cell >= 0 && cells_[cell] != 0;
}

bool PlaneRegion::seen(const Vector3d& point_m) const {
  const int cell = cell_of(point_m);
  return cell >= 0 && cells_[cell] == 2;
}

double PlaneRegion::area_m2() const {
  return cell_m_ * cell_m_ *
         static_cast<double>(std::count_if(cells_.begin(), cells_.end(), [](uint8_t c) { return c != 0; }));
}

namespace {

// A thing in a corner of the room hides it. Where a support is seen up to two walls, the regions of the three
// planes reach to the point in which they meet.
void reach_corners(RoomPlanes& planes, double footprint_m,
                   std::span<const std::vector<Eigen::Vector3f>> of_supports,
                   std::span<const std::vector<Eigen::Vector3f>> of_walls) {
  const double cell_m = kRegionCell_footprints * footprint_m;
  std::vector<std::vector<Eigen::Vector3f>> wall_corners(planes.walls.size());
  for (size_t s = 0; s < planes.supports.size(); ++s) {
    RoomPlane& support = planes.supports[s];
    std::vector<size_t> met;
    for (size_t w = 0; w < planes.walls.size(); ++w)
      if (std::any_of(of_supports[s].begin(), of_supports[s].end(), [&](const Eigen::Vector3f& p) {
            return std::abs(planes.walls[w].height_m(p.cast<double>())) < kCornerGap_cells * cell_m;
          }))
        met.push_back(w);
    std::vector<Eigen::Vector3f> corners;
    for (size_t a = 0; a < met.size(); ++a)
      for (size_t b = a + 1; b < met.size(); ++b) {
        Eigen::Matrix3d normals;
        normals << support.normal.transpose(), planes.walls[met[a]].normal.transpose(),
            planes.walls[met[b]].normal.transpose();
        if (std::abs(normals.determinant()) < kMinCorner) continue;
        const Vector3d corner = normals.inverse() * Vector3d(support.offset_m, planes.walls[met[a]].offset_m,
                                                             planes.walls[met[b]].offset_m);
        corners.push_back(corner.cast<float>());
        wall_corners[met[a]].push_back(corners.back());
        wall_corners[met[b]].push_back(corners.back());
      }
    if (!corners.empty()) support.region = PlaneRegion(support.normal, cell_m, of_supports[s], corners);
  }
  for (size_t w = 0; w < planes.walls.size(); ++w)
    if (!wall_corners[w].empty())
      planes.walls[w].region = PlaneRegion(planes.walls[w].normal, cell_m, of_walls[w], wall_corners[w]);
}

}  // namespace

RoomPlanes find_planes(std::span<const ViewPoint> points, const Vector3d& up, double footprint_m) {
  RoomPlanes planes;
  std::mt19937_64 random(20240607);
  std::vector<uint8_t> taken(points.size(), 0);
  const auto open_points = [&](auto&& wanted) {
    std::vector<uint32_t> open;
    for (uint32_t i = 0; i < points.size(); ++i)
      if (!taken[i] && wanted(points[i].normal.cast<double>())) open.push_back(i);
    return open;
  };
  std::vector<std::vector<Eigen::Vector3f>> of_supports, of_walls;  // points of each plane
  const auto find = [&](size_t most, double min_share, auto&& fits, auto&& wanted, auto&& accept,
                        std::vector<RoomPlane>& found, std::vector<std::vector<Eigen::Vector3f>>& of_found) {
    for (size_t attempt = 0; attempt < 2 * most && found.size() < most; ++attempt) {
      const std::vector<uint32_t> open = open_points(wanted);
      if (static_cast<double>(open.size()) < min_share * static_cast<double>(points.size())) return;
      const Candidate best = best_plane(points, open, footprint_m, random, fits);
      if (best.score == 0) return;
      RoomPlane plane = refit(points, open, best, footprint_m);
      const double tolerance_m =
          std::max(kInlierDeviations * plane.deviation_m, kTolerance_footprints * footprint_m);
      std::vector<Eigen::Vector3f> inliers;
      for (uint32_t i : open) {
        if (!on_plane(points[i], plane.normal, plane.offset_m, tolerance_m)) continue;
        taken[i] = 1;
        inliers.push_back(points[i].position_m);
      }
      plane.share = static_cast<double>(inliers.size()) / static_cast<double>(points.size());
      if (plane.share < min_share) return;  // the largest one is too small
      if (!accept(plane)) continue;
      plane.region = PlaneRegion(plane.normal, kRegionCell_footprints * footprint_m, inliers);
      found.push_back(std::move(plane));
      of_found.push_back(std::move(inliers));
    }
  };
  find(
      kMaxSupports, kMinSupportShare, [&](const Vector3d& n) { return n.dot(up) > kMaxTilt; },
      [&](const Vector3d& n) { return n.dot(up) > kMaxPointTilt; }, [](const RoomPlane&) { return true; },
      planes.supports, of_supports);
  const double upright = std::sqrt(1 - kMaxTilt * kMaxTilt);
  find(
      kMaxWalls, kMinWallShare, [&](const Vector3d& n) { return std::abs(n.dot(up)) < upright; },
      [&](const Vector3d& n) { return n.norm() > 0.5 && std::abs(n.dot(up)) < 0.5; },
      [&](const RoomPlane& plane) {
        const double behind =
            static_cast<double>(std::count_if(points.begin(), points.end(), [&](const ViewPoint& p) {
              return plane.height_m(p.position_m.cast<double>()) < -3 * kTolerance_footprints * footprint_m;
            }));
        return behind < kMaxBehind * static_cast<double>(points.size());
      },
      planes.walls, of_walls);
  reach_corners(planes, footprint_m, of_supports, of_walls);
  std::sort(planes.supports.begin(), planes.supports.end(),
            [&](const RoomPlane& a, const RoomPlane& b) { return a.offset_m > b.offset_m; });
  return planes;
}

}  // namespace livegs
