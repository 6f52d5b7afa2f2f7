// SPDX-License-Identifier: Apache-2.0
#include "skin/nearest_cubes.h"

#include <algorithm>
#include <cmath>

#include "core/assert.h"

namespace livegs {
namespace {

// Centres a bin holds on average: fewer cost visits to empty bins, more cost distances.
constexpr double kCentresPerBin = 2.0;

}  // namespace

NearestCubes::NearestCubes(std::span<const Eigen::Vector3f> centres, float half_width) : half_width_(half_width) {
  LIVEGS_ASSERT(!centres.empty());
  min_ = max_ = centres[0];
  for (const Eigen::Vector3f& centre : centres) {
    min_ = min_.cwiseMin(centre);
    max_ = max_.cwiseMax(centre);
  }
  const Eigen::Vector3d extent = (max_.cast<double>() - min_.cast<double>());
  const double longest = std::max(extent.maxCoeff(), 1e-6);
  const double wanted_bins = std::max(1.0, static_cast<double>(centres.size()) / kCentresPerBin);
  const Eigen::Vector3d padded = extent.cwiseMax(1e-3 * longest);
  double width = std::cbrt(padded.prod() / wanted_bins);
  // A flat or thin set has fewer bins across than the volume suggests; widen until their number is right.
  const auto bin_count = [&](double w) { return ((extent / w).array().floor() + 1.0).prod(); };
  while (bin_count(width) > 2.0 * wanted_bins + 8.0) width *= 1.2;
  bin_width_ = static_cast<float>(width);
  for (int d = 0; d < 3; ++d) bins_[d] = static_cast<int>(std::floor(extent[d] / width)) + 1;

  const size_t bins = static_cast<size_t>(bins_[0]) * bins_[1] * bins_[2];
  std::vector<uint32_t> bin(centres.size());
  bin_begin_.assign(bins + 1, 0);
  for (size_t i = 0; i < centres.size(); ++i) {
    const Eigen::Vector3i b = bin_of(centres[i]);
    bin[i] = static_cast<uint32_t>((static_cast<size_t>(b[2]) * bins_[1] + b[1]) * bins_[0] + b[0]);
    ++bin_begin_[bin[i] + 1];
  }
  for (size_t b = 0; b < bins; ++b) bin_begin_[b + 1] += bin_begin_[b];
  std::vector<uint32_t> next(bin_begin_.begin(), bin_begin_.end() - 1);
  centres_.resize(centres.size());
  indices_.resize(centres.size());
  for (size_t i = 0; i < centres.size(); ++i) {
    const uint32_t slot = next[bin[i]]++;
    centres_[slot] = centres[i];
    indices_[slot] = static_cast<uint32_t>(i);
  }
}

Eigen::Vector3i NearestCubes::bin_of(const Eigen::Vector3f& point_in_box) const {
  Eigen::Vector3i bin;
  for (int d = 0; d < 3; ++d) {
    bin[d] = std::clamp(static_cast<int>((point_in_box[d] - min_[d]) / bin_width_), 0, bins_[d] - 1);
  }
  return bin;
}

void NearestCubes::search_bin(int x, int y, int z, const Eigen::Vector3f& point, std::span<Neighbour> nearest,
                              size_t& found) const {
  const size_t bin = (static_cast<size_t>(z) * bins_[1] + y) * bins_[0] + x;
  for (uint32_t slot = bin_begin_[bin]; slot < bin_begin_[bin + 1]; ++slot) {
    const Eigen::Array3f outside = ((point - centres_[slot]).array().abs() - half_width_).max(0.0f);
    const Neighbour candidate{outside.matrix().squaredNorm(), indices_[slot]};
    const auto closer = [](const Neighbour& a, const Neighbour& b) {
      return a.distance_squared < b.distance_squared ||
             (a.distance_squared == b.distance_squared && a.index < b.index);
    };
    if (found == nearest.size()) {
      if (!closer(candidate, nearest[found - 1])) continue;
    } else {
      ++found;
    }
    size_t place = found - 1;
    for (; place > 0 && closer(candidate, nearest[place - 1]); --place) nearest[place] = nearest[place - 1];
    nearest[place] = candidate;
  }
}

size_t NearestCubes::find(const Eigen::Vector3f& point, std::span<Neighbour> nearest) const {
  if (nearest.empty()) return 0;
  // Bins are visited in shells around the one that holds the point of the box nearest to `point`. A centre of shell
  // r or beyond lies at least (r - 1) bins and the way to the border of the home bin from that point along some
  // axis, and clamping to a box shortens no distance, so the squared distance to its cube is at least
  // base + max(that way - half width, 0)².
  const Eigen::Vector3f in_box = point.cwiseMax(min_).cwiseMin(max_);
  const float base = ((point - in_box).array().abs() - half_width_).max(0.0f).matrix().squaredNorm();
  const Eigen::Vector3i home = bin_of(in_box);
  const Eigen::Array3f in_bin = (in_box - min_).array() - home.cast<float>().array() * bin_width_;
  const float border = std::max(0.0f, std::min(in_bin.minCoeff(), (bin_width_ - in_bin).minCoeff()));
  const int last = std::max({home[0], home[1], home[2], bins_[0] - 1 - home[0], bins_[1] - 1 - home[1],
                             bins_[2] - 1 - home[2]});
  size_t found = 0;
  for (int shell = 0; shell <= last; ++shell) {
    if (found == nearest.size() && shell > 0) {
      // A hair below the true bound: rounding may not cost the nearest one.
      const float way = 0.9999f * (static_cast<float>(shell - 1) * bin_width_ + border);
      const float reach = std::max(way - half_width_, 0.0f);
      if (0.9999f * base + reach * reach > nearest[found - 1].distance_squared) break;
    }
    const int z_begin = std::max(home[2] - shell, 0), z_end = std::min(home[2] + shell, bins_[2] - 1);
    const int y_begin = std::max(home[1] - shell, 0), y_end = std::min(home[1] + shell, bins_[1] - 1);
    const int x_begin = std::max(home[0] - shell, 0), x_end = std::min(home[0] + shell, bins_[0] - 1);
    for (int z = z_begin; z <= z_end; ++z) {
      for (int y = y_begin; y <= y_end; ++y) {
        const bool whole_row = std::abs(z - home[2]) == shell || std::abs(y - home[1]) == shell;
        if (whole_row) {
          for (int x = x_begin; x <= x_end; ++x) search_bin(x, y, z, point, nearest, found);
        } else {
          if (home[0] - shell >= 0) search_bin(home[0] - shell, y, z, point, nearest, found);
          if (home[0] + shell < bins_[0]) search_bin(home[0] + shell, y, z, point, nearest, found);
        }
      }
    }
  }
  return found;
}

}  // namespace livegs
