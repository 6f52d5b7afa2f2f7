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

// A source of scene items, in order: a live stream or a recording.
class ItemSource {
 public:
  virtual ~ItemSource() = default;
  // Waits for the next item. Nothing at the end.
  virtual std::optional<StreamItem> take() = 0;
};

}  // namespace livegs
