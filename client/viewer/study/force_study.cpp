// SPDX-License-Identifier: Apache-2.0
#include "viewer/study/force_study.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include "viewer/panels/quantity_text.h"

namespace livegs {
namespace {

constexpr double kRadian_deg = std::numbers::pi / 180;
constexpr double kMaxForceDuration_s = 60;  // scene.cpp has the same limit

// "1 second", "0.3 seconds".
std::string in_words(double value, const std::string& unit) {
  const std::string number = quantity_text(value, Unit::None);
  return number + " " + unit + (number == "1" ? "" : "s");
}

}  // namespace

Eigen::Vector3d direction_of(double yaw_deg, double pitch_deg) {
  const double yaw = kRadian_deg * yaw_deg, pitch = kRadian_deg * pitch_deg;
  return {std::cos(pitch) * std::sin(yaw), std::sin(pitch), std::cos(pitch) * std::cos(yaw)};
}

void ForceStudy::choose_force(const Eigen::Vector3d& force_n, double duration_s) {
  const double size = force_n.norm();
  chosen_ = {size, duration_s, std::atan2(force_n.x(), force_n.z()) / kRadian_deg,
             size > 0 ? std::asin(std::clamp(force_n.y() / size, -1.0, 1.0)) / kRadian_deg : 0};
}

Eigen::Vector3d ForceStudy::force_n() const {
  return chosen_.size_n * direction_of(chosen_.yaw_deg, chosen_.pitch_deg);
}

std::string ForceStudy::sentence() const { return sentence_of({this, 1}); }

std::string sentence_of(std::span<const ForceStudy> studies) {
  std::vector<std::pair<std::string, int>> forces;  // what, at how many points
  for (const ForceStudy& study : studies) {
    const std::string what = "a force of " + in_words(study.force_n().norm(), "newton") + " to the " +
                             (study.target() ? study.target()->object : "object") + " for " +
                             in_words(study.duration_s(), "second");
    const auto same =
        std::find_if(forces.begin(), forces.end(), [&](const auto& one) { return one.first == what; });
    same == forces.end() ? void(forces.emplace_back(what, 1)) : void(++same->second);
  }
  std::string sentence = "Apply ";
  for (size_t i = 0; i < forces.size(); ++i) {
    sentence += (i == 0 ? "" : i + 1 < forces.size() ? ", " : ", and ") + forces[i].first;
    if (forces[i].second > 1) sentence += " at " + std::to_string(forces[i].second) + " points";
  }
  return sentence + ".";
}

v1::Event::Force ForceStudy::message() const {
  v1::Event::Force force;
  force.set_object(target_->object);
  const Eigen::Vector3d along = force_n();
  for (int i = 0; i < 3; ++i) force.add_point_m(target_->rest_point_m[i]);
  for (int i = 0; i < 3; ++i) force.add_force_n(along[i]);
  force.set_duration_s(chosen_.duration_s);
  return force;
}

ForcePanel ForceStudy::shown(std::string progress) const {
  ForcePanel panel;
  panel.ready = target_.has_value();
  panel.target = target_ ? "On the " + target_->object + ", at the clicked point"
                         : "Click an object in the picture to choose a point.";
  panel.size_n = chosen_.size_n;
  panel.duration_s = chosen_.duration_s;
  panel.yaw_deg = chosen_.yaw_deg;
  panel.pitch_deg = chosen_.pitch_deg;
  panel.sentence = sentence();
  panel.progress = std::move(progress);
  return panel;
}

Result<v1::Event::Force> parse_force(const std::string& text) {
  const auto refuse = [&] {
    return invalid_argument("--force " + text +
                            ": is not OBJECT:X,Y,Z:FX,FY,FZ:SECONDS, as in pillow:0,0.1,0:0,12,0:0.5");
  };
  // The numbers are last, since a name may contain a colon.
  size_t at = text.size();
  for (int part = 0; part < 3; ++part) {
    at = at == 0 ? std::string::npos : text.rfind(':', at - 1);
    if (at == std::string::npos) return refuse();
  }
  double p[3], f[3], seconds = 0;
  int used = 0;
  const std::string numbers = text.substr(at + 1);
  if (std::sscanf(numbers.c_str(), "%lf,%lf,%lf:%lf,%lf,%lf:%lf%n", &p[0], &p[1], &p[2], &f[0], &f[1], &f[2],
                  &seconds, &used) != 7 ||
      used != static_cast<int>(numbers.size()) || at == 0) {
    return refuse();
  }
  const auto is_finite = [](double number) { return std::isfinite(number); };
  if (!std::all_of(p, p + 3, is_finite) || !std::all_of(f, f + 3, is_finite))
    return invalid_argument("--force " + text +
                            ": the point or the force is not finite; give metres and newtons");
  if (!(seconds > 0 && seconds <= kMaxForceDuration_s))
    return invalid_argument("--force " + text + ": SECONDS is out of range; give more than 0 and at most 60");
  v1::Event::Force force;
  force.set_object(text.substr(0, at));
  for (double number : p) force.add_point_m(number);
  for (double number : f) force.add_force_n(number);
  force.set_duration_s(seconds);
  return force;
}

}  // namespace livegs
