// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "core/result.h"
#include "session/assets/client_store.h"
#include "store/object_store.h"

namespace livegs {

// The files of a scene that come from a store (publish_scene.h), each verified by its hash. Files that were
// fetched into a temporary folder are removed with this object.
class StoredScene {
 public:
  // `scene`: the address of a published NAME.scene.json, whose files are fetched into a temporary folder; or
  // a local path, whose missing files are fetched to their places. `place`: the store of the objects; empty:
  // the folder of the address. Errors name the object of the store, or the file. A request to stop ends the
  // fetch with an error and removes the temporary folder.
  static Result<StoredScene> fetch(const std::string& scene, const std::string& place,
                                   std::stop_token stop = {});
  StoredScene(StoredScene&& other) noexcept;
  StoredScene& operator=(StoredScene&&) = delete;
  ~StoredScene();

  const std::filesystem::path& path() const { return path_; }  // of the scene, local
  const std::string& list_hash() const { return list_hash_; }  // of NAME.files.json: of all files
  // Whether the store at the address of the scene still has this list.
  Result<bool> is_current(ObjectStore& store) const;
  // The assets that clients find in the store.
  const std::vector<ClientStore::Asset>& assets() const { return assets_; }

 private:
  StoredScene() = default;
  std::filesystem::path path_, temporary_;
  std::string list_name_, list_hash_;
  std::vector<ClientStore::Asset> assets_;
};

}  // namespace livegs
