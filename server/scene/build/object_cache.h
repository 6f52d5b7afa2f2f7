// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "scene/build/build_object.h"
#include "scene/build/fragile_object.h"

namespace livegs {

// Built objects and cuts of earlier builds, so that a reset, an undo or a moved object costs no second build.
// The key of an object is everything that it is built from: its description without pose and velocities, its
// sidecar, the world's settings, and size and time of its file. Any thread. The oldest unused entries go when
// the kernels of all exceed kMaxKernels.
class ObjectCache {
 public:
  // As build_object().
  Result<BuiltObject> build(const v1::Object& object, const std::filesystem::path& folder, int index,
                            const std::string& field, const WorldSettings& settings,
                            const ObjectSidecar& sidecar);

  // A cut by everything that it is made from (FragileTask); null if there is none.
  std::shared_ptr<const FragileObject> cut(const std::string& key);
  // `inputs`: kept as long as the cut, because the key has their addresses.
  void keep_cut(const std::string& key, const FragileObject& cut,
                std::vector<std::shared_ptr<const void>> inputs);

  // Anything else that takes time to build, such as an environment; null if there is none.
  std::shared_ptr<const void> value(const std::string& key);
  // Replaces an earlier value.
  void keep_value(const std::string& key, std::shared_ptr<const void> value, size_t kernels);
  // Size and time of a file, or of every file of a folder: part of a key.
  static std::string stamp_of(const std::filesystem::path& path);

  // Larger: more memory, 240 bytes a kernel with third-order colour. Smaller: undo of an old step builds
  // again.
  static constexpr size_t kMaxKernels = 20'000'000;

 private:
  struct Entry {
    std::shared_ptr<const BuiltObject> object;    // or
    std::shared_ptr<const FragileObject> pieces;  // or
    std::shared_ptr<const void> value;
    std::vector<std::shared_ptr<const void>> inputs;
    size_t kernels = 0;
    std::list<std::string>::iterator age;
  };
  void keep(const std::string& key, Entry entry);  // mutex_ must not be held
  const Entry* find(const std::string& key);       // mutex_ must be held

  FormMemo forms_;
  std::mutex mutex_;  // guards the rest
  std::map<std::string, Entry> entries_;
  std::list<std::string> by_age_;  // keys, the last used first
  size_t kernels_ = 0;
};

}  // namespace livegs
