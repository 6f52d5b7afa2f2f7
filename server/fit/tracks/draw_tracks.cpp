// SPDX-License-Identifier: GPL-3.0-or-later
#include "fit/draw_tracks.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace livegs {
namespace {

constexpr float kDarkened = 0.45f;
constexpr int kFractionBits = 4;  // of coordinates for cv::line

void draw_path(cv::Mat& picture, const PointTracks& tracks, size_t point, const cv::Scalar& colour) {
  const auto place = [&](size_t frame) {
    const Eigen::Vector2d scaled = (tracks.at(point, frame).array() - 0.5) * (1 << kFractionBits);
    return cv::Point(static_cast<int>(std::lround(scaled.x())), static_cast<int>(std::lround(scaled.y())));
  };
  for (size_t frame = 1; frame < tracks.frames(); ++frame) {
    if (tracks.at(point, frame).hasNaN() || tracks.at(point, frame - 1).hasNaN()) continue;
    cv::line(picture, place(frame - 1), place(frame), colour, 1, cv::LINE_AA, kFractionBits);
  }
}

}  // namespace

void draw_tracks(const PointTracks& measured, const PointTracks& simulated, Image& picture) {
  // Smooth lines need 8 bits.
  cv::Mat bytes(picture.height, picture.width, CV_8UC3);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      for (int c = 0; c < 3; ++c)
        bytes.ptr(y, x)[c] = static_cast<uint8_t>(
            std::lround(255.0f * kDarkened * std::clamp(picture.at(x, y)[c], 0.0f, 1.0f)));
  const size_t stride = std::max<size_t>(1, (measured.points() + kMaxDrawnPaths - 1) / kMaxDrawnPaths);
  for (size_t point = 0; point < measured.points(); point += stride) {
    draw_path(bytes, simulated, point, cv::Scalar(255, 140, 40));
    draw_path(bytes, measured, point, cv::Scalar(255, 255, 255));  // mostly the same path, and shorter
  }
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      for (int c = 0; c < 3; ++c) picture.at(x, y)[c] = static_cast<float>(bytes.ptr(y, x)[c]) / 255.0f;
}

}  // namespace livegs
