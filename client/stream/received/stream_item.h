// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <variant>

#include "stream/received/received.h"

namespace livegs {

struct ObjectAdded {
  StreamedObject object;
};
struct ObjectChanged {
  StreamedObject object;
};
struct ObjectRemoved {
  uint32_t object_id = 0;
};
using StreamItem = std::variant<ReceivedFrame, ObjectAdded, ObjectChanged, ObjectRemoved, ResumedSession>;

// Where what there is to see comes from, in order: a stream, or a recording.
class ItemSource {
 public:
  virtual ~ItemSource() = default;
  // The next item, waiting for one. Nothing when there is no more.
  virtual std::optional<StreamItem> take() = 0;
};

}  // namespace livegs
