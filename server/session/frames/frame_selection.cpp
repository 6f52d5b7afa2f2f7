// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/frames/frame_selection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "wire/stream_lag.h"

namespace livegs {
namespace {

constexpr double kMinDistance_m = 0.25;       // lower bound of the distance
constexpr double kDefaultDistance_m = 1;      // if the client sends no view
constexpr double kOutOfViewWeight = 1.0 / 8;  // relative to an object in view
// Factor on the reach of elastic objects: stretching moves kernels away from their nodes.
constexpr double kStretchAllowance = 2;

bool holds(std::span<const uint32_t> ids, uint32_t id) {
  return std::binary_search(ids.begin(), ids.end(), id);
}

const ObjectBall* find(std::span<const ObjectBall> balls, uint32_t id) {
  const auto at =
      std::find_if(balls.begin(), balls.end(), [&](const ObjectBall& ball) { return ball.object_id == id; });
  return at == balls.end() ? nullptr : &*at;
}

}  // namespace

ObjectBall ball_around(const ObjectDrivers& drivers, double reach_m) {
  Eigen::AlignedBox3d box;
  for (const Pose& pose : drivers.poses) box.extend(pose.position_m);
  for (const Eigen::Vector3f& position : drivers.positions_m) box.extend(position.cast<double>());
  if (box.isEmpty())
    return {drivers.object_id, Eigen::Vector3d::Zero(), std::numeric_limits<double>::infinity(),
            drivers.asleep};
  const double stretch = drivers.kind == DriverKind::Rigid ? 1 : kStretchAllowance;
  return {drivers.object_id, box.center(), 0.5 * box.diagonal().norm() + stretch * reach_m, drivers.asleep};
}

std::vector<uint32_t> culled(std::span<const ObjectBall> balls, const ClientView& who, uint64_t tick,
                             uint64_t tick_before) {
  std::vector<uint32_t> out;
  if (!who.view || who.uncongested) return out;
  for (const ObjectBall& ball : balls) {
    if (ball.asleep) continue;
    const uint64_t shift = uint64_t{4} * ball.object_id;
    const bool its_turn =
        (tick + shift) / kCulledUpdateInterval != (tick_before + shift) / kCulledUpdateInterval;
    if (!its_turn && !holds(who.held, ball.object_id) && !who.view->touches(ball.centre_m, ball.radius_m))
      out.push_back(ball.object_id);
  }
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<uint32_t> over_budget(const DriverFrame& frame, const StreamBaseline& baseline,
                                  std::span<const ObjectBall> balls, const ClientView& who,
                                  std::span<const uint32_t> out, double whole_bytes, double budget_bytes) {
  struct Waiting {
    uint32_t object_id;
    uint64_t integers;
    double weight;  // priority per byte
  };
  std::vector<Waiting> waiting;
  uint64_t integers = 0;
  for (const ObjectLag& lag : lag_behind(frame, baseline, precision_of(who.position_bits))) {
    if (holds(out, lag.object_id)) continue;
    const ObjectBall* const ball = find(balls, lag.object_id);
    const double radius_m = ball && std::isfinite(ball->radius_m) ? ball->radius_m : 0;
    double distance_m = kDefaultDistance_m, share = 1;
    if (who.view && ball) {
      distance_m = std::max(kMinDistance_m, (ball->centre_m - who.view->position_m).norm() - radius_m);
      share = who.view->touches(ball->centre_m, ball->radius_m) ? 1 : kOutOfViewWeight;
    }
    const double off_rad = (lag.moved_m + radius_m * lag.turned_rad) / distance_m;
    const double weight = holds(who.held, lag.object_id)
                              ? std::numeric_limits<double>::infinity()
                              : share * off_rad * static_cast<double>(lag.age_ticks) /
                                    static_cast<double>(std::max<uint64_t>(1, lag.integers));
    waiting.push_back({lag.object_id, lag.integers, weight});
    integers += lag.integers;
  }
  std::sort(waiting.begin(), waiting.end(), [](const Waiting& a, const Waiting& b) {
    return a.weight != b.weight ? a.weight > b.weight : a.object_id < b.object_id;
  });
  std::vector<uint32_t> left(out.begin(), out.end());
  const double bytes_per_integer = whole_bytes / static_cast<double>(std::max<uint64_t>(1, integers));
  double taken_bytes = 0;
  for (const Waiting& one : waiting) {
    if (taken_bytes >= budget_bytes)
      left.push_back(one.object_id);
    else
      taken_bytes += bytes_per_integer * static_cast<double>(one.integers);
  }
  std::sort(left.begin(), left.end());
  return left;
}

}  // namespace livegs
