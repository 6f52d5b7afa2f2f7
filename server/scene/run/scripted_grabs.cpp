// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/run/scripted_grabs.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/log.h"
#include "scene/values/csv_lines.h"

namespace livegs {
namespace {

constexpr double kMaxGripWeights = 20.0;  // maximum grip force relative to the object's weight
constexpr double kMinGripForce_n = 5.0;
constexpr double kGripLever_m = 0.2;        // lever arm that turns the grip force into its maximum torque
constexpr double kMaxGrabDistance_m = 0.1;  // the same reach as a live hand
constexpr size_t kMaxPathRows = 100'000;
constexpr uint64_t kMaxPathBytes = 64 << 20;
constexpr double kMaxPathCoordinate_m = 1000.0;

}  // namespace

World::Grip hand_grip(double mass_kg) {
  World::Grip grip;
  grip.max_force_n = std::max(kMinGripForce_n, kMaxGripWeights * 9.81 * mass_kg);
  grip.max_torque_n_m = kGripLever_m * grip.max_force_n;
  return grip;
}

World::Spring ray_spring(double mass_kg) {
  const double angular_frequency = 2.0 * M_PI * kSpringFrequency_hz;
  World::Spring spring;
  spring.stiffness_n_m = mass_kg * angular_frequency * angular_frequency;
  spring.max_force_n = std::max(kMinSpringForce_n, kMaxSpringWeights * 9.81 * mass_kg);
  return spring;
}

GrabPath::Motion GrabPath::at(double time_s) const {
  const auto after = std::upper_bound(times_s.begin(), times_s.end(), time_s);
  const Eigen::Vector3d still = Eigen::Vector3d::Zero();
  if (after == times_s.begin()) return {poses.front(), still, still};
  if (after == times_s.end()) return {poses.back(), still, still};
  const auto next = static_cast<size_t>(after - times_s.begin());
  const double span_s = times_s[next] - times_s[next - 1];
  const double share = (time_s - times_s[next - 1]) / span_s;
  const Pose& from = poses[next - 1];
  const Pose& to = poses[next];
  const Eigen::AngleAxisd turn(to.orientation * from.orientation.conjugate());
  const double angle = std::remainder(turn.angle(), 2.0 * M_PI);
  return {{from.position_m + share * (to.position_m - from.position_m),
           Eigen::Quaterniond(Eigen::AngleAxisd(share * angle, turn.axis())) * from.orientation},
          (to.position_m - from.position_m) / span_s,
          angle / span_s * turn.axis()};
}

Result<GrabPath> read_grab_path(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  GrabPath result;
  const CsvLayout layout{"time_s,x,y,z", "time_s,x,y,z,qw,qx,qy,qz", INFINITY, kMaxPathBytes};
  const auto take = [&](size_t line, std::span<const double> numbers) -> Result<void> {
    const std::string where = name + ": line " + std::to_string(line) + ": ";
    const double time_s = numbers[0];
    if (time_s < 0.0 || time_s > 1e6 || (!result.times_s.empty() && time_s <= result.times_s.back())) {
      return invalid_data(where + "time_s must increase, from 0 to 1e6");
    }
    Pose pose{{numbers[1], numbers[2], numbers[3]}, Eigen::Quaterniond::Identity()};
    if (numbers.size() == 8)
      pose.orientation = Eigen::Quaterniond(numbers[4], numbers[5], numbers[6], numbers[7]);
    if (pose.position_m.cwiseAbs().maxCoeff() > kMaxPathCoordinate_m) {
      return invalid_data(where + "position is beyond 1000 m");
    }
    if (std::abs(pose.orientation.norm() - 1.0) > 0.01)
      return invalid_data(where + "qw,qx,qy,qz is not a unit quaternion");
    pose.orientation.normalize();
    if (result.poses.size() == kMaxPathRows)
      return Error{ErrorCode::TooLarge, name + ": has too many rows; use at most 100000"};
    result.times_s.push_back(time_s);
    result.poses.push_back(pose);
    return {};
  };
  if (auto read = read_csv_lines(path, layout, take); !read) return read.error();
  if (result.poses.empty()) return invalid_data(name + ": contains no rows; give at least one");
  return result;
}

Result<void> ScriptedGrabs::begin(World& world, uint64_t grab_id, uint32_t object_id,
                                  const Eigen::Vector3d& rest_point_m, const GrabPath& path, double now_s) {
  const Pose hand{world.world_point(object_id, rest_point_m), path.poses.front().orientation};
  const auto met = world.nearest_of(object_id, hand.position_m);
  if (met && met->distance_m > kMaxGrabDistance_m) {
    log_warn(
        "object %u: the grab's point_m (%.3g, %.3g, %.3g) is %.3g m away from the object; give rest "
        "coordinates of the object in metres, the nearest point is (%.3g, %.3g, %.3g)",
        object_id, rest_point_m.x(), rest_point_m.y(), rest_point_m.z(), met->distance_m,
        met->rest_point_m.x(), met->rest_point_m.y(), met->rest_point_m.z());
  }
  const double mass_kg = met ? world.mass_at_kg(object_id, met->rest_point_m, met->piece) : 0.0;
  if (auto grabbed = world.grab(grab_id, object_id, hand, hand_grip(mass_kg)); !grabbed) return grabbed;
  running_.push_back({grab_id, path, now_s, std::nullopt});
  return {};
}

void ScriptedGrabs::begin_pull(World& world, uint64_t spring_id, uint32_t object_id,
                               const Eigen::Vector3d& rest_point_m, const GrabPath& path, double now_s) {
  World::Spring spring = ray_spring(world.mass_at_kg(object_id, rest_point_m));
  spring.rest_point_m = rest_point_m;
  spring.target_m = path.poses.front().position_m;
  world.set_spring(spring_id, object_id, spring);
  running_.push_back({spring_id, path, now_s, std::pair(object_id, spring)});
}

void ScriptedGrabs::move(World& world, double now_s) {
  std::erase_if(running_, [&](const Running& hand) {
    if (now_s - hand.start_s < hand.path.end_s()) return false;
    hand.pull ? world.clear_spring(hand.id) : world.release_grab(hand.id);
    return true;
  });
  for (Running& hand : running_) {
    const GrabPath::Motion motion = hand.path.at(now_s - hand.start_s);
    if (hand.pull) {
      auto& [object_id, spring] = *hand.pull;
      spring.target_m = motion.pose.position_m;
      world.set_spring(hand.id, object_id, spring);
    } else {
      world.move_grab(hand.id, motion.pose, motion.velocity_m_s, motion.spin_rad_s);
    }
  }
}

}  // namespace livegs
