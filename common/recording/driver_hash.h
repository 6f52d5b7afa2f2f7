// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "skin/driver_frame.h"

namespace livegs {

// Hash of the exact simulated drivers of an object. See proto/recording_format.md, "A hash".
uint32_t driver_hash(const ObjectDrivers& drivers);

struct ObjectHash {
  uint32_t object_id = 0;
  uint32_t hash = 0;
  bool operator==(const ObjectHash&) const = default;
};

// Driver hashes of a run, tick by tick. Not thread-safe.
class DriverHashes {
 public:
  // Returns the hashes of the objects whose hash has changed, by ascending id. Removed objects are dropped.
  std::vector<ObjectHash> take(const DriverFrame& frame);

 private:
  std::map<uint32_t, uint32_t> hashes_;
};

}  // namespace livegs
