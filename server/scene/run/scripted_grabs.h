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

// Returns the grip of a user's hand for an object of this mass. It lifts and swings the object, and can be
// pulled off.
World::Grip hand_grip(double mass_kg);

// Natural frequency of the spring of a ray, for an object of any mass. The object lags the hand by g / (2 pi
// f)^2, 28 mm at 3 Hz. A higher value follows the hand more closely and pulls more abruptly.
inline constexpr double kSpringFrequency_hz = 3.0;
// Maximum force of the spring relative to the object's weight: enough to lift and swing it. The force limit
// is at least kMinSpringForce_n, about the force of a finger on a doorbell.
inline constexpr double kMaxSpringWeights = 6.0;
inline constexpr double kMinSpringForce_n = 2.0;
// Returns the spring of a ray for an object of this mass. The stiffness is constant during the pull.
World::Spring ray_spring(double mass_kg);

// Path of a hand: poses at increasing times with linear interpolation. The hand opens at the last pose.
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

// Reads a CSV file with the header time_s,x,y,z or time_s,x,y,z,qw,qx,qy,qz. Errors name the file, the line
// and the problem.
Result<GrabPath> read_grab_path(const std::filesystem::path& path);

// Runs the grab and pull events of a scene file.
class ScriptedGrabs {
 public:
  // Closes a hand on a point of an object. `grab_id` is chosen by the caller and must be unique.
  Result<void> begin(World& world, uint64_t grab_id, uint32_t object_id, const Eigen::Vector3d& rest_point_m,
                     const GrabPath& path, double now_s);
  // Attaches a ray's spring instead. `spring_id` is chosen by the caller and must be unique.
  void begin_pull(World& world, uint64_t spring_id, uint32_t object_id, const Eigen::Vector3d& rest_point_m,
                  const GrabPath& path, double now_s);
  // Moves the hands to their positions at `now_s`, the start of a tick. Opens hands whose path has ended.
  void move(World& world, double now_s);

 private:
  struct Running {
    uint64_t id;
    GrabPath path;
    double start_s;
    // Set for a pull: the object and the spring; else a grab.
    std::optional<std::pair<uint32_t, World::Spring>> pull;
  };
  std::vector<Running> running_;
};

}  // namespace livegs
