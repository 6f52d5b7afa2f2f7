// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <vector>

#include "core/result.h"

namespace livegs {

// Paths of surface points in the picture of one camera.
struct PointTracks {
  // Times of the frames, seconds of the scene, increasing. The first is the time at which the points are
  // placed on the surface.
  std::vector<double> times_s;
  // Point-major: [point * times_s.size() + frame], pixels as Camera has them; NaN where a point is not
  // visible. Every point is seen in the first frame.
  std::vector<Eigen::Vector2d> positions_px;

  size_t frames() const { return times_s.size(); }
  size_t points() const { return times_s.empty() ? 0 : positions_px.size() / times_s.size(); }
  const Eigen::Vector2d& at(size_t point, size_t frame) const {
    return positions_px[point * times_s.size() + frame];
  }
};

// More points take longer without narrower ranges: 400 points are about 20 px apart on an object of 400 x 400
// px.
inline constexpr size_t kMaxTrackedPoints = 4000;
inline constexpr size_t kMaxTrackedFrames = 4000;

// Reads a CSV file with the header point,time_s,x_px,y_px: one row for each sight of a point, in any order.
// `point` is any whole number. Points that are not in the first frame are left out. Errors name the file, the
// line and the column.
Result<PointTracks> read_tracks_file(const std::filesystem::path& path);
// Writes a file for read_tracks_file. Points are numbered from 0.
Result<void> write_tracks_file(const std::filesystem::path& path, const PointTracks& tracks);

}  // namespace livegs
