// SPDX-License-Identifier: Apache-2.0
#include "timeline.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

namespace livegs::simulated {
namespace {

// By name, the numbers each has.
const std::map<std::string, size_t> kEvents = {
    {"hide", 0},  // another application covers this one
    {"show", 0},
    {"take-focus", 0},  // a menu of the system has the hands
    {"give-focus", 0},
    {"lose-session", 0},  // announced by LOSS_PENDING, then gone
    {"cut-session", 0},   // gone without a word
    {"vanish", 0},        // the runtime says that it is going away
    {"die", 0},  // the runtime is gone without a word: all calls but those that destroy answer INSTANCE_LOST
    {"recentre", 4},    // X Y Z of the new LOCAL space in the stage, and its turn about +Y in degrees
    {"refresh", 1},     // Hz
    {"compositor", 1},  // seconds it takes longer from now on
    {"misjudge", 1},    // m/s: from now on a head is foretold that much too far to the right for each second
                        // ahead
    {"picture", 0},     // keeps the next submitted frame as PNGs
    {"exit", 0},        // asks the application to end
};

Result<std::vector<double>> numbers(std::istringstream& words, size_t count) {
  std::vector<double> values;
  for (double value = 0; words >> value;) values.push_back(value);
  if (!words.eof() || values.size() != count ||
      !std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }))
    return invalid_data("expected " + std::to_string(count) + " numbers");
  return values;
}

}  // namespace

Result<Timeline> Timeline::read(const std::string& path) {
  std::ifstream file(path);
  if (!file) return not_found(path + ": cannot be read");
  Timeline timeline;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    double time_s = 0;
    std::string kind, name;
    if (!(words >> std::ws) || words.eof()) continue;
    const auto wrong = [&](const std::string& what) {
      return invalid_data(path + ":" + std::to_string(number) + ": " + what);
    };
    if (!(words >> time_s >> kind >> name)) return wrong("is not SECONDS pose|input|do NAME ...");
    const auto event = kEvents.find(name);
    if (kind == "do" && event == kEvents.end()) return wrong("there is no event " + name);
    if (kind != "do" && kind != "pose" && kind != "input")
      return wrong("begins with neither pose, input nor do");
    const auto values = numbers(words, kind == "do" ? event->second : kind == "pose" ? 7 : 1);
    if (!values) return wrong(values.error().message);
    const std::vector<double>& v = *values;
    if (kind == "do") {
      timeline.events_.push_back({time_s, name, v});
    } else if (kind == "input") {
      timeline.inputs_[name][time_s] = v[0];
    } else {
      timeline.poses_[name][time_s] = {{v[0], v[1], v[2]},
                                       Eigen::Quaterniond(v[3], v[4], v[5], v[6]).normalized()};
    }
  }
  std::stable_sort(timeline.events_.begin(), timeline.events_.end(),
                   [](const Event& a, const Event& b) { return a.time_s < b.time_s; });
  return timeline;
}

Pose Timeline::pose(const std::string& track, double time_s) const {
  const auto found = poses_.find(track);
  if (found == poses_.end()) return {};
  const auto later = found->second.upper_bound(time_s);
  if (later == found->second.begin()) return later->second;
  const auto before = std::prev(later);
  if (later == found->second.end()) return before->second;
  const double share = (time_s - before->first) / (later->first - before->first);
  const Pose &a = before->second, &b = later->second;
  return {a.position_m + share * (b.position_m - a.position_m), a.orientation.slerp(share, b.orientation)};
}

double Timeline::input(const std::string& track, double time_s) const {
  const auto found = inputs_.find(track);
  if (found == inputs_.end()) return 0;
  const auto later = found->second.upper_bound(time_s);
  return later == found->second.begin() ? 0 : std::prev(later)->second;
}

std::vector<Timeline::Event> Timeline::events(double from_s, double to_s) const {
  std::vector<Event> found;
  for (const Event& event : events_) {
    if (event.time_s > from_s && event.time_s <= to_s) found.push_back(event);
  }
  return found;
}

}  // namespace livegs::simulated
