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
class BuildCache;    // scene/build/build_cache.h
struct BrokenAsset;  // scene/build/fragile_object.h

// Fracture state of a fragile object.
struct Fragility {
  uint32_t pieces = 0;           // number of precut pieces; 0 until they are ready, or if it cannot be cut
  uint32_t bodies = 1;           // number of bodies it currently consists of
  double break_impulse_n_s = 0;  // impulse that breaks the unbroken object
  double drop_height_m = 0;      // free fall onto a hard floor that breaks it, with its restitution
};

// An object that is drawn. The environment is one too: `environment` is set, it never moves and has no
// contacts.
struct SceneObject {
  uint32_t id = 0;
  std::string name;
  bool environment = false;
  bool hidden = false;  // not drawn
  double lift_m = 0;    // of the body's frame above the object's pose, along the object's +y
  std::string label;    // given in the scene file; may be empty
  // Shared with the service that sends it; broken->asset after the object broke.
  std::shared_ptr<const GaussianAsset> asset;
  std::shared_ptr<const BrokenAsset> broken;  // fragile objects only, once prepared
  std::optional<Fragility> fragility;         // fragile objects only
  RestBody rest;
  v1::PhysicalParameters physics;  // includes the source of each value
  // Parts of the body; those of `physics` may change before the next build.
  google::protobuf::RepeatedPtrField<v1::MaterialPart> built_parts;
  v1::Physics written;  // values given in the scene file
  // Path of its sidecar, which may not exist (sidecar_paths.h); empty: none.
  std::filesystem::path physics_file;
  // Contents of the sidecar when the object was built; null if there was none.
  std::shared_ptr<const v1::PhysicsFile> sidecar;
  double mass_kg = 0;
  std::vector<Eigen::Vector3d> rest_particles_m;  // elastic bodies only, object frame; else empty
  std::optional<ElasticAccuracy> elastic;         // elastic bodies only, as built or last changed
  std::string surface_note;           // how the surface was repaired or replaced; empty if it was not
  std::vector<std::string> warnings;  // found while it was built
  // Rigid objects too heavy for a lighter one below; empty: none. Follows later edits of the scene.
  std::string mass_ratio_warning;
  // Measurements used by the analysis; null for the environment and balls.
  std::shared_ptr<const ObjectFacts> facts;

  // Returns all warnings about the object, one line each, without its name.
  std::vector<std::string> all_warnings() const;
};

struct SceneOptions {
  std::optional<double> rate_hz;  // overrides the scene's value
  std::optional<int> substeps;
  ElasticBodyFactory make_elastic = make_elastic_body;  // one of elastic_solvers()
  bool sleep = true;
  uint64_t seed = 1;  // seed of the cuts of fragile objects
  bool drop = false;  // objects of a folder fall from a small height instead of standing
  // load() waits until all pieces are ready; false: objects can break only once they are.
  bool wait_for_pieces = true;
  // First id of objects and balls. A scene that replaces another one starts above the ids of that scene.
  uint32_t first_object_id = 1;
  bool cut_fragile = true;  // false: no object breaks, for read-only uses
  // Sidecars by object, used in place of those on disk; an object without an entry has none. Null: use the
  // disk.
  std::shared_ptr<const std::map<std::string, v1::PhysicsFile>> sidecars;
  // Called after each object is built, before the whole scene is. Id and rest are not set. Any thread; calls
  // are serialised.
  std::function<void(const SceneObject&)> built;
  std::shared_ptr<BuildCache> cache;  // of built objects; null: everything is built
  // Simulates a recorded run again: cuts that load() did not wait for are applied by take_cuts() only.
  bool recorded_cuts = false;
};

}  // namespace livegs
