// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/lattice/box_links.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/disjoint_sets.h"

namespace livegs {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Maximum gap in box edges. A smaller value lets jitter open cracks; a larger one closes slits.
constexpr double kMaxLinkGap = 0.5;

// Boxes, binned by the cubic cell that contains their centre.
class BoxGrid {
 public:
  BoxGrid(const BodyExtent& extent, double cube_m) : extent_(extent), cube_m_(cube_m) {
    for (uint32_t i = 0; i < extent.boxes.size(); ++i)
      places_.push_back({cube_of(extent.boxes[i].centre_m), i});
    std::sort(places_.begin(), places_.end(), before);
  }

  // Visits every other box with its centre in the bin of box i or in an adjacent bin.
  void for_each_near(uint32_t i, const std::function<void(uint32_t)>& take) const {
    const Vector3i own = cube_of(extent_.boxes[i].centre_m);
    for (int z = -1; z <= 1; ++z) {
      for (int y = -1; y <= 1; ++y) {
        // Bins of one row are consecutive.
        auto place =
            std::lower_bound(places_.begin(), places_.end(), Place{own + Vector3i(-1, y, z), 0}, before);
        for (; place != places_.end() && place->cube.z() == own.z() + z && place->cube.y() == own.y() + y &&
               place->cube.x() <= own.x() + 1;
             ++place) {
          if (place->box != i) take(place->box);
        }
      }
    }
  }

 private:
  struct Place {
    Vector3i cube;
    uint32_t box;
  };
  static bool before(const Place& a, const Place& b) {
    for (int d = 2; d >= 0; --d) {
      if (a.cube[d] != b.cube[d]) return a.cube[d] < b.cube[d];
    }
    return a.box < b.box;
  }
  Vector3i cube_of(const Vector3d& point_m) const {
    return ((point_m - extent_.min_m) / cube_m_).array().floor().cast<int>();
  }

  const BodyExtent& extent_;
  double cube_m_;
  std::vector<Place> places_;
};

}  // namespace

std::vector<std::pair<uint32_t, uint32_t>> link_boxes(const BodyExtent& extent, double max_gap_m) {
  const size_t count = extent.boxes.size();
  // A box represents at least the material within half its spacing.
  const double least_half_m = 0.5 * extent.spacing_m;
  double widest_half_m = 0.0;
  std::vector<Vector3d> halves(count);
  for (size_t i = 0; i < count; ++i) {
    halves[i] = extent.boxes[i].half_m.cwiseMax(least_half_m);
    widest_half_m = std::max(widest_half_m, halves[i].maxCoeff());
  }
  const auto gap_m = [&](uint32_t i, uint32_t j) {
    return ((extent.boxes[i].centre_m - extent.boxes[j].centre_m).cwiseAbs() - halves[i] - halves[j])
        .maxCoeff();
  };

  std::vector<std::pair<uint32_t, uint32_t>> links;
  DisjointSets parts(count);
  const auto link = [&](uint32_t i, uint32_t j, double widest_m) {
    if (gap_m(i, j) > widest_m) return;
    links.emplace_back(std::min(i, j), std::max(i, j));
    parts.join(i, j);
  };
  double widest_m = kMaxLinkGap * std::max(extent.box_edge_m, extent.spacing_m);
  const BoxGrid touching(extent, 2.0 * widest_half_m + widest_m);
  for (uint32_t i = 0; i < count; ++i) {
    touching.for_each_near(i, [&](uint32_t j) {
      if (i < j) link(i, j, widest_m);
    });
  }

  // Bridges gaps: the smaller parts search with a growing range until they reach the rest.
  while (widest_m < max_gap_m) {
    std::vector<uint32_t> part(count), size(count, 0);
    for (uint32_t i = 0; i < count; ++i) ++size[part[i] = parts.find(i)];
    const auto largest = static_cast<uint32_t>(std::max_element(size.begin(), size.end()) - size.begin());
    if (size[largest] == count) break;
    widest_m = std::min(2.0 * widest_m, max_gap_m);
    const BoxGrid near(extent, 2.0 * widest_half_m + widest_m);
    for (uint32_t i = 0; i < count; ++i) {
      if (part[i] == largest) continue;
      near.for_each_near(i, [&](uint32_t j) {
        if (part[j] != part[i] && (i < j || part[j] == largest)) link(i, j, widest_m);
      });
    }
  }
  std::sort(links.begin(), links.end());
  return links;
}

}  // namespace livegs
