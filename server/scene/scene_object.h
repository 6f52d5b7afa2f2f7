// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gaussian/gaussian_asset.h"
#include "livegs/v1/scene.pb.h"
#include "physics/elastic_body.h"
#include "skin/rest_body.h"

namespace livegs {

struct ObjectFacts;  // analysis/estimate.h
struct BrokenAsset;  // scene/fragile_object.h

// How a fragile object breaks.
struct Fragility {
  uint32_t pieces = 0;           // it can break into; 0 while they are being made, or when it cannot be cut
  uint32_t bodies = 1;           // it is in now
  double break_impulse_n_s = 0;  // of the whole
  double drop_height_m =
      0;  // a free fall from here onto a hard floor that does not bounce back more than it breaks it
};

// One thing that is drawn. The environment is one too: it is `environment`, never moves and is never touched.
struct SceneObject {
  uint32_t id = 0;
  std::string name;
  bool environment = false;
  std::shared_ptr<const GaussianAsset>
      asset;  // shared with the service that sends it; broken->asset once it is broken
  std::shared_ptr<const BrokenAsset> broken;  // of a fragile object, once prepared
  std::optional<Fragility> fragility;         // of a fragile object
  RestBody rest;
  v1::PhysicalParameters physics;      // with the source of each value
  v1::Physics written;                 // the author's words in the scene file
  std::filesystem::path physics_file;  // its sidecar, there or not (sidecar_paths.h); empty: it has none
  std::shared_ptr<const v1::PhysicsFile>
      sidecar;  // as it was read when the object was built; null without one
  double mass_kg = 0;
  std::vector<Eigen::Vector3d> rest_particles_m;  // of an elastic body, object frame; empty otherwise
  std::optional<ElasticAccuracy> elastic;         // of an elastic body, as it was built or last changed
  std::string surface_note;           // how its surface was repaired or replaced; empty when it was not
  std::vector<std::string> warnings;  // found while it was built
  std::shared_ptr<const ObjectFacts>
      facts;  // what the analysis looked at; empty for the environment and balls

  // What a person should know before it runs, a line each, without the object's name.
  std::vector<std::string> all_warnings() const;
};

struct SceneOptions {
  std::optional<double> rate_hz;  // override the scene's
  std::optional<int> substeps;
  ElasticSolver elastic_solver = ElasticSolver::Cells;
  bool sleep = true;
  uint64_t seed = 1;            // of the cuts of fragile objects
  bool wait_for_pieces = true;  // before load() returns; else they break only once their pieces are made
  uint32_t first_object_id =
      1;                    // of objects and balls: a scene that takes another's place has none of its ids
  bool cut_fragile = true;  // false: nothing breaks, for those who only look
  // By object, in place of the sidecars on disk; an object that is not in it has none. Null: those on disk.
  std::shared_ptr<const std::map<std::string, v1::PhysicsFile>> sidecars;
  // Called for each object as it is built, before the rest is: without id and rest. On any thread, one at a
  // time.
  std::function<void(const SceneObject&)> built;
  bool recorded_cuts =
      false;  // pieces that load() did not wait for come by take_cuts() alone, to simulate a run again
};

}  // namespace livegs
