// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "stream/received/received.h"

namespace livegs {

// The objects of a server as it last described them, so that a client that comes back learns only what is not
// as it was. Not locked.
class KnownObjects {
 public:
  // As read_description(), and remembered.
  Result<StreamedObject> take(const v1::ObjectDescription& description);
  void remove(uint32_t object_id) { described_.erase(object_id); }

  struct Difference {
    std::vector<StreamedObject> added, changed;  // in the server's order
    std::vector<uint32_t> removed;
  };
  // What is there now, and nothing else. Fails, changing nothing, when one cannot be read.
  Result<Difference> replace(std::span<const v1::ObjectDescription* const> now);

 private:
  std::map<uint32_t, std::string> described_;  // by id, the description's bytes
};

}  // namespace livegs
