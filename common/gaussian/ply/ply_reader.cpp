// SPDX-License-Identifier: Apache-2.0
// 3DGS .ply as written by the INRIA trainer and compatible tools. Properties are found by name, because their
// order, their scalar types, normals and further elements differ between writers.
#include <algorithm>
#include <charconv>
#include <optional>

#include "gaussian/asset/readers.h"
#include "gaussian/ply/ply_header.h"
#include "gaussian/ply/ply_rows.h"

namespace livegs {
namespace {

constexpr std::string_view kRestPrefix = "f_rest_";

// INDEX of a property f_rest_INDEX, without leading zeros.
std::optional<size_t> rest_index(std::string_view property) {
  const std::string_view digits = property.substr(kRestPrefix.size());
  size_t index = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  if (digits.size() > 1 && digits[0] == '0') return std::nullopt;
  return index;
}

// SH degree of the f_rest_* properties. They must be numbered from 0 without a gap.
Result<int> sh_degree_of(const PlyElement& vertex, std::string_view name) {
  const std::string prefix = std::string(name) + ": ";
  size_t count = 0;
  for (const PlyProperty& property : vertex.properties) {
    if (!property.name.starts_with(kRestPrefix)) continue;
    if (!rest_index(property.name))
      return invalid_data(prefix + "property " + property.name + " is not f_rest_NUMBER");
    ++count;
  }
  for (size_t i = 0; i < count; ++i) {
    if (!vertex.find(std::string(kRestPrefix) + std::to_string(i))) {
      return invalid_data(prefix + "property f_rest_" + std::to_string(i) + " is missing among " +
                          std::to_string(count));
    }
  }
  for (int degree = 0; degree <= 3; ++degree) {
    if (count == static_cast<size_t>(3 * ((degree + 1) * (degree + 1) - 1))) return degree;
  }
  if (count == 72)
    return unsupported(prefix + "has spherical harmonics of degree 4; save it with degree 3 or less");
  return invalid_data(prefix + std::to_string(count) + " f_rest properties; expected 0, 9, 24 or 45");
}

bool says_antialiased(const PlyHeader& header) {
  return std::any_of(header.comments.begin(), header.comments.end(), [](const std::string& comment) {
    return comment == "SplatRenderMode: mip" || comment == "antialiased 1";
  });
}

// Collects the destination of each property. The first missing property is the error.
class PlyColumns {
 public:
  PlyColumns(const PlyElement& vertex, std::string_view name) : vertex_(vertex), name_(name) {}

  void add(const std::string& property, float* first, size_t stride) {
    const std::optional<size_t> index = vertex_.find(property);
    if (!index) {
      fail("has no property " + property + "; is this a Gaussian splat file?");
    } else if (vertex_.properties[*index].list_count_type) {
      fail("has a list as property " + property + "; expected one number");
    } else {
      columns_.push_back({*index, first, nullptr, stride});
    }
  }
  const std::optional<Error>& error() const { return error_; }
  std::span<const PlyColumn> columns() const { return columns_; }

 private:
  void fail(const std::string& what) {
    if (!error_) error_ = invalid_data(std::string(name_) + ": element vertex " + what);
  }
  const PlyElement& vertex_;
  std::string_view name_;
  std::vector<PlyColumn> columns_;
  std::optional<Error> error_;
};

void add_all(PlyColumns& columns, GaussianAsset& asset) {
  float* position = asset.positions.data()->data();
  float* scale = asset.log_scales.data()->data();
  float* rotation = asset.rotations.data()->coeffs().data();  // x y z w
  float* dc = asset.sh_dc.data()->data();
  columns.add("x", position, 3);
  columns.add("y", position + 1, 3);
  columns.add("z", position + 2, 3);
  columns.add("opacity", asset.opacity_logits.data(), 1);
  for (size_t i = 0; i < 3; ++i) {
    columns.add("scale_" + std::to_string(i), scale + i, 3);
    columns.add("f_dc_" + std::to_string(i), dc + i, 3);
  }
  for (size_t i = 0; i < 4; ++i) columns.add("rot_" + std::to_string(i), rotation + (i + 3) % 4, 4);
  const size_t rest = asset.sh_rest_count();
  for (size_t channel = 0; channel < 3; ++channel) {
    for (size_t k = 0; k < rest; ++k) {
      columns.add("f_rest_" + std::to_string(channel * rest + k),
                  asset.sh_rest.data()->data() + 3 * k + channel, 3 * rest);
    }
  }
}

}  // namespace

Result<AssetFile> read_gaussian_ply(const PlyHeader& header, Bytes bytes, std::string_view name) {
  const PlyElement* vertex = header.find("vertex");
  if (!vertex)
    return invalid_data(std::string(name) + ": has no element vertex; is this a Gaussian splat file?");
  if (vertex->count == 0) return invalid_data(std::string(name) + ": element vertex has no rows");
  const Result<int> degree = sh_degree_of(*vertex, name);
  if (!degree) return degree.error();

  // Check the properties before allocating memory for their values.
  AssetFile file;
  file.asset.sh_degree = *degree;
  file.asset.resize(1);
  PlyColumns needed(*vertex, name);
  add_all(needed, file.asset);
  if (needed.error()) return *needed.error();

  file.asset.resize(vertex->count);
  PlyColumns columns(*vertex, name);
  add_all(columns, file.asset);
  PlyRows rows(header, bytes, name);
  for (const PlyElement& element : header.elements) {
    const bool wanted = &element == vertex;
    const Result<void> read = rows.read(element, wanted ? columns.columns() : std::span<const PlyColumn>{});
    if (!read) return read.error();
    if (wanted) break;
  }
  file.format = AssetFormat::Ply;
  file.asset.antialiased = says_antialiased(header);
  return file;
}

}  // namespace livegs
