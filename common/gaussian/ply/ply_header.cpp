// SPDX-License-Identifier: Apache-2.0
#include "gaussian/ply/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "gaussian/asset/words.h"

namespace livegs {
namespace {

// Largest accepted header, bytes. Usual headers are under 4 KiB; the rest is room for comments.
constexpr size_t kMaxHeaderBytes = size_t{1} << 20;

std::optional<PlyScalar> scalar_named(std::string_view word) {
  struct Name {
    std::string_view word;
    PlyScalar type;
  };
  static constexpr std::array<Name, 16> kNames = {{{"char", PlyScalar::Int8},
                                                   {"int8", PlyScalar::Int8},
                                                   {"uchar", PlyScalar::Uint8},
                                                   {"uint8", PlyScalar::Uint8},
                                                   {"short", PlyScalar::Int16},
                                                   {"int16", PlyScalar::Int16},
                                                   {"ushort", PlyScalar::Uint16},
                                                   {"uint16", PlyScalar::Uint16},
                                                   {"int", PlyScalar::Int32},
                                                   {"int32", PlyScalar::Int32},
                                                   {"uint", PlyScalar::Uint32},
                                                   {"uint32", PlyScalar::Uint32},
                                                   {"float", PlyScalar::Float32},
                                                   {"float32", PlyScalar::Float32},
                                                   {"double", PlyScalar::Float64},
                                                   {"float64", PlyScalar::Float64}}};
  for (const Name& name : kNames) {
    if (name.word == word) return name.type;
  }
  return std::nullopt;
}

// Lines end in a line feed, or in a carriage return and a line feed. nullopt: no line is left within the
// limit.
std::optional<std::string_view> next_line(std::string_view text, size_t& at) {
  const size_t end = text.substr(0, kMaxHeaderBytes).find('\n', at);
  if (end == std::string_view::npos) return std::nullopt;
  std::string_view line = text.substr(at, end - at);
  at = end + 1;
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

// Each parser returns the problem with the line, or an empty text.
std::string add_element(PlyHeader& header, const std::vector<std::string_view>& words) {
  uint64_t count = 0;
  if (words.size() != 3) return "is not 'element NAME COUNT'";
  const auto [end, error] = std::from_chars(words[2].data(), words[2].data() + words[2].size(), count);
  if (error != std::errc() || end != words[2].data() + words[2].size()) return "has no valid count";
  if (header.find(words[1])) return "repeats an element name";
  header.elements.push_back({std::string(words[1]), count, {}});
  return "";
}

std::string add_property(PlyHeader& header, const std::vector<std::string_view>& words) {
  if (header.elements.empty()) return "precedes all elements";
  PlyElement& element = header.elements.back();
  PlyProperty property;
  const bool list = words.size() == 5 && words[1] == "list";
  if (!list && words.size() != 3) return "is not 'property TYPE NAME'";
  const std::optional<PlyScalar> type = scalar_named(words[words.size() - 2]);
  if (!type) return "has an unknown type";
  property.type = *type;
  if (list) {
    property.list_count_type = scalar_named(words[2]);
    if (!property.list_count_type) return "has an unknown type";
    if (*property.list_count_type >= PlyScalar::Float32) return "has a list count of a float type";
  }
  property.name = words.back();
  element.properties.push_back(std::move(property));
  return "";
}

std::string set_encoding(PlyHeader& header, const std::vector<std::string_view>& words) {
  if (words.size() != 3 || words[2] != "1.0") return "is not format 1.0";
  if (words[1] == "ascii") return header.encoding = PlyEncoding::Ascii, "";
  if (words[1] == "binary_little_endian") return header.encoding = PlyEncoding::LittleEndian, "";
  if (words[1] == "binary_big_endian") return header.encoding = PlyEncoding::BigEndian, "";
  return "has an unknown format";
}

bool has_duplicate_names(const PlyElement& element) {
  std::vector<std::string_view> names;
  for (const PlyProperty& property : element.properties) names.push_back(property.name);
  std::sort(names.begin(), names.end());
  return std::adjacent_find(names.begin(), names.end()) != names.end();
}

// Fewest bytes that `count` rows can take, saturating. In text, a value takes one digit and one separator.
uint64_t min_bytes(const PlyElement& element, PlyEncoding encoding) {
  const uint64_t row =
      encoding == PlyEncoding::Ascii ? 2 * element.properties.size() : element.min_row_bytes();
  if (row != 0 && element.count > UINT64_MAX / row) return UINT64_MAX;
  return element.count * row;
}

Result<void> check_elements(const PlyHeader& header, uint64_t body_bytes, std::string_view name) {
  uint64_t left = body_bytes;
  if (header.encoding == PlyEncoding::Ascii) ++left;  // the last value needs no separator
  for (const PlyElement& element : header.elements) {
    if (has_duplicate_names(element)) {
      return invalid_data(std::string(name) + ": element " + element.name + " repeats a property name");
    }
    const uint64_t needed = min_bytes(element, header.encoding);
    if (needed > left) {
      return invalid_data(std::string(name) + ": element " + element.name + " claims " +
                          std::to_string(element.count) +
                          " rows, more than the file can hold; copy or export it again");
    }
    left -= needed;
  }
  return {};
}

}  // namespace

size_t size_of(PlyScalar type) {
  static constexpr std::array<size_t, 8> kSizes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<size_t>(type)];
}

bool PlyElement::has_list() const {
  return std::any_of(properties.begin(), properties.end(),
                     [](const PlyProperty& p) { return p.list_count_type.has_value(); });
}

size_t PlyElement::min_row_bytes() const {
  size_t bytes = 0;
  for (const PlyProperty& property : properties)
    bytes += size_of(property.list_count_type.value_or(property.type));
  return bytes;
}

std::optional<size_t> PlyElement::find(std::string_view property) const {
  for (size_t i = 0; i < properties.size(); ++i) {
    if (properties[i].name == property) return i;
  }
  return std::nullopt;
}

const PlyElement* PlyHeader::find(std::string_view element) const {
  for (const PlyElement& candidate : elements) {
    if (candidate.name == element) return &candidate;
  }
  return nullptr;
}

Result<PlyHeader> parse_ply_header(Bytes file, std::string_view name) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  const std::string prefix = std::string(name) + ": ";
  PlyHeader header;
  size_t at = 0;
  bool has_format = false;
  if (next_line(text, at) != "ply") return invalid_data(prefix + "is not a PLY file");
  for (size_t number = 2;; ++number) {
    const std::optional<std::string_view> line = next_line(text, at);
    if (!line) return invalid_data(prefix + "the PLY header has no end_header");
    const std::vector<std::string_view> words = words_of(*line);
    if (words.empty() || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    std::string problem;
    if (words[0] == "comment") {
      header.comments.emplace_back(
          words.size() > 1 ? line->substr(static_cast<size_t>(words[1].data() - line->data())) : "");
    } else if (words[0] == "format") {
      problem = set_encoding(header, words);
      has_format = true;
    } else if (words[0] == "element") {
      problem = add_element(header, words);
    } else if (words[0] == "property") {
      problem = add_property(header, words);
    } else {
      problem = "has an unknown keyword";
    }
    if (!problem.empty())
      return invalid_data(prefix + "line " + std::to_string(number) + " of the PLY header " + problem);
  }
  if (!has_format) return invalid_data(prefix + "the PLY header has no format line");
  header.body_offset = at;
  const Result<void> checked = check_elements(header, file.size() - at, name);
  if (!checked) return checked.error();
  return header;
}

}  // namespace livegs
