// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "fit/motion/surface_view.h"
#include "scene/scene.h"

namespace livegs {

// Positions of points at every tick of a simulation, world frame.
struct PointPaths {
  double rate_hz = 0;
  size_t points = 0;
  std::vector<Eigen::Vector3f> positions_m;  // tick-major

  size_t ticks() const { return points == 0 ? 0 : positions_m.size() / points; }
  // Position at a time, by cubic interpolation between ticks (Catmull and Rom 1974). Its error is below 1 %
  // of the amplitude at a ninth of the rate. Times are clamped to the first and the last tick.
  Eigen::Vector3d at(size_t point, double time_s) const;
};

// Simulates variants of a scene and records the paths of points of its surfaces. Any thread; several at once.
class PointMotion {
 public:
  // `folder` and `name`: as Scene::build. Points of a variant's objects are found by the names of the
  // objects.
  PointMotion(std::filesystem::path folder, std::string name, std::vector<TrackedPoint> points,
              std::shared_ptr<BuildCache> cache);

  const std::vector<TrackedPoint>& points() const { return points_; }
  Result<Scene> build(const v1::Scene& file) const;
  // From the start of the scene to `end_s`.
  Result<PointPaths> simulate(const v1::Scene& file, double end_s) const;

 private:
  std::filesystem::path folder_;
  std::string name_;
  std::vector<TrackedPoint> points_;
  std::shared_ptr<BuildCache> cache_;
};

}  // namespace livegs
