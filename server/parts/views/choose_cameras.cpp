// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/views/choose_cameras.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel_for.h"
#include "gaussian/opacity.h"
#include "splat/frame_bounds.h"

namespace livegs {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr int kGridCells = 96;              // along the longest side of the room
constexpr float kMinCountedOpacity = 0.1f;  // of a kernel that fills a cell
constexpr int kTargets = 5, kAzimuths = 12;
constexpr double kElevations_deg[] = {8, 25, 45, 68};
constexpr double kRadii[] = {0.2, 0.4, 0.8};  // in half diagonals of the room
constexpr int kRaysAcross = 24, kRaysDown = 18;
constexpr double kViewFov_rad = 0.85;  // vertical
constexpr int kClearCells = 2;         // around a camera

class Occupancy {
 public:
  Occupancy(const GaussianAsset& asset, const Eigen::AlignedBox3d& box)
      : box_(box), cell_(std::max(box.sizes().maxCoeff() / kGridCells, 1e-9)) {
    size_ = ((box.sizes() / cell_).array().floor().cast<int>() + 1).matrix();
    count_.assign(static_cast<size_t>(size_.x()) * size_.y() * size_.z(), 0);
    for (size_t i = 0; i < asset.size(); ++i) {
      if (opacity_of_logit(asset.opacity_logits[i]) < kMinCountedOpacity) continue;
      if (const int cell = at(cell_of(asset.positions[i].cast<double>())); cell >= 0) ++count_[cell];
    }
  }
  Vector3i cell_of(const Vector3d& p) const { return ((p - box_.min()) / cell_).array().floor().cast<int>(); }
  int at(const Vector3i& c) const {
    if ((c.array() < 0).any() || (c.array() >= size_.array()).any()) return -1;
    return (c.z() * size_.y() + c.y()) * size_.x() + c.x();
  }
  uint32_t count(int cell) const { return count_[cell]; }
  size_t size() const { return count_.size(); }
  double cell_m() const { return cell_; }
  Vector3d centre(int cell) const {
    const Vector3i c(cell % size_.x(), cell / size_.x() % size_.y(), cell / size_.x() / size_.y());
    return box_.min() + cell_ * (c.cast<double>() + Vector3d::Constant(0.5));
  }
  bool clear(const Vector3d& p) const {
    const Vector3i c = cell_of(p);
    if (at(c) < 0) return false;
    for (int x = -kClearCells; x <= kClearCells; ++x)
      for (int y = -kClearCells; y <= kClearCells; ++y)
        for (int z = -kClearCells; z <= kClearCells; ++z)
          if (const int cell = at(c + Vector3i(x, y, z)); cell >= 0 && count_[cell] > 0) return false;
    return true;
  }
  // The first occupied cell on a ray, by steps of half a cell; -1 if there is none.
  int first_hit(const Vector3d& from, const Vector3d& direction) const {
    for (double t = 0; t < 4 * kGridCells * cell_; t += 0.5 * cell_) {
      const int cell = at(cell_of(from + t * direction));
      if (cell < 0) return -1;
      if (count_[cell] > 0) return cell;
    }
    return -1;
  }

 private:
  Eigen::AlignedBox3d box_;
  double cell_;
  Vector3i size_;
  std::vector<uint32_t> count_;
};

// Dense places, far apart from each other: the densest cell first, then the cell with the largest product of
// its density and its squared distance to the places so far. Densities are smoothed over 5^3 cells.
std::vector<Vector3d> dense_places(const Occupancy& cells, size_t count) {
  std::vector<int> occupied;
  for (size_t i = 0; i < cells.size(); ++i)
    if (cells.count(static_cast<int>(i)) > 0) occupied.push_back(static_cast<int>(i));
  std::vector<double> density(occupied.size(), 0.0);
  parallel_for(occupied.size(), 256, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Vector3i c = cells.cell_of(cells.centre(occupied[i]));
      for (int x = -2; x <= 2; ++x)
        for (int y = -2; y <= 2; ++y)
          for (int z = -2; z <= 2; ++z)
            if (const int cell = cells.at(c + Vector3i(x, y, z)); cell >= 0) density[i] += cells.count(cell);
    }
  });
  std::vector<double> distance(occupied.size(), 1.0);
  std::vector<Vector3d> places;
  for (size_t k = 0; k < count && !occupied.empty(); ++k) {
    size_t best = 0;
    for (size_t i = 1; i < occupied.size(); ++i)
      if (density[i] * distance[i] > density[best] * distance[best]) best = i;
    places.push_back(cells.centre(occupied[best]));
    for (size_t i = 0; i < occupied.size(); ++i) {
      const double squared = (cells.centre(occupied[i]) - places.back()).squaredNorm();
      distance[i] = k == 0 ? squared : std::min(distance[i], squared);
    }
  }
  return places;
}

}  // namespace

std::vector<Camera> choose_cameras(const GaussianAsset& asset, const Vector3d& up, size_t count, int width) {
  const Eigen::AlignedBox3d box = robust_bounds(asset.positions);
  if (box.isEmpty() || !(box.sizes().maxCoeff() > 0)) return {};
  Eigen::AlignedBox3d wide = box;
  const Vector3d margin = Vector3d::Constant(0.02 * box.diagonal().norm());
  wide.extend(box.min() - margin);
  wide.extend(box.max() + margin);
  // A capture that is open above has free space over its bounds.
  wide.extend(box.center() + 0.5 * box.diagonal().norm() * up);
  const Occupancy cells(asset, wide);
  const Vector3d side = std::abs(up.x()) < 0.7 ? Vector3d::UnitX() : Vector3d::UnitZ();
  const Vector3d u = (side - up * up.dot(side)).normalized(), v = up.cross(u);

  struct CameraCandidate {
    Camera camera;
    std::vector<int> cells;
  };
  std::vector<CameraCandidate> candidates;
  const double half_m = 0.5 * box.diagonal().norm();
  for (const Vector3d& target : dense_places(cells, kTargets))
    for (const double radius : kRadii)
      for (const double elevation_deg : kElevations_deg)
        for (int a = 0; a < kAzimuths; ++a) {
          const double azimuth = 2 * std::numbers::pi * a / kAzimuths,
                       elevation = elevation_deg * std::numbers::pi / 180;
          const Vector3d direction = std::cos(elevation) * (std::cos(azimuth) * u + std::sin(azimuth) * v) +
                                     std::sin(elevation) * up;
          const Vector3d position = target + radius * half_m * direction;
          if (!cells.clear(position)) continue;
          const int hit = cells.first_hit(position, -direction);
          if (hit < 0 || (cells.centre(hit) - target).norm() > 0.3 * radius * half_m + 3 * cells.cell_m())
            continue;
          Camera camera = look_at(position, target, up, kViewFov_rad, width, width * 3 / 4);
          camera.near_m = 0.25 * cells.cell_m();
          candidates.push_back({camera, {}});
        }
  parallel_for(candidates.size(), 4, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Camera& camera = candidates[i].camera;
      for (int y = 0; y < kRaysDown; ++y)
        for (int x = 0; x < kRaysAcross; ++x) {
          const Vector3d ray(
              ((x + 0.5) / kRaysAcross * camera.width - camera.centre_x_px) / camera.focal_x_px,
              -((y + 0.5) / kRaysDown * camera.height - camera.centre_y_px) / camera.focal_y_px, -1.0);
          const int hit = cells.first_hit(camera.world_from_camera.position_m,
                                          (camera.world_from_camera.orientation * ray).normalized());
          if (hit >= 0) candidates[i].cells.push_back(hit);
        }
    }
  });
  std::vector<float> seen(cells.size(), 0.0f);
  std::vector<Camera> cameras;
  std::vector<uint8_t> used(candidates.size(), 0);
  while (cameras.size() < count) {
    double best_score = 0;
    size_t best = candidates.size();
    for (size_t i = 0; i < candidates.size(); ++i) {
      if (used[i]) continue;
      double score = 0;
      for (int cell : candidates[i].cells) score += cells.count(cell) / (1.0 + seen[cell]);
      if (score > best_score) best_score = score, best = i;
    }
    if (best == candidates.size()) break;
    used[best] = 1;
    cameras.push_back(candidates[best].camera);
    for (int cell : candidates[best].cells) seen[cell] += 1.0f;
  }
  return cameras;
}

Camera with_width(Camera camera, int width) {
  const double scale = static_cast<double>(width) / camera.width;
  camera.width = width;
  camera.height = std::max(1, static_cast<int>(std::lround(scale * camera.height)));
  camera.focal_x_px *= scale;
  camera.focal_y_px *= scale;
  camera.centre_x_px *= scale;
  camera.centre_y_px *= scale;
  return camera;
}

Eigen::Vector3d mean_up(const std::vector<Camera>& cameras) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Camera& camera : cameras) sum += camera.world_from_camera.orientation * Eigen::Vector3d::UnitY();
  return sum.norm() > 1e-9 ? Eigen::Vector3d(sum.normalized()) : Eigen::Vector3d::UnitY();
}

std::vector<Camera> thin_cameras(const std::vector<Camera>& cameras, size_t count, int width) {
  std::vector<Camera> kept;
  const size_t most = std::min(count, cameras.size());
  for (size_t i = 0; i < most; ++i) {
    Camera camera = cameras[i * cameras.size() / most];
    if (camera.width > width) camera = with_width(camera, width);
    kept.push_back(camera);
  }
  return kept;
}

}  // namespace livegs
