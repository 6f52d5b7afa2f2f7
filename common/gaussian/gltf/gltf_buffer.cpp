// SPDX-License-Identifier: Apache-2.0
// The glTF 2.0 specification, section 3.6.
#include "gaussian/gltf_buffer.h"

#include <algorithm>

namespace livegs {
namespace {

constexpr int kUnsignedByte = 5121, kUnsignedInt = 5125, kFloat = 5126;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;

const char* type_of(size_t components) {
  return components == 1 ? "SCALAR" : components == 3 ? "VEC3" : "VEC4";
}

}  // namespace

size_t GltfBuffer::add_view(std::span<const std::byte> bytes, Use use) {
  bytes_.resize((bytes_.size() + 3) / 4 * 4);
  nlohmann::json view{{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes.size()}};
  if (use == Use::Vertices) view["target"] = kArrayBuffer;
  if (use == Use::Indices) view["target"] = kElementArrayBuffer;
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  views_.push_back(std::move(view));
  return views_.size() - 1;
}

size_t GltfBuffer::add_accessor(size_t view, size_t count, size_t components, int component_type) {
  accessors_.push_back({{"bufferView", view},
                        {"componentType", component_type},
                        {"count", count},
                        {"type", type_of(components)}});
  return accessors_.size() - 1;
}

size_t GltfBuffer::add_floats(std::span<const float> values, size_t components, Bounds bounds, Use use) {
  const size_t view = add_view(std::as_bytes(values), use);
  const size_t accessor = add_accessor(view, values.size() / components, components, kFloat);
  if (bounds == Bounds::None || values.empty()) return accessor;
  std::vector<double> low(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(components)),
      high = low;
  for (size_t i = 0; i < values.size(); ++i) {
    const auto value = static_cast<double>(values[i]);
    low[i % components] = std::min(low[i % components], value);
    high[i % components] = std::max(high[i % components], value);
  }
  accessors_[accessor]["min"] = low;
  accessors_[accessor]["max"] = high;
  return accessor;
}

size_t GltfBuffer::add_indices(std::span<const uint32_t> values, Use use) {
  return add_accessor(add_view(std::as_bytes(values), use), values.size(), 1, kUnsignedInt);
}

size_t GltfBuffer::add_colours(std::span<const uint8_t> values) {
  const size_t view = add_view(std::as_bytes(values), Use::Vertices);
  const size_t accessor = add_accessor(view, values.size() / 4, 4, kUnsignedByte);
  accessors_[accessor]["normalized"] = true;
  return accessor;
}

size_t GltfBuffer::add_empty(size_t count, size_t components, const Eigen::Vector3f* low,
                             const Eigen::Vector3f* high) {
  nlohmann::json accessor{{"componentType", kFloat}, {"count", count}, {"type", type_of(components)}};
  if (low && high) {
    accessor["min"] = {low->x(), low->y(), low->z()};
    accessor["max"] = {high->x(), high->y(), high->z()};
  }
  accessors_.push_back(std::move(accessor));
  return accessors_.size() - 1;
}

}  // namespace livegs
