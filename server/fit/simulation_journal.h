// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "fit/point_paths.h"

namespace livegs {

// Results of the simulations of a fit, by scene and length, so that a fit that was interrupted repeats none
// of them. For one recording, one scene and one version of the program. Any thread.
class SimulationJournal {
 public:
  size_t size() const;
  std::optional<PointPaths> find(const std::string& key) const;
  // Empty paths are not kept, and nothing above 1 GiB.
  void add(const std::string& key, const PointPaths& paths);

  std::vector<std::byte> bytes() const;
  // Adds the results of bytes(). InvalidData if they are damaged.
  Result<void> read(std::span<const std::byte> bytes);

 private:
  mutable std::mutex mutex_;  // guards the members below
  std::map<std::string, PointPaths> results_;
  size_t bytes_ = 0;  // of bytes()
};

}  // namespace livegs
