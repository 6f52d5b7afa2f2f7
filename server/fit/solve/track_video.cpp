// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "core/text/format_text.h"
#include "fit/fit_scene.h"
#include "fit/solve/first_frame.h"
#include "fit/tracks/point_tracker.h"
#include "fit/tracks/video_frames.h"
#include "scene/build/build_cache.h"

namespace livegs {
namespace {

// Points tracked on each object. More narrow the range little: neighbours move together.
constexpr size_t kPointsOfObject = 300;
// Least distance of two points, px; about the patch that is compared.
constexpr double kApart_px = 6.0;
// Distance of a point from the rim of its object, px: the background behind the rim does not move with it.
constexpr int kRim_px = 2;
constexpr int kProgressFrames = 30;

}  // namespace

Result<PointTracks> track_video(const FitRequest& request, const std::filesystem::path& video,
                                const FitProgress& progress, Image* first_picture) {
  auto frames = VideoFrames::open(video);
  if (!frames) return frames.error();
  const Camera& camera = request.camera;
  if (frames->width() != camera.width || frames->height() != camera.height)
    return invalid_argument(
        format_text("%s: has %d x %d pixels, and the camera %d x %d; give the camera the size of the video",
                    video.c_str(), frames->width(), frames->height(), camera.width, camera.height));
  auto first = first_frame(request, request.first_frame_s, std::make_shared<BuildCache>(), progress);
  if (!first) return first.error();
  GreyPicture picture;
  auto more = frames->next(picture);
  if (!more) return more.error();
  if (!*more) return invalid_data(video.string() + ": has no frame");
  if (first_picture) {
    first_picture->width = picture.width;
    first_picture->height = picture.height;
    first_picture->pixels.clear();
    for (const uint8_t grey : picture.pixels) {
      const float shade = static_cast<float>(grey) / 255.0f;
      first_picture->pixels.insert(first_picture->pixels.end(), {shade, shade, shade, 1.0f});
    }
  }
  std::vector<Eigen::Vector2d> points;
  for (const std::string& object : first->objects) {
    const auto corners =
        trackable_corners(picture, first->view.mask(object, kRim_px), kApart_px, kPointsOfObject);
    if (corners.size() < kMinFitPoints)
      return invalid_data(
          format_text("%s: shows %zu places on %s that can be tracked, and %zu are needed; check camera and "
                      "first frame, or give --tracks if its surface is plain",
                      video.c_str(), corners.size(), object.c_str(), kMinFitPoints));
    points.insert(points.end(), corners.begin(), corners.end());
  }
  std::vector<std::vector<Eigen::Vector2d>> by_frame = {points};
  PointTracker tracker(picture, points);
  const auto most = std::min(kMaxTrackedFrames,
                             static_cast<size_t>(std::floor(request.max_seconds * frames->rate_hz())) + 1);
  while (by_frame.size() < most) {
    more = frames->next(picture);
    if (!more) return more.error();
    if (!*more) break;
    by_frame.push_back(tracker.advance(picture));
    const auto alive = std::count_if(by_frame.back().begin(), by_frame.back().end(),
                                     [](const Eigen::Vector2d& px) { return !px.hasNaN(); });
    if (by_frame.size() % kProgressFrames == 0 && progress &&
        !progress(
            format_text("tracking: frame %zu, %td of %zu points", by_frame.size(), alive, points.size())))
      break;
  }
  if (by_frame.size() < 3)
    return invalid_data(
        format_text("%s: has %zu frames; give a video with at least three", video.c_str(), by_frame.size()));
  PointTracks tracks;
  for (size_t frame = 0; frame < by_frame.size(); ++frame)
    tracks.times_s.push_back(request.first_frame_s + static_cast<double>(frame) / frames->rate_hz());
  for (size_t point = 0; point < points.size(); ++point)
    for (const auto& frame : by_frame) tracks.positions_px.push_back(frame[point]);
  return tracks;
}

}  // namespace livegs
