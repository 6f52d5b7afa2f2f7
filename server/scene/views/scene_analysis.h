// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "analysis/analyze_scene.h"
#include "core/result.h"
#include "scene/scene.h"

namespace livegs {

// What an analysis needs to know of a scene: its objects when this was made, their facts, and their kernels
// as they stood at the start, to draw. Made on the thread that owns the scene; afterwards any thread,
// whatever becomes of the scene.
class SceneAnalysis {
 public:
  // Without kernels no views can be made, and nothing large is copied.
  static Result<SceneAnalysis> of(const Scene& scene, bool with_kernels = true);

  // Objects whose behaviour the scene leaves open (AUTO), in the scene's order; with names: those, whatever
  // they are. NotFound names one that is not there or cannot be analysed.
  Result<std::vector<AnalysisTarget>> targets(const std::vector<std::string>& names = {}) const;
  struct Object {
    std::string name;     // in the scene
    v1::Physics written;  // its author's words
    BodyTypeLock built;   // as it runs
    std::filesystem::path physics_file;
    AnalysisTarget target;
    v1::PhysicalParameters known;  // with the sidecar's answer in it, if there is one
  };
  const std::vector<Object>& objects() const;
  // All objects but the targets, with what they had when this was made. Without kernels, all stand in the
  // origin.
  std::vector<AnalysisNeighbour> neighbours(std::span<const AnalysisTarget> targets) const;

  // Pictures of an object from around it: the scene with its outline, and the object alone. Outlives this.
  TargetViews views() const;

 private:
  struct Snapshot;
  std::shared_ptr<const Snapshot> snapshot_;  // shared with the views that are being made
};

// What was measured of an object under the name that `file` gives it; its own where that gives none.
std::shared_ptr<const ObjectFacts> facts_by_name(const SceneAnalysis::Object& object,
                                                 const v1::PhysicsFile& file);

// The layers of what is known of an object: the offline estimate, what its sidecar holds, the scene author's
// words. `note` as of with_physics_file.
Result<v1::PhysicalParameters> layered_physics(const v1::PhysicsFile& file, const v1::Physics& written,
                                               const ObjectFacts& facts, std::string& note);
// The same without the answer that the sidecar holds: what a new answer is weighed against
// (AnalysisTarget::offline), so that an object which is analysed twice comes out as if it were the first
// time.
Result<v1::PhysicalParameters> offline_physics(const v1::PhysicsFile& file, const v1::Physics& written,
                                               const ObjectFacts& facts);

}  // namespace livegs
