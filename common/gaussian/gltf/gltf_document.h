// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/result.h"
#include "gaussian/asset/bytes.h"

namespace livegs {

// The numbers of an accessor, within the bytes of a buffer. Normalised integers are converted to fractions.
struct GltfNumbers {
  Bytes bytes;
  size_t count = 0, components = 0, stride = 0;
  int component_type = 5126;
  bool normalized = false;

  double at(size_t element, size_t component) const;
};

// A glTF 2.0 document with its buffers, from a .gltf or .glb. Every access checks the document: any bytes
// give values or an error.
class GltfDocument {
 public:
  // `bytes` and `name` outlive the document. `folder`: of referenced files; empty: there are none.
  static Result<GltfDocument> open(Bytes bytes, const std::filesystem::path& folder, std::string_view name);

  const std::string& name() const { return name_; }
  const nlohmann::json& json() const { return json_; }
  uint64_t total_bytes() const { return total_bytes_; }

  // Entry `index` of a list of the document, such as "nodes".
  Result<const nlohmann::json*> entry(const char* list, const nlohmann::json& index) const;
  Result<Bytes> buffer_view(const nlohmann::json& index) const;
  // Fails if the accessor does not have `components` numbers an element.
  Result<GltfNumbers> numbers(const nlohmann::json& accessor_index, size_t components) const;

  Error problem(const std::string& what) const { return invalid_data(name_ + ": " + what); }
  Error missing(const std::string& what) const { return unsupported(name_ + ": " + what); }

 private:
  Result<void> load_buffers(const std::filesystem::path& folder);
  Result<std::vector<std::byte>> load_uri(const std::string& uri, const std::filesystem::path& folder) const;

  std::string name_;
  nlohmann::json json_;
  Bytes binary_;  // the second chunk of a .glb
  std::vector<std::vector<std::byte>> owned_;
  std::vector<Bytes> buffers_;
  uint64_t total_bytes_ = 0;
};

}  // namespace livegs
