// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "analysis/analyze_scene.h"
#include "core/result.h"
#include "scene/build/build_object.h"
#include "scene/scene.h"

namespace livegs {

// Snapshot of a scene for an analysis: its objects, their facts, and their kernels at the initial poses.
// Created on the thread that owns the scene. Afterwards usable on any thread, independent of the scene.
class SceneAnalysis {
 public:
  // Takes the snapshot. Without kernels, no views can be drawn and no large data is copied.
  static Result<SceneAnalysis> of(const Scene& scene, bool with_kernels = true);

  // Returns the objects whose behaviour the scene leaves open (AUTO), in the scene's order. If names are
  // given, returns those objects instead. NotFound names an object that does not exist or cannot be analysed.
  Result<std::vector<AnalysisTarget>> targets(const std::vector<std::string>& names = {}) const;
  struct Object {
    std::string name;     // in the scene
    v1::Physics written;  // values given in the scene file
    BodyTypeLock built;   // current body type
    std::filesystem::path physics_file;
    AnalysisTarget target;
    v1::PhysicalParameters known;  // includes the sidecar's answer, if it exists
  };
  const std::vector<Object>& objects() const;
  // A snapshot without the objects of these names and with newly built ones, whose ids are given in order
  // from `first_id` on.
  Result<SceneAnalysis> changed(const std::vector<std::string>& gone, std::span<const BuiltObject> fresh,
                                uint32_t first_id) const;
  // Returns all objects except the targets, with their parameters at the time of the snapshot. Without
  // kernels, all objects are at the origin.
  std::vector<AnalysisNeighbour> neighbours(std::span<const AnalysisTarget> targets) const;

  // Returns a function that draws an object from several directions: the outlined object in the scene, and
  // the object alone. May outlive the snapshot.
  TargetViews views() const;

 private:
  struct Snapshot;
  std::shared_ptr<const Snapshot> snapshot_;  // shared with view functions in use
};

// Returns the facts of an object under the name given in `file`; if there is none, under its own name.
std::shared_ptr<const ObjectFacts> facts_by_name(const SceneAnalysis::Object& object,
                                                 const v1::PhysicsFile& file);

// Merges the sources of an object's parameters: the offline estimate, the sidecar, and the values given in
// the scene file. `note` as in with_physics_file.
Result<v1::PhysicalParameters> layered_physics(const v1::PhysicsFile& file, const v1::Physics& written,
                                               const ObjectFacts& facts, std::string& note);
// Same as layered_physics without the answer in the sidecar. A new answer is compared with this
// (AnalysisTarget::offline), so that a repeated analysis gives the same result as the first.
Result<v1::PhysicalParameters> offline_physics(const v1::PhysicsFile& file, const v1::Physics& written,
                                               const ObjectFacts& facts);

}  // namespace livegs
