// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace livegs {

// Results of earlier builds by everything that they are made from: objects, their surfaces and shapes, cuts
// and environments. A reset, an undo, another material or an equal object then costs no second build. Any
// thread.
class BuildCache {
 public:
  // Larger: more memory, 240 bytes a kernel with third-order colour. Smaller: undo of an old step builds
  // again.
  static constexpr size_t kMaxBytes = size_t{4800} << 20;

  explicit BuildCache(size_t max_bytes = kMaxBytes) : max_bytes_(max_bytes) {}

  // The value that was kept by this key; null if there is none. A key stands for one type.
  template <typename Value>
  std::shared_ptr<const Value> find(const std::string& key) {
    return std::static_pointer_cast<const Value>(found(key));
  }
  // Replaces an earlier value. The values that were not used for the longest time go when all take more than
  // the limit. `bytes`: of memory, about.
  void keep(const std::string& key, std::shared_ptr<const void> value, size_t bytes);
  // The value of a key, from make() if there is none. Threads that need it at once may each make it, with the
  // same result. `bytes_of`: of a value.
  template <typename Value, typename Make, typename Bytes>
  std::shared_ptr<const Value> value(const std::string& key, const Make& make, const Bytes& bytes_of) {
    if (auto known = find<Value>(key)) return known;
    auto made = std::make_shared<const Value>(make());
    keep(key, made, bytes_of(*made));
    return made;
  }

  static constexpr size_t kKernelBytes = 240;
  // Size and time of a file, or of every file of a folder: part of a key.
  static std::string stamp_of(const std::filesystem::path& path);

 private:
  struct Entry {
    std::shared_ptr<const void> value;
    size_t bytes = 0;
    std::list<std::string>::iterator age;
  };
  std::shared_ptr<const void> found(const std::string& key);

  const size_t max_bytes_;
  std::mutex mutex_;  // guards the rest
  std::map<std::string, Entry> entries_;
  std::list<std::string> by_age_;  // keys, the last used first
  size_t bytes_ = 0;
};

}  // namespace livegs
