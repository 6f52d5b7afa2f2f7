// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "physics/world.h"

namespace livegs {

// How firmly a hand of a person holds an object of this mass: it lifts and swings it, and can be pulled off.
World::Grip hand_grip(double mass_kg);

// A held point follows like a mass on a spring of this frequency, whatever the object weighs: at 3 Hz it
// trails the hand by 28 mm under its own weight, (2 pi f)^2 = 355 / s^2 against 9.81 m/s^2.
inline constexpr double kSpringFrequency_hz = 3.0;
// The spring lifts an object and swings it, but pulls with no more than this many times its weight, and at
// least with kMinSpringForce_n, which is what a finger presses a doorbell with.
inline constexpr double kMaxSpringWeights = 6.0;
inline constexpr double kMinSpringForce_n = 2.0;
// Of a ray that draws an object of this mass: a stiffness that stays as it is while it pulls.
World::Spring ray_spring(double mass_kg);

// Where a hand goes: poses at rising times, straight between them. At its last row it opens.
struct GrabPath {
  std::vector<double> times_s;
  std::vector<Pose> poses;

  double end_s() const { return times_s.back(); }
  struct Motion {
    Pose pose;
    Eigen::Vector3d velocity_m_s, spin_rad_s;
  };
  Motion at(double time_s) const;
};

// CSV with the header time_s,x,y,z or time_s,x,y,z,qw,qx,qy,qz. Errors name the file, the line and what is
// wrong.
Result<GrabPath> read_grab_path(const std::filesystem::path& path);

// The hands of a scene file's grab and pull events.
class ScriptedGrabs {
 public:
  // Closes a hand on the point of an object. `grab_id` is the caller's and unique.
  Result<void> begin(World& world, uint64_t grab_id, uint32_t object_id, const Eigen::Vector3d& rest_point_m,
                     const GrabPath& path, double now_s);
  // A ray takes hold of it instead. `spring_id` is the caller's and unique.
  void begin_pull(World& world, uint64_t spring_id, uint32_t object_id, const Eigen::Vector3d& rest_point_m,
                  const GrabPath& path, double now_s);
  // Moves hands to where they are at `now_s`, the start of a tick, and opens those whose path has ended.
  void move(World& world, double now_s);

 private:
  struct Running {
    uint64_t id;
    GrabPath path;
    double start_s;
    std::optional<std::pair<uint32_t, World::Spring>> pull;  // of which object; a grab otherwise
  };
  std::vector<Running> running_;
};

}  // namespace livegs
