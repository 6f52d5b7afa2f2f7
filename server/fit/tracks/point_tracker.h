// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "fit/tracks/video_frames.h"

// Points that are followed from frame to frame by pyramidal Lucas-Kanade (Bouguet 2000; OpenCV). One thread.

namespace livegs {

// Corners of a picture that can be tracked (Shi and Tomasi 1994): the strongest first, at least `apart_px`
// from each other, at most `count`. `mask` has one entry per pixel; zero: no corners here. Pixels as Camera
// has them.
std::vector<Eigen::Vector2d> trackable_corners(const GreyPicture& picture, std::span<const uint8_t> mask,
                                               double apart_px, size_t count);

class PointTracker {
 public:
  PointTracker(const GreyPicture& first, std::span<const Eigen::Vector2d> points_px);
  ~PointTracker();
  PointTracker(const PointTracker&) = delete;
  PointTracker& operator=(const PointTracker&) = delete;

  // Follows the points into the next picture, which has the size of the first. NaN: lost for good. A point is
  // lost when it leaves the picture, or when tracking it back ends elsewhere.
  const std::vector<Eigen::Vector2d>& advance(const GreyPicture& picture);

 private:
  struct Pictures;
  std::unique_ptr<Pictures> pictures_;
  std::vector<Eigen::Vector2d> points_px_;
};

}  // namespace livegs
