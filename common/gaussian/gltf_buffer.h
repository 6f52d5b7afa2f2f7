// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

namespace livegs {

// Collects the numbers of a glTF document in one buffer. Each call adds a buffer view, which begins at a
// multiple of four bytes, and an accessor for all of it, and returns the index of the accessor.
class GltfBuffer {
 public:
  enum class Bounds { None, Stated };  // `min` and `max`: required for positions and for times
  enum class Use { Values, Vertices, Indices };

  // `components`: 1, 3 or 4 floats an element.
  size_t add_floats(std::span<const float> values, size_t components, Bounds bounds, Use use);
  size_t add_indices(std::span<const uint32_t> values, Use use);
  // Four bytes an element, fractions of 255.
  size_t add_colours(std::span<const uint8_t> values);
  // Raw bytes without an accessor; returns the index of the view.
  size_t add_view(std::span<const std::byte> bytes, Use use = Use::Values);
  // An accessor without data, for attributes that a compressed view holds.
  size_t add_empty(size_t count, size_t components, const Eigen::Vector3f* low, const Eigen::Vector3f* high);

  size_t size() const { return bytes_.size(); }
  std::vector<std::byte> take_bytes() { return std::move(bytes_); }
  const nlohmann::json& views() const { return views_; }
  const nlohmann::json& accessors() const { return accessors_; }

 private:
  size_t add_accessor(size_t view, size_t count, size_t components, int component_type);

  std::vector<std::byte> bytes_;
  nlohmann::json views_ = nlohmann::json::array(), accessors_ = nlohmann::json::array();
};

}  // namespace livegs
