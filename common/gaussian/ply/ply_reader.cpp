// SPDX-License-Identifier: Apache-2.0
// 3DGS .ply as written by the INRIA trainer and compatible tools. Properties are found by name, because their
// order, their scalar types, normals and further elements differ between writers.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include "gaussian/asset/float_of.h"
#include "gaussian/asset/readers.h"
#include "gaussian/asset/subtract_origin.h"
#include "gaussian/ply/activated_values.h"
#include "gaussian/ply/ply_comments.h"
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
  return invalid_data(prefix + std::to_string(count) +
                      " f_rest properties instead of 0, 9, 24 or 45; export it again");
}

// Thickness of a flat kernel, relative to its smaller deviation: thin against everything, far from underflow.
constexpr float kFlatRatio = 1e-3f;

using Names = std::array<const char*, 3>;
constexpr std::array<Names, 3> kRgbNames = {
    {{"red", "green", "blue"}, {"diffuse_red", "diffuse_green", "diffuse_blue"}, {"r", "g", "b"}}};

// Meaning of the properties of a file; writers differ.
struct Layout {
  int sh_degree = 0;
  int scale_count = 3;         // 2: flat kernels (2DGS); 1: round ones
  bool rotated = true;         // round kernels need no rotation
  const Names* rgb = nullptr;  // colours in place of f_dc_*
  bool exact = false;          // positions are more precise than floats
};

Layout layout_of(const PlyHeader& header, const PlyElement& vertex, int sh_degree) {
  Layout layout;
  layout.sh_degree = sh_degree;
  while (layout.scale_count > 1 && !vertex.find("scale_" + std::to_string(layout.scale_count - 1)))
    --layout.scale_count;
  if (layout.scale_count == 2 && !vertex.find("scale_0")) layout.scale_count = 3;  // scale_0 is missing
  layout.rotated = layout.scale_count > 1 || vertex.find("rot_0");
  if (!vertex.find("f_dc_0")) {
    for (const Names& names : kRgbNames) {
      const bool all = std::all_of(names.begin(), names.end(),
                                   [&](const char* one) { return vertex.find(one).has_value(); });
      if (all && !layout.rgb) layout.rgb = &names;
    }
  }
  // Text has as many digits as its writer chose, whatever type it declares.
  layout.exact = header.encoding == PlyEncoding::Ascii;
  for (const char* axis : {"x", "y", "z"}) {
    const std::optional<size_t> index = vertex.find(axis);
    if (!index) continue;
    const PlyScalar type = vertex.properties[*index].type;
    layout.exact |= type == PlyScalar::Float64 || type == PlyScalar::Int32 || type == PlyScalar::Uint32;
  }
  return layout;
}

// Collects the destination of each property. The first missing property is the error.
class PlyColumns {
 public:
  PlyColumns(const PlyElement& vertex, std::string_view name) : vertex_(vertex), name_(name) {}

  void add(const std::string& property, float* first, size_t stride, double* exact = nullptr) {
    const std::optional<size_t> index = vertex_.find(property);
    if (!index) {
      fail("has no property " + property + "; give a Gaussian splat file");
    } else if (vertex_.properties[*index].list_count_type) {
      fail("has a list as property " + property + " instead of one number; export it again");
    } else {
      columns_.push_back({*index, exact ? nullptr : first, nullptr, stride, exact});
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

void add_all(PlyColumns& columns, const Layout& layout, GaussianAsset& asset,
             std::vector<Eigen::Vector3d>& exact) {
  float* position = asset.positions.data()->data();
  float* scale = asset.log_scales.data()->data();
  float* rotation = asset.rotations.data()->coeffs().data();  // x y z w
  float* dc = asset.sh_dc.data()->data();
  constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};
  for (size_t i = 0; i < 3; ++i)
    columns.add(kAxes[i], position + i, 3, layout.exact ? exact.data()->data() + i : nullptr);
  columns.add("opacity", asset.opacity_logits.data(), 1);
  for (size_t i = 0; i < static_cast<size_t>(layout.scale_count); ++i)
    columns.add("scale_" + std::to_string(i), scale + i, 3);
  for (size_t i = 0; i < 3; ++i)
    columns.add(layout.rgb ? (*layout.rgb)[i] : "f_dc_" + std::to_string(i), dc + i, 3);
  for (size_t i = 0; i < 4 && layout.rotated; ++i)
    columns.add("rot_" + std::to_string(i), rotation + (i + 3) % 4, 4);
  const size_t rest = asset.sh_rest_count();
  for (size_t channel = 0; channel < 3; ++channel) {
    for (size_t k = 0; k < rest; ++k) {
      columns.add("f_rest_" + std::to_string(channel * rest + k),
                  asset.sh_rest.data()->data() + 3 * k + channel, 3 * rest);
    }
  }
}

// Colours of bytes, 16-bit integers or fractions become the constant harmonic. Floats above 1 are bytes that
// were converted.
void harmonics_of_rgb(const Layout& layout, const PlyElement& vertex, GaussianAsset& asset) {
  float full = 255;
  const PlyScalar type = vertex.properties[*vertex.find((*layout.rgb)[0])].type;
  if (type == PlyScalar::Int16 || type == PlyScalar::Uint16) full = 65535;
  if (type >= PlyScalar::Float32) {
    const bool fractions = std::all_of(asset.sh_dc.begin(), asset.sh_dc.end(),
                                       [](const Eigen::Vector3f& rgb) { return !(rgb.maxCoeff() > 1.0f); });
    if (fractions) full = 1;
  }
  for (Eigen::Vector3f& colour : asset.sh_dc) colour = (colour.array() / full - 0.5f) / kShBand0;
}

// Sets default values of missing properties, in the form of the file.
void fill_missing(const Layout& layout, GaussianAsset& asset) {
  for (Eigen::Vector3f& scale : asset.log_scales) {
    if (layout.scale_count == 2) scale.z() = scale.head<2>().minCoeff();
    if (layout.scale_count == 1) scale.setConstant(scale.x());
  }
  if (!layout.rotated)
    std::fill(asset.rotations.begin(), asset.rotations.end(), Eigen::Quaternionf::Identity());
}

void complete_shapes(const Layout& layout, AssetFile& file) {
  GaussianAsset& asset = file.asset;
  if (layout.scale_count == 2) {
    for (Eigen::Vector3f& scale : asset.log_scales)
      scale.z() = scale.head<2>().minCoeff() + std::log(kFlatRatio);
    file.notes.push_back(
        "two scales (2DGS): kernels are flat, a thousandth of their smaller deviation thick");
  } else if (layout.scale_count == 1) {
    file.notes.push_back("one scale: kernels are round");
  }
}

}  // namespace

Result<AssetFile> read_gaussian_ply(const PlyHeader& header, Bytes bytes, std::string_view name,
                                    const ReadOptions& options) {
  const PlyElement* vertex = header.find("vertex");
  if (!vertex) return invalid_data(std::string(name) + ": has no element vertex; give a Gaussian splat file");
  if (vertex->count == 0) return invalid_data(std::string(name) + ": element vertex has no rows");
  const Result<int> degree = sh_degree_of(*vertex, name);
  if (!degree) return degree.error();
  const Layout layout = layout_of(header, *vertex, *degree);

  // Check the properties before allocating memory for their values.
  AssetFile file;
  std::vector<Eigen::Vector3d> exact(1);
  file.asset.sh_degree = *degree;
  file.asset.resize(1);
  PlyColumns needed(*vertex, name);
  add_all(needed, layout, file.asset, exact);
  if (needed.error()) return *needed.error();

  file.asset.resize(vertex->count);
  exact.resize(layout.exact ? vertex->count : 0);
  PlyColumns columns(*vertex, name);
  add_all(columns, layout, file.asset, exact);
  PlyRows rows(header, bytes, name);
  for (const PlyElement& element : header.elements) {
    const bool wanted = &element == vertex;
    const Result<void> read = rows.read(element, wanted ? columns.columns() : std::span<const PlyColumn>{});
    if (!read) return read.error();
    if (wanted) break;
  }
  file.format = AssetFormat::Ply;
  read_ply_comments(header, file);
  if (layout.rgb) harmonics_of_rgb(layout, *vertex, file.asset);
  if (layout.exact) {
    for (size_t i = 0; i < exact.size(); ++i)
      file.asset.positions[i] = {float_of(exact[i].x()), float_of(exact[i].y()), float_of(exact[i].z())};
  }
  fill_missing(layout, file.asset);
  if (auto converted = convert_activated(file, options, name); !converted) return converted.error();
  complete_shapes(layout, file);
  if (layout.exact) subtract_origin(file, &exact);
  return file;
}

}  // namespace livegs
