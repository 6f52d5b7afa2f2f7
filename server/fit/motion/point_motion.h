// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "fit/motion/surface_view.h"
#include "fit/point_paths.h"
#include "fit/simulation_journal.h"
#include "scene/scene.h"

namespace livegs {

// Simulates variants of a scene and records the paths of points of its surfaces. Any thread; several at once.
class PointMotion {
 public:
  // `folder` and `name`: as Scene::build. Points of a variant's objects are found by the names of the
  // objects. `journal`: may be null.
  PointMotion(std::filesystem::path folder, std::string name, std::vector<TrackedPoint> points,
              std::shared_ptr<BuildCache> cache, SimulationJournal* journal = nullptr);

  const std::vector<TrackedPoint>& points() const { return points_; }
  Result<Scene> build(const v1::Scene& file) const;
  // From the start of the scene to `end_s`. A result in the journal is taken from there.
  Result<PointPaths> simulate(const v1::Scene& file, double end_s) const;

 private:
  Result<PointPaths> simulate_now(const v1::Scene& file, double end_s) const;

  std::filesystem::path folder_;
  std::string name_;
  std::vector<TrackedPoint> points_;
  std::shared_ptr<BuildCache> cache_;
  SimulationJournal* journal_;
};

}  // namespace livegs
