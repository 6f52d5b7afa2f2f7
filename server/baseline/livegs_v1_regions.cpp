// SPDX-License-Identifier: GPL-3.0-or-later
// Regions of the baseline: individual particles are held, moved and loaded.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "baseline/livegs_v1_body.h"
#include "core/log.h"

namespace livegs {

using Eigen::Vector3d;

// Where regions overlap, the later one holds the particle.
void LivegsV1Body::hold_regions() {
  holders_.assign(rest_m_.size(), -1);
  for (size_t r = 0; r < regions_.size(); ++r) {
    const BodyRegion& region = regions_[r];
    if (released_[r] || !(region.fixed || region.motion)) continue;
    if (region.boundary) {
      for (const SurfacePoint& point : surface_) holders_[point.particle] = static_cast<int>(r);
      continue;
    }
    for (size_t i = 0; i < rest_m_.size(); ++i) {
      if (region.contains(rest_m_[i], 1e-9)) holders_[i] = static_cast<int>(r);
    }
  }
  driven_.clear();
  held_ = anchored_ = false;
  for (uint32_t i = 0; i < holders_.size(); ++i) {
    if (!held(i)) continue;
    held_ = true;
    if (regions_[static_cast<size_t>(holders_[i])].fixed) {
      anchored_ = true;
    } else {
      driven_.push_back(i);
    }
  }
}

// A traction acts on the face across the shortest edge of the region, clipped to the body's bounds: the face
// nearer to the body's bound. The part of each particle's voxel inside the region contributes an area, and
// the outermost particle of its voxel column receives the force.
void LivegsV1Body::load_regions() {
  bool other_material = false;
  for (const BodyRegion& region : regions_) {
    other_material = other_material || region.material.has_value();
    if (region.traction_pa.squaredNorm() == 0.0) continue;
    const Vector3d low = region.min_m.cwiseMax(low_m_), high = region.max_m.cwiseMin(high_m_),
                   size = high - low;
    int across = 0;
    for (int d = 1; d < 3; ++d) {
      if (size[d] < (1.0 - 1e-9) * size[across]) across = d;
    }
    const double sign = high_m_[across] - high[across] <= low[across] - low_m_[across] ? 1.0 : -1.0;
    const int u = (across + 1) % 3, v = (across + 2) % 3;
    struct Column {
      uint32_t outermost;
      double area_m2;
    };
    std::map<std::pair<int64_t, int64_t>, Column> columns;
    for (uint32_t i = 0; i < rest_m_.size(); ++i) {
      const Vector3d half = Vector3d::Constant(0.5 * std::cbrt(volumes_m3_[i]));
      const Vector3d shared = (rest_m_[i] + half).cwiseMin(high) - (rest_m_[i] - half).cwiseMax(low);
      if (!(size[across] > 0.0) || (shared.array() <= 1e-9 * half[0]).any()) continue;
      const auto column = [&](int d) {
        return static_cast<int64_t>(std::floor((rest_m_[i][d] - low_m_[d]) / spacing_m_));
      };
      Column& at = columns.try_emplace({column(u), column(v)}, Column{i, 0.0}).first->second;
      at.area_m2 += shared.prod() / size[across];
      if (sign * (rest_m_[i][across] - rest_m_[at.outermost][across]) > 0.0) at.outermost = i;
    }
    for (const auto& [place, column] : columns) {
      loads_.push_back({column.outermost, column.area_m2 * region.traction_pa});
    }
    if (columns.empty()) {
      log_warn(
          "object %u: the box of region %s holds no particle, so its traction has no effect; check the box",
          object_id_, region.name.c_str());
    }
  }
  if (other_material) {
    log_warn("object %u: livegs-v1 supports one material per body; region materials are ignored", object_id_);
  }
}

bool LivegsV1Body::release_region(const std::string& name) {
  bool found = false;
  for (size_t r = 0; r < regions_.size(); ++r) {
    if (regions_[r].name != name || !(regions_[r].fixed || regions_[r].motion)) continue;
    released_[r] = found = true;
  }
  if (!found) return false;
  hold_regions();
  wake();
  return true;
}

Vector3d LivegsV1Body::prescribed_m(size_t particle, double time_s) const {
  const BodyRegion& region = regions_[static_cast<size_t>(holders_[particle])];
  return world_from_object_ * moved_point(*region.motion, rest_m_[particle], time_s) - origin_m_;
}

bool LivegsV1Body::driven(double start_s, double end_s) const {
  return std::ranges::any_of(driven_, [&](uint32_t i) {
    const RegionMotion& motion = *regions_[static_cast<size_t>(holders_[i])].motion;
    return moved_point(motion, rest_m_[i], start_s) != moved_point(motion, rest_m_[i], end_s);
  });
}

}  // namespace livegs
