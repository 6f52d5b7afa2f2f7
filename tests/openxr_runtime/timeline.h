// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/pose.h"
#include "core/result.h"

namespace livegs::simulated {

// Motion and events of a simulated user and headset, from a text file. One entry per line; `#` begins a
// comment.
//   SECONDS pose TRACK X Y Z QW QX QY QZ   pose in the stage. Tracks: head, left and right (grips), left.aim
//                                          and right.aim (default: the grip)
//   SECONDS input TRACK VALUE              value from 0 to 1, until the next entry. Tracks: left.trigger,
//                                          right.squeeze, right.primary ...
//   SECONDS do EVENT [NUMBERS]             a single event; see kEvents in timeline.cpp
// Poses are interpolated between the entries of a track. Time starts with the first frame that is submitted
// to the instance, and it does not skip events if the application is slow (runtime.h).
class Timeline {
 public:
  struct Event {
    double time_s = 0;
    std::string name;
    std::vector<double> numbers;
  };

  // Error messages contain the line number.
  static Result<Timeline> read(const std::string& path);

  bool has(const std::string& track) const { return poses_.contains(track); }
  Pose pose(const std::string& track,
            double time_s) const;  // constant before the first entry; the identity if the track is empty
  double input(const std::string& track, double time_s) const;
  // Events after `from_s` up to `to_s`, in order.
  std::vector<Event> events(double from_s, double to_s) const;

 private:
  std::map<std::string, std::map<double, Pose>> poses_;
  std::map<std::string, std::map<double, double>> inputs_;
  std::vector<Event> events_;
};

}  // namespace livegs::simulated
