// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/pose.h"
#include "core/result.h"

namespace livegs::simulated {

// What a person and a headset do, from a text file of one entry a line, `#` begins a comment:
//   SECONDS pose TRACK X Y Z QW QX QY QZ   head, left, right (grips), left.aim, right.aim (else the grip's):
//   stage from it SECONDS input TRACK VALUE              left.trigger, right.squeeze, right.primary ...: 0 to
//   1, until the next entry SECONDS do EVENT [NUMBERS]             once: see kEvents in timeline.cpp
// Poses are interpolated between the entries of a track. Seconds count from the first picture that is
// submitted to the instance; until then it is second 0, and a slow application does not miss what happens
// (runtime.h).
class Timeline {
 public:
  struct Event {
    double time_s = 0;
    std::string name;
    std::vector<double> numbers;
  };

  // Errors name the line.
  static Result<Timeline> read(const std::string& path);

  bool has(const std::string& track) const { return poses_.contains(track); }
  Pose pose(const std::string& track,
            double time_s) const;  // the first entry's before it; at rest, where there is none
  double input(const std::string& track, double time_s) const;
  // Those after `from_s` up to `to_s`, in order.
  std::vector<Event> events(double from_s, double to_s) const;

 private:
  std::map<std::string, std::map<double, Pose>> poses_;
  std::map<std::string, std::map<double, double>> inputs_;
  std::vector<Event> events_;
};

}  // namespace livegs::simulated
