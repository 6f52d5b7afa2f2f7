// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "skin/driver_frame.h"

namespace livegs {

// Of an object's drivers as they were simulated, to the last bit; proto/recording_format.md, "A hash".
uint32_t driver_hash(const ObjectDrivers& drivers);

struct ObjectHash {
  uint32_t object_id = 0;
  uint32_t hash = 0;
  bool operator==(const ObjectHash&) const = default;
};

// The hashes of a run, tick by tick. Not locked.
class DriverHashes {
 public:
  // Of the frame's objects those whose hash is not as it was, by ascending id. An object that went is
  // forgotten.
  std::vector<ObjectHash> take(const DriverFrame& frame);

 private:
  std::map<uint32_t, uint32_t> hashes_;
};

}  // namespace livegs
