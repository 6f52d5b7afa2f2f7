// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/file.h"
#include "core/text/format_text.h"
#include "fit/point_tracks.h"
#include "scene/values/csv_lines.h"

namespace livegs {
namespace {

struct Sight {
  double point, time_s;
  Eigen::Vector2d at_px;
};

constexpr uint64_t kMaxTracksBytes = uint64_t{256} << 20;
const Eigen::Vector2d kUnseen = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());

}  // namespace

Result<PointTracks> read_tracks_file(const std::filesystem::path& path) {
  std::vector<Sight> sights;
  const CsvLayout layout{"point,time_s,x_px,y_px", "point,time_s,x_px,y_px", 1e9, kMaxTracksBytes};
  auto read = read_csv_lines(path, layout, [&](size_t, std::span<const double> numbers) -> Result<void> {
    sights.push_back({numbers[0], numbers[1], {numbers[2], numbers[3]}});
    return {};
  });
  if (!read) return read.error();
  const auto bad = [&](const char* problem) { return invalid_data(path.string() + ": " + problem); };
  std::map<double, size_t> frame_of, point_of;
  for (const Sight& sight : sights) frame_of[sight.time_s] = 0;
  if (!frame_of.empty() && frame_of.begin()->first < 0)
    return bad("has times before 0; count from the start of the scene");
  if (frame_of.size() < 3) return bad("has fewer than three times; give at least three frames");
  if (frame_of.size() > kMaxTrackedFrames) return bad("has more than 4000 times; give fewer frames");
  PointTracks tracks;
  for (auto& [time_s, frame] : frame_of) {
    frame = tracks.times_s.size();
    tracks.times_s.push_back(time_s);
  }
  for (const Sight& sight : sights)
    if (frame_of[sight.time_s] == 0) point_of[sight.point] = 0;
  if (point_of.size() > kMaxTrackedPoints) return bad("has more than 4000 points; give fewer");
  size_t count = 0;
  for (auto& [point, index] : point_of) index = count++;
  tracks.positions_px.assign(count * tracks.frames(), kUnseen);
  for (const Sight& sight : sights) {
    const auto point = point_of.find(sight.point);
    if (point == point_of.end()) continue;
    Eigen::Vector2d& at = tracks.positions_px[point->second * tracks.frames() + frame_of[sight.time_s]];
    if (!std::isnan(at.x()))
      return invalid_data(format_text("%s: point %.17g has two rows at %.9g s; give one", path.c_str(),
                                      sight.point, sight.time_s));
    at = sight.at_px;
  }
  return tracks;
}

Result<void> write_tracks_file(const std::filesystem::path& path, const PointTracks& tracks) {
  std::string text = "point,time_s,x_px,y_px\n";
  for (size_t point = 0; point < tracks.points(); ++point) {
    for (size_t frame = 0; frame < tracks.frames(); ++frame) {
      const Eigen::Vector2d& at = tracks.at(point, frame);
      if (std::isnan(at.x())) continue;
      text += format_text("%zu,%.9g,%.4f,%.4f\n", point, tracks.times_s[frame], at.x(), at.y());
    }
  }
  return write_file_atomically(path, text);
}

}  // namespace livegs
