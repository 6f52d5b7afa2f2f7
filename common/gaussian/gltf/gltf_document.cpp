// SPDX-License-Identifier: Apache-2.0
// The glTF 2.0 specification, sections 3.6 (buffers and accessors) and 4 (GLB).
#include "gaussian/gltf/gltf_document.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/file.h"
#include "core/text/shown_text.h"
#include "gaussian/asset/file_below.h"
#include "gaussian/gltf_files.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr uint32_t kGlbMagic = 0x46546c67, kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;

// Bytes of a component; 0 for an unknown type.
size_t component_bytes(int type) {
  switch (type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

// A whole number from 0 that a size_t and a double hold; nothing otherwise.
std::optional<size_t> gltf_size(const Json& object, const char* key, std::optional<size_t> fallback) {
  const auto found = object.is_object() ? object.find(key) : object.end();
  if (!object.is_object() || found == object.end()) return fallback;
  const double number = found->is_number() ? found->get<double>() : -1;
  if (!(number >= 0 && number <= 9e15 && number == std::floor(number))) return std::nullopt;
  return static_cast<size_t>(number);
}

std::optional<std::vector<std::byte>> from_base64(std::string_view text) {
  std::vector<std::byte> bytes;
  bytes.reserve(text.size() / 4 * 3);
  uint32_t bits = 0;
  int held = 0;
  while (text.ends_with('=')) text.remove_suffix(1);
  for (const char c : text) {
    uint32_t value = 0;
    if (c >= 'A' && c <= 'Z') {
      value = static_cast<uint32_t>(c - 'A');
    } else if (c >= 'a' && c <= 'z') {
      value = static_cast<uint32_t>(c - 'a') + 26;
    } else if (c >= '0' && c <= '9') {
      value = static_cast<uint32_t>(c - '0') + 52;
    } else if (c == '+' || c == '/') {
      value = c == '+' ? 62 : 63;
    } else {
      return std::nullopt;
    }
    bits = bits << 6 | value;
    held += 6;
    if (held >= 8) {
      held -= 8;
      bytes.push_back(static_cast<std::byte>(bits >> held & 255));
    }
  }
  return bytes;
}

std::string percent_decoded(const std::string& uri) {
  const auto digit = [](char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
  };
  std::string plain;
  for (size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0) {
      plain += static_cast<char>(digit(uri[i + 1]) * 16 + digit(uri[i + 2]));
      i += 2;
    } else {
      plain += uri[i];
    }
  }
  return plain;
}

}  // namespace

std::vector<std::string> gltf_buffer_files(const fs::path& gltf) {
  std::vector<std::string> files;
  const auto text = read_text_file(gltf);
  const Json json = text ? Json::parse(*text, nullptr, false) : Json();
  const auto list = json.is_object() ? json.find("buffers") : json.end();
  if (!json.is_object() || list == json.end() || !list->is_array()) return files;
  for (const Json& buffer : *list) {
    const auto uri = buffer.is_object() ? buffer.find("uri") : buffer.end();
    if (!buffer.is_object() || uri == buffer.end() || !uri->is_string()) continue;
    const std::string file = percent_decoded(uri->get_ref<const std::string&>());
    if (!file.starts_with("data:") && is_file_below(file))
      files.push_back(fs::path(file).lexically_normal().string());
  }
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

double GltfNumbers::at(size_t element, size_t component) const {
  const size_t offset = element * stride + component * component_bytes(component_type);
  const auto fraction = [&](double value, double full) {
    return normalized ? std::max(value / full, -1.0) : value;
  };
  switch (component_type) {
    case 5120:
      return fraction(load<int8_t>(bytes, offset), 127);
    case 5121:
      return fraction(load<uint8_t>(bytes, offset), 255);
    case 5122:
      return fraction(load<int16_t>(bytes, offset), 32767);
    case 5123:
      return fraction(load<uint16_t>(bytes, offset), 65535);
    case 5125:
      return fraction(load<uint32_t>(bytes, offset), 4294967295.0);
    default:
      return static_cast<double>(load<float>(bytes, offset));
  }
}

Result<GltfDocument> GltfDocument::open(Bytes bytes, const fs::path& folder, std::string_view name) {
  GltfDocument document;
  document.name_ = name;
  document.total_bytes_ = bytes.size();
  Bytes text = bytes;
  if (bytes.size() >= 4 && load<uint32_t>(bytes, 0) == kGlbMagic) {
    if (bytes.size() < 20 || load<uint32_t>(bytes, 8) != bytes.size())
      return document.problem("the .glb is truncated, or its header states another length");
    if (load<uint32_t>(bytes, 4) != 2)
      return document.missing("glTF version " + std::to_string(load<uint32_t>(bytes, 4)) +
                              " is not supported; export version 2");
    const size_t json_bytes = load<uint32_t>(bytes, 12);
    if (load<uint32_t>(bytes, 16) != kJsonChunk || json_bytes > bytes.size() - 20)
      return document.problem("the first chunk of the .glb is not valid JSON");
    text = bytes.subspan(20, json_bytes);
    const Bytes rest = bytes.subspan(20 + json_bytes);
    if (rest.size() >= 8 && load<uint32_t>(rest, 4) == kBinaryChunk) {
      if (load<uint32_t>(rest, 0) > rest.size() - 8)
        return document.problem("the .glb ends within its binary chunk");
      document.binary_ = rest.subspan(8, load<uint32_t>(rest, 0));
    }
  }
  const auto* first = reinterpret_cast<const char*>(text.data());
  document.json_ = Json::parse(first, first + text.size(), nullptr, false);
  if (!document.json_.is_object()) return document.problem("is not a valid JSON object");
  const auto asset = document.json_.find("asset");
  if (asset == document.json_.end() || !asset->is_object() || !asset->contains("version"))
    return document.problem("is JSON but not glTF, as it has no asset.version");
  if (auto loaded = document.load_buffers(folder); !loaded) return loaded.error();
  return document;
}

Result<void> GltfDocument::load_buffers(const fs::path& folder) {
  const auto list = json_.find("buffers");
  if (list == json_.end()) return {};
  if (!list->is_array()) return problem("buffers is not a list");
  std::map<std::string, Bytes> loaded;
  for (size_t i = 0; i < list->size(); ++i) {
    const Json& buffer = (*list)[i];
    const std::string what = "buffers[" + std::to_string(i) + "]";
    const auto length = gltf_size(buffer, "byteLength", std::nullopt);
    if (!length) return problem(what + " has no valid byteLength");
    Bytes bytes = binary_;
    const auto uri = buffer.find("uri");
    if (uri != buffer.end()) {
      if (!uri->is_string()) return problem(what + ".uri is not a text");
      const std::string& address = uri->get_ref<const std::string&>();
      const std::string key = address.starts_with("data:")
                                  ? what
                                  : fs::path(percent_decoded(address)).lexically_normal().string();
      auto known = loaded.find(key);
      if (known == loaded.end()) {  // each file once, however many buffers name it
        auto read = load_uri(address, folder);
        if (!read) return read.error();
        total_bytes_ += read->size();
        owned_.push_back(std::move(*read));
        known = loaded.emplace(key, owned_.back()).first;
      }
      bytes = known->second;
    } else if (i > 0) {
      bytes = {};
    }
    if (*length > bytes.size())
      return problem(what + " has " + std::to_string(bytes.size()) + " bytes instead of " +
                     std::to_string(*length));
    buffers_.push_back(bytes.first(*length));
  }
  return {};
}

Result<std::vector<std::byte>> GltfDocument::load_uri(const std::string& uri, const fs::path& folder) const {
  if (uri.starts_with("data:")) {
    const size_t comma = uri.find(";base64,");
    if (comma == uri.npos) return problem("a data: URI of a buffer is not base64");
    auto bytes = from_base64(std::string_view(uri).substr(comma + 8));
    if (!bytes) return problem("a data: URI of a buffer has characters that are not base64");
    return std::move(*bytes);
  }
  const std::string file = percent_decoded(uri);
  if (!is_file_below(file))
    return problem("the buffer " + quoted_name(file) + " is not a file below the folder");
  if (folder.empty())
    return problem("needs the file " + quoted_name(file) +
                   " next to it; use a .glb, which has all in one file");
  return read_file(folder / file);
}

Result<const Json*> GltfDocument::entry(const char* list, const Json& index) const {
  const auto found = json_.find(list);
  const double number = index.is_number() ? index.get<double>() : -1;
  if (found == json_.end() || !found->is_array() || !(number >= 0) ||
      !(number < static_cast<double>(found->size())) || number != std::floor(number))
    return problem(std::string("refers to an entry of ") + list + " that does not exist");
  const Json& entry = (*found)[static_cast<size_t>(number)];
  if (!entry.is_object()) return problem(std::string("an entry of ") + list + " is not an object");
  return &entry;
}

Result<Bytes> GltfDocument::buffer_view(const Json& index) const {
  const auto view = entry("bufferViews", index);
  if (!view) return view.error();
  const auto extensions = (*view)->find("extensions");
  if (extensions != (*view)->end() && extensions->is_object()) {
    for (const auto& [key, value] : extensions->items()) {
      if (key.find("meshopt") != key.npos)
        return missing("is compressed with " + shown_line(key) +
                       ", which is not supported; export it without");
    }
  }
  const auto buffer = gltf_size(**view, "buffer", std::nullopt);
  const auto offset = gltf_size(**view, "byteOffset", 0),
             length = gltf_size(**view, "byteLength", std::nullopt);
  if (!buffer || *buffer >= buffers_.size() || !offset || !length)
    return problem("a buffer view has no valid buffer, byteOffset or byteLength");
  const Bytes bytes = buffers_[*buffer];
  if (*offset > bytes.size() || *length > bytes.size() - *offset)
    return problem("a buffer view ends beyond its buffer");
  return bytes.subspan(*offset, *length);
}

Result<GltfNumbers> GltfDocument::numbers(const Json& accessor_index, size_t components) const {
  const auto accessor = entry("accessors", accessor_index);
  if (!accessor) return accessor.error();
  const Json& json = **accessor;
  if (json.contains("sparse") || !json.contains("bufferView"))
    return missing("has a sparse accessor, which is not supported; export it without");
  GltfNumbers numbers;
  const auto type = json.find("type");
  static constexpr const char* kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
  for (size_t i = 0; i < 4; ++i) {
    if (type != json.end() && type->is_string() && *type == kTypes[i]) numbers.components = i + 1;
  }
  if (numbers.components != components)
    return problem("an accessor of a splat attribute must have " + std::to_string(components) +
                   " components");
  const auto component_type = gltf_size(json, "componentType", std::nullopt),
             count = gltf_size(json, "count", std::nullopt), offset = gltf_size(json, "byteOffset", 0);
  const size_t size =
      component_type ? component_bytes(static_cast<int>(std::min<size_t>(*component_type, 9999))) : 0;
  if (size == 0 || !count || *count == 0 || !offset)
    return problem("an accessor has no valid componentType, count or byteOffset");
  const auto bytes = buffer_view(json["bufferView"]);
  if (!bytes) return bytes.error();
  const auto view = entry("bufferViews", json["bufferView"]);
  const size_t packed = components * size;
  const auto stride = gltf_size(**view, "byteStride", packed);
  if (!stride || *stride < packed || *stride > 65536) return problem("a buffer view has no valid byteStride");
  if (*offset > bytes->size() || bytes->size() - *offset < packed ||
      (bytes->size() - *offset - packed) / *stride < *count - 1)
    return problem("an accessor claims " + std::to_string(*count) +
                   " elements, more than its buffer view holds");
  numbers.bytes = bytes->subspan(*offset);
  numbers.count = *count;
  numbers.stride = *stride;
  numbers.component_type = static_cast<int>(*component_type);
  const auto normalized = json.find("normalized");
  numbers.normalized = normalized != json.end() && normalized->is_boolean() && normalized->get<bool>();
  return numbers;
}

}  // namespace livegs
