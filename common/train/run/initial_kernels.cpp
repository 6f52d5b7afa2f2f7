// SPDX-License-Identifier: Apache-2.0
#include "train/run/initial_kernels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/parallel_for.h"
#include "gaussian/spherical_harmonics.h"
#include "train/optimise/random_number.h"

namespace livegs {
namespace {

constexpr size_t kNeighbours = 3;
constexpr size_t kLeaf = 8;  // points of a leaf of the tree
constexpr uint64_t kPlaceStream = 1000, kThinStream = 1001;

// A k-d tree over `points` in the form of an order: the middle of each range splits it along its widest axis.
class PointTree3 {
 public:
  explicit PointTree3(const std::vector<Eigen::Vector3f>& points) : points_(points), order_(points.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    axes_.resize(points.size());
    build(0, points.size());
  }
  // Squared distances to the nearest points except `self`, ascending; infinity for missing ones.
  std::array<float, kNeighbours> nearest(size_t self) const {
    std::array<float, kNeighbours> best;
    best.fill(std::numeric_limits<float>::infinity());
    search(0, points_.size(), self, best);
    return best;
  }

 private:
  void build(size_t begin, size_t end) {
    if (end - begin <= kLeaf) return;
    Eigen::Vector3f low = points_[order_[begin]], high = low;
    for (size_t i = begin; i < end; ++i) {
      low = low.cwiseMin(points_[order_[i]]);
      high = high.cwiseMax(points_[order_[i]]);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const size_t middle = (begin + end) / 2;
    std::nth_element(order_.begin() + static_cast<std::ptrdiff_t>(begin),
                     order_.begin() + static_cast<std::ptrdiff_t>(middle),
                     order_.begin() + static_cast<std::ptrdiff_t>(end), [&](uint32_t a, uint32_t b) {
                       const float x = points_[a][axis], y = points_[b][axis];
                       return x < y || (x == y && a < b);
                     });
    axes_[middle] = static_cast<uint8_t>(axis);
    build(begin, middle);
    build(middle + 1, end);
  }
  void consider(uint32_t point, size_t self, std::array<float, kNeighbours>& best) const {
    if (point == self) return;
    float distance = (points_[point] - points_[self]).squaredNorm();
    for (float& one : best) {
      if (distance < one) std::swap(distance, one);
    }
  }
  void search(size_t begin, size_t end, size_t self, std::array<float, kNeighbours>& best) const {
    if (end - begin <= kLeaf) {
      for (size_t i = begin; i < end; ++i) consider(order_[i], self, best);
      return;
    }
    const size_t middle = (begin + end) / 2;
    const int axis = axes_[middle];
    const float side = points_[self][axis] - points_[order_[middle]][axis];
    if (side <= 0) {
      search(begin, middle, self, best);
    } else {
      search(middle + 1, end, self, best);
    }
    consider(order_[middle], self, best);
    if (side * side >= best.back()) return;
    if (side <= 0) {
      search(middle + 1, end, self, best);
    } else {
      search(begin, middle, self, best);
    }
  }
  const std::vector<Eigen::Vector3f>& points_;
  std::vector<uint32_t> order_;
  std::vector<uint8_t> axes_;
};

// Points in front of the cameras, at distances between a fifth and five times the extent of the scene.
void place_at_random(const Capture& capture, double extent, uint64_t seed,
                     std::vector<Eigen::Vector3f>& points, std::vector<Eigen::Vector3f>& colours) {
  for (size_t i = 0; i < kRandomPoints; ++i) {
    const auto share = [&](uint64_t k) { return random_share(seed, kPlaceStream, 4 * i + k); };
    const size_t view = std::min(static_cast<size_t>(share(0) * static_cast<double>(capture.views.size())),
                                 capture.views.size() - 1);
    const Camera& camera = capture.views[view].camera;
    const double depth = extent * 0.2 * std::pow(25.0, share(1));
    const Eigen::Vector3d seen((share(2) * camera.width - camera.centre_x_px) / camera.focal_x_px,
                               -(share(3) * camera.height - camera.centre_y_px) / camera.focal_y_px, -1.0);
    points.push_back((camera.world_from_camera * (depth * seen)).cast<float>());
    colours.push_back(Eigen::Vector3f::Constant(0.5f));
  }
}

}  // namespace

std::vector<float> neighbour_distances(const std::vector<Eigen::Vector3f>& points) {
  std::vector<float> distances(points.size(), 0.0f);
  const PointTree3 tree(points);
  parallel_for(points.size(), 512, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      float sum = 0;
      int found = 0;
      for (float squared : tree.nearest(i)) {
        if (!std::isfinite(squared)) continue;
        sum += squared;
        ++found;
      }
      distances[i] = found > 0 ? std::sqrt(sum / static_cast<float>(found)) : 0.0f;
    }
  });
  return distances;
}

KernelParameters initial_kernels(const Capture& capture, double extent, size_t max_count, uint64_t seed) {
  std::vector<Eigen::Vector3f> points = capture.points, colours = capture.point_colours;
  if (points.size() < kMinPoints) place_at_random(capture, extent, seed, points, colours);
  if (points.size() > max_count) {
    // Keeps the points with the smallest random numbers.
    std::vector<std::pair<uint64_t, size_t>> ranks(points.size());
    for (size_t i = 0; i < points.size(); ++i) ranks[i] = {random_bits(seed, kThinStream, i), i};
    std::nth_element(ranks.begin(), ranks.begin() + static_cast<std::ptrdiff_t>(max_count), ranks.end());
    std::vector<size_t> kept(max_count);
    for (size_t i = 0; i < max_count; ++i) kept[i] = ranks[i].second;
    std::sort(kept.begin(), kept.end());
    for (size_t i = 0; i < max_count; ++i) {
      points[i] = points[kept[i]];
      colours[i] = colours[kept[i]];
    }
    points.resize(max_count);
    colours.resize(max_count);
  }
  const std::vector<float> distances = neighbour_distances(points);
  KernelParameters kernels;
  kernels.resize(points.size());
  // Points in one place would have no size.
  const auto smallest = static_cast<float>(1e-4 * extent);
  for (size_t k = 0; k < points.size(); ++k) {
    const float log_scale = std::log(std::max(distances[k], smallest));
    for (int i = 0; i < 3; ++i) {
      kernels.row(Family::Position, k)[i] = points[k][i];
      kernels.row(Family::LogScale, k)[i] = log_scale;
      kernels.row(Family::Colour, k)[i] = (colours[k][i] - 0.5f) / kShDc;
    }
    kernels.row(Family::Rotation, k)[0] = 1;
  }
  return kernels;
}

}  // namespace livegs
