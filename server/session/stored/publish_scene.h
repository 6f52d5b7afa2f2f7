// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "core/result.h"
#include "store/object_store.h"

namespace livegs {

// Result of publish_scene().
struct PublishedScene {
  std::string file;  // name of the scene file in the store
  size_t files = 0, assets = 0;
  uint64_t written_bytes = 0;  // of objects that the store did not have
  uint64_t read_bytes = 0;     // of objects that were verified
  size_t replaced = 0;         // objects of the right size with wrong bytes
};

struct PublishOptions {
  // Reads every object that the store has, and replaces those with wrong bytes. Otherwise, an object of the
  // right size counts as right.
  bool verify = false;
  // Called after each object, in the calling thread.
  std::function<void(const PublishedScene& so_far)> progress;
  // Called with the hash of the list before it is written; an error ends the publication.
  std::function<Result<void>(const std::string& list_hash)> before_list;
};

// Stores a scene so that servers start from the store alone and clients fetch its assets there. Objects:
// - SHA256: a file of the scene, named by the hash of its bytes.
// - assets/HASH: an asset for clients and, by another hash, for browsers (proto/asset_format.md, "Stores").
// - NAME.scene.json: the scene file.
// - NAME.files.json: the list of them all (livegs.v1.StoredScene), written last.
//
// `path`: a scene file, a folder of assets or one asset, built here once for the assets of shapes and pieces.
// Objects that the store has are not written again. No program removes objects from a store; a scene's own
// objects are those in its list. A server's copies in memory are dropped by AssetStore::drop_unused().
Result<PublishedScene> publish_scene(const std::filesystem::path& path, ObjectStore& store,
                                     const PublishOptions& options = {});

}  // namespace livegs
