// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "stream/received/received.h"

namespace livegs {

// The objects as the server last described them, so that a reconnecting client processes only the changes.
// Not thread-safe.
class KnownObjects {
 public:
  // Parses with read_description() and stores the description.
  Result<StreamedObject> take(const v1::ObjectDescription& description);
  void remove(uint32_t object_id) { described_.erase(object_id); }

  struct Difference {
    std::vector<StreamedObject> added, changed;  // in the server's order
    std::vector<uint32_t> removed;
  };
  // Replaces all descriptions and returns the difference. Fails without a change if one cannot be read.
  Result<Difference> replace(std::span<const v1::ObjectDescription* const> now);

 private:
  std::map<uint32_t, std::string> described_;  // by id, the description's bytes
};

}  // namespace livegs
