// SPDX-License-Identifier: Apache-2.0
#include "gaussian/sog/sog_meta.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace livegs {
namespace {

using Json = nlohmann::json;

constexpr double kMaxCount = 4294967295.0;
constexpr size_t kMaxPalette = 65536;  // labels have 16 bits
constexpr size_t kCodebook = 256;

// Reads members of meta.json. The first problem is kept as the error; later reads return empty values.
class MetaReader {
 public:
  explicit MetaReader(std::string_view name) : name_(name) {}

  const std::optional<Error>& error() const { return error_; }

  void fail(const std::string& what) {
    if (!error_) error_ = invalid_data(std::string(name_) + ": meta.json: " + what);
  }

  const Json& member(const Json& object, const char* key) {
    static const Json kNothing;
    const auto found = object.is_object() ? object.find(key) : object.end();
    if (!object.is_object() || found == object.end()) {
      fail(std::string("has no ") + key);
      return kNothing;
    }
    return *found;
  }

  // A whole number of at least 1.
  size_t count(const Json& object, const char* key) {
    const Json& value = member(object, key);
    const double number = value.is_number() ? value.get<double>() : 0;
    if (!(number >= 1 && number <= kMaxCount && number == std::floor(number))) {
      fail(std::string(key) + " must be a whole number from 1 to 4294967295");
      return 1;
    }
    return static_cast<size_t>(number);
  }

  template <size_t N>
  std::array<float, N> numbers(const Json& object, const char* key) {
    std::array<float, N> values = {};
    const std::vector<float> found = list(member(object, key), key, N);
    std::copy(found.begin(), found.end(), values.begin());
    return values;
  }

  std::vector<float> codebook(const Json& object) {
    return list(member(object, "codebook"), "codebook", kCodebook);
  }

  std::string file(const Json& object, size_t index, size_t of) {
    const Json& files = member(object, "files");
    if (!files.is_array() || files.size() != of || !files[index].is_string()) {
      fail("files must be a list of " + std::to_string(of) + " names");
      return "";
    }
    return files[index].get<std::string>();
  }

 private:
  std::vector<float> list(const Json& array, const char* key, size_t size) {
    std::vector<float> values;
    if (!array.is_array() || array.size() != size) {
      fail(std::string(key) + " must be a list of " + std::to_string(size) + " numbers");
      return values;
    }
    for (const Json& entry : array) {
      const double number = entry.is_number() ? entry.get<double>() : NAN;
      if (!(std::abs(number) <= 1e30)) {
        fail(std::string(key) + " must contain only numbers within 1e30");
        return {};
      }
      values.push_back(static_cast<float>(number));
    }
    return values;
  }

  std::string_view name_;
  std::optional<Error> error_;
};

SogPalette palette_of(MetaReader& read, const Json& json) {
  SogPalette palette;
  palette.count = read.count(json, "count");
  const size_t degree = read.count(json, "bands");
  if (degree > 3) read.fail("shN.bands must be 1, 2 or 3");
  if (palette.count > kMaxPalette) read.fail("shN.count must be at most 65536");
  palette.degree = static_cast<int>(std::min<size_t>(degree, 3));
  palette.codebook = read.codebook(json);
  palette.centroids_file = read.file(json, 0, 2);
  palette.labels_file = read.file(json, 1, 2);
  return palette;
}

// Version 1 has no version member. It has bounds instead of codebooks, and the count is in the shape of the
// means.
void read_version_1(MetaReader& read, const Json& json, SogMeta& meta) {
  meta.version = 1;
  const Json& means = read.member(json, "means");
  const Json shape = means.contains("shape") ? means["shape"] : Json();
  if (!shape.is_array() || shape.size() != 2) {
    read.fail("has neither a version nor the means.shape of SOG version 1");
    return;
  }
  meta.count = read.count(Json{{"means.shape", shape[0]}}, "means.shape");
  const Json& scales = read.member(json, "scales");
  const std::array<float, 3> low = read.numbers<3>(scales, "mins"), high = read.numbers<3>(scales, "maxs");
  std::copy(low.begin(), low.end(), meta.scales.mins.begin());
  std::copy(high.begin(), high.end(), meta.scales.maxs.begin());
  const Json& sh0 = read.member(json, "sh0");
  meta.sh0.mins = read.numbers<4>(sh0, "mins");
  meta.sh0.maxs = read.numbers<4>(sh0, "maxs");
  if (json.contains("shN"))
    read.fail("SOG version 1 with view-dependent colour (shN) is not supported; convert it to version 2");
}

void read_version_2(MetaReader& read, const Json& json, SogMeta& meta) {
  meta.count = read.count(json, "count");
  meta.scales.codebook = read.codebook(read.member(json, "scales"));
  meta.sh0.codebook = read.codebook(read.member(json, "sh0"));
  if (json.contains("shN")) meta.palette = palette_of(read, json["shN"]);
  const auto antialias = json.find("antialias");
  meta.antialiased = antialias != json.end() && antialias->is_boolean() && antialias->get<bool>();
}

constexpr size_t kMaxFrameLines = 16;

void read_frame(const Json& json, SogMeta& meta) {
  const auto lines = json.find("livegs");
  if (lines == json.end() || !lines->is_array() || lines->size() > kMaxFrameLines) return;
  for (const Json& line : *lines) {
    if (!line.is_string()) continue;
    std::string note = read_frame_line(line.get_ref<const std::string&>(), meta.frame);
    if (!note.empty()) meta.notes.push_back(std::move(note));
  }
}

}  // namespace

Result<SogMeta> parse_sog_meta(Bytes bytes, std::string_view name) {
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  const Json json = Json::parse(text, text + bytes.size(), nullptr, false);
  if (json.is_discarded() || !json.is_object())
    return invalid_data(std::string(name) + ": meta.json is not a valid JSON object");

  MetaReader read(name);
  SogMeta meta;
  const auto version = json.find("version");
  if (version == json.end()) {
    read_version_1(read, json, meta);
  } else if (version->is_number() && version->get<double>() == 2.0) {
    read_version_2(read, json, meta);
  } else {
    return unsupported(std::string(name) + ": meta.json: SOG version " +
                       version->dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, 20) +
                       " is not supported; use version 1 or 2");
  }
  const Json& means = read.member(json, "means");
  meta.means_min = read.numbers<3>(means, "mins");
  meta.means_max = read.numbers<3>(means, "maxs");
  meta.means_low_file = read.file(means, 0, 2);
  meta.means_high_file = read.file(means, 1, 2);
  meta.quats_file = read.file(read.member(json, "quats"), 0, 1);
  meta.scales.file = read.file(read.member(json, "scales"), 0, 1);
  meta.sh0.file = read.file(read.member(json, "sh0"), 0, 1);
  if (read.error()) return *read.error();
  read_frame(json, meta);
  return meta;
}

}  // namespace livegs
