// SPDX-License-Identifier: Apache-2.0
#include "stream/received/known_objects.h"

#include "stream/received/object_description.h"

namespace livegs {

Result<StreamedObject> KnownObjects::take(const v1::ObjectDescription& description) {
  auto object = read_description(description);
  if (object) described_[object->id] = description.SerializeAsString();
  return object;
}

Result<KnownObjects::Difference> KnownObjects::replace(std::span<const v1::ObjectDescription* const> now) {
  Difference difference;
  std::map<uint32_t, std::string> described;
  for (const v1::ObjectDescription* description : now) {
    std::string bytes = description->SerializeAsString();
    const auto known = described_.find(description->object_id());
    if (known == described_.end() || known->second != bytes) {
      auto object = read_description(*description);
      if (!object) return object.error();
      (known == described_.end() ? difference.added : difference.changed).push_back(std::move(*object));
    }
    if (!described.emplace(description->object_id(), std::move(bytes)).second)
      return invalid_data("object \"" + description->name() + "\": its id belongs to another object");
  }
  for (const auto& [id, bytes] : described_) {
    if (!described.contains(id)) difference.removed.push_back(id);
  }
  described_ = std::move(described);
  return difference;
}

}  // namespace livegs
