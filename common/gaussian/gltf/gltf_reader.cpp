// SPDX-License-Identifier: Apache-2.0
// KHR_gaussian_splatting in glTF 2.0 (Khronos): a primitive of points whose attributes are those of kernels,
// or an .spz in a buffer view (KHR_gaussian_splatting_compression_spz_2). Drafts wrote _ROTATION and _SCALE,
// and colour and opacity as COLOR_0. Kernels of all nodes of the scene become one asset.
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/text/path_ending.h"
#include "core/text/shown_text.h"
#include "gaussian/asset/append_asset.h"
#include "gaussian/asset/establish_invariants.h"
#include "gaussian/asset/float_of.h"
#include "gaussian/asset/readers.h"
#include "gaussian/asset/subtract_origin.h"
#include "gaussian/asset/y_up.h"
#include "gaussian/gltf/gltf_document.h"
#include "gaussian/gltf/gltf_mesh.h"
#include "gaussian/transform_asset.h"

namespace livegs {

// One primitive with exact positions, in the axes of its node.
struct GltfKernels {
  GaussianAsset asset;
  std::vector<Eigen::Vector3d> exact;
};

namespace {

using Json = nlohmann::json;
using Eigen::Affine3d;
using Eigen::Matrix3d;

constexpr const char* kExtension = "KHR_gaussian_splatting";
// The kernels of all nodes together take at most this many times the bytes of the file, at kBytesOfKernel
// each: nodes may repeat a mesh.
constexpr uint64_t kMaxInstanceRatio = 32;
constexpr uint64_t kBytesOfKernel = 20;  // of the smallest usual coding
constexpr double kMaxPlacement = 1e15;   // of a number of a node
constexpr double kUniformTolerance = 1e-6;

const Json& member_of(const Json& object, const char* key) {
  static const Json kNone;
  const auto found = object.is_object() ? object.find(key) : object.end();
  return object.is_object() && found != object.end() ? *found : kNone;
}

// Fills `values` from a list of as many numbers, if there is one. False: the member is something else.
template <size_t N>
bool numbers_of(const Json& object, const char* key, std::array<double, N>& values) {
  const Json& list = member_of(object, key);
  if (list.is_null()) return true;
  if (!list.is_array() || list.size() != N) return false;
  for (size_t i = 0; i < N; ++i) {
    if (!list[i].is_number()) return false;
    values[i] = list[i].get<double>();
    if (!(std::abs(values[i]) <= kMaxPlacement)) return false;
  }
  return true;
}

// parent_from_node. nullopt: the numbers of the node are not valid.
std::optional<Affine3d> placement_of(const Json& node) {
  Affine3d placement = Affine3d::Identity();
  if (node.contains("matrix")) {
    std::array<double, 16> matrix{};
    if (!numbers_of(node, "matrix", matrix)) return std::nullopt;
    placement.matrix() = Eigen::Map<const Eigen::Matrix4d>(matrix.data());
    placement.makeAffine();
    return placement;
  }
  std::array<double, 3> translation{}, scale{1, 1, 1};
  std::array<double, 4> rotation{0, 0, 0, 1};
  if (!numbers_of(node, "translation", translation) || !numbers_of(node, "rotation", rotation) ||
      !numbers_of(node, "scale", scale))
    return std::nullopt;
  const Eigen::Quaterniond q(rotation[3], rotation[0], rotation[1], rotation[2]);
  if (!(q.norm() > 0.5 && q.norm() < 2)) return std::nullopt;
  placement.translate(Eigen::Vector3d(translation[0], translation[1], translation[2]));
  placement.rotate(q.normalized());
  placement.scale(Eigen::Vector3d(scale[0], scale[1], scale[2]));
  return placement;
}

double srgb_of_linear(double x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055; }

// Converts colours of linear light to the sRGB encoding, in which kernels are blended here: exact for the
// constant term, to first order for the others.
void encode_linear_colours(GaussianAsset& asset) {
  const size_t rest = asset.sh_rest_count();
  for (size_t i = 0; i < asset.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const double linear = std::clamp(0.5 + static_cast<double>(kShBand0 * asset.sh_dc[i][c]), 1e-3, 1e3);
      const double slope = (srgb_of_linear(linear * 1.001) - srgb_of_linear(linear)) / (linear * 0.001);
      asset.sh_dc[i][c] = static_cast<float>((srgb_of_linear(linear) - 0.5) / static_cast<double>(kShBand0));
      for (size_t k = 0; k < rest; ++k) asset.sh_rest[i * rest + k][c] *= static_cast<float>(slope);
    }
  }
}

// Whether the lines of LiveGS in the extras of an object mark its kernels as trained antialiased. `frame`
// takes the other lines, and `notes` reports unknown ones; null: they are ignored.
bool read_extras(const Json& object, AssetFrame* frame, std::vector<std::string>* notes) {
  bool antialiased = false;
  const Json& lines = member_of(member_of(object, "extras"), "livegs");
  if (!lines.is_array() || lines.size() > 16) return false;
  for (const Json& line : lines) {
    if (!line.is_string()) continue;
    const std::string& text = line.get_ref<const std::string&>();
    antialiased |= lower_case(text) == "splatrendermode: mip";
    if (!frame) continue;
    std::string note = read_frame_line(text, *frame);
    if (!note.empty()) notes->push_back(std::move(note));
  }
  return antialiased;
}

// Moves kernels to the frame of the scene. Shear and mirrors are allowed: covariances become M C M^T.
void place(GltfKernels& kernels, const Affine3d& scene_from_node) {
  GaussianAsset& asset = kernels.asset;
  const Matrix3d linear = scene_from_node.linear();
  for (Eigen::Vector3d& position : kernels.exact) position = scene_from_node * position;
  const Eigen::JacobiSVD<Matrix3d> svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d turn = svd.matrixU() * svd.matrixV().transpose();
  const bool mirrored = turn.determinant() < 0;
  if (mirrored) turn = -turn;
  const Eigen::Vector3d sizes = svd.singularValues();
  const bool uniform = sizes[0] - sizes[2] <= kUniformTolerance * sizes[0];
  const std::vector<Eigen::Vector3f> scales = asset.log_scales;
  const std::vector<Eigen::Quaternionf> rotations = asset.rotations;
  transform_asset(asset, Eigen::Quaterniond(turn), uniform && sizes[0] > 0 ? sizes.mean() : 1.0);
  if (mirrored) {  // a turn and an inversion, under which harmonics of odd degree change their sign
    const size_t rest = asset.sh_rest_count();
    for (size_t n = 0; n < asset.sh_rest.size(); ++n) {
      const size_t k = n % rest;
      if (k < 3 || k >= 8) asset.sh_rest[n] = -asset.sh_rest[n];
    }
  }
  if (uniform && sizes[0] > 0) return;  // a kernel is the same after an inversion
  for (size_t i = 0; i < asset.size(); ++i) {
    if (!rotations[i].coeffs().allFinite() || !(rotations[i].norm() > 0) || scales[i].hasNaN()) continue;
    const Eigen::Vector3d deviations = scales[i].cast<double>().array().exp();
    const Matrix3d axes =
        linear * rotations[i].cast<double>().normalized().toRotationMatrix() * deviations.asDiagonal();
    if (!axes.allFinite()) continue;
    const Eigen::JacobiSVD<Matrix3d> shape(axes, Eigen::ComputeFullU);
    Matrix3d u = shape.matrixU();
    if (u.determinant() < 0) u.col(2) = -u.col(2);
    asset.rotations[i] = Eigen::Quaterniond(u).normalized().cast<float>();
    asset.log_scales[i] = shape.singularValues().array().log().cast<float>();
  }
}

}  // namespace

class GltfSplats {
 public:
  explicit GltfSplats(const GltfDocument& document) : document_(document) {}

  Result<AssetFile> read() {
    if (auto walked = walk(); !walked) return walked.error();
    if (all_.asset.size() == 0) {
      return document_.problem(
          "no primitive of its scene has the extension KHR_gaussian_splatting; give a file of splats, not a "
          "mesh");
    }
    AssetFile file;
    file.format = AssetFormat::Gltf;
    file.asset = std::move(all_.asset);
    file.y_up_in_file = true;
    file.frame.metres_per_unit = 1;
    file.frame.unit_of_format = true;
    file.notes = std::move(notes_);
    turn_half_about_x(file.asset);
    for (Eigen::Vector3d& position : all_.exact) position.tail<2>() *= -1;
    // Exports up to version 1 of LIVEGS_physics marked the whole document.
    if (read_extras(member_of(document_.json(), "asset"), &file.frame, &file.notes))
      file.asset.antialiased = true;
    else if (file.asset.antialiased && unmarked_)
      file.notes.push_back("some kernels were trained antialiased, others not; all are drawn as antialiased");
    file.frame.up_axis = "-y";  // after the turn; the format has one frame
    subtract_origin(file, &all_.exact);
    return file;
  }

  Result<GaussianAsset> read_mesh(const Json& index) {
    if (auto added = add_mesh(index, Affine3d::Identity()); !added) return added.error();
    if (all_.asset.size() == 0) return GaussianAsset{};
    AssetFile file;
    file.asset = std::move(all_.asset);
    all_ = {};
    turn_half_about_x(file.asset);
    if (auto valid = establish_invariants(file, document_.name()); !valid) return valid.error();
    return std::move(file.asset);
  }

  Result<size_t> count_mesh(const Json& index) {
    const auto mesh = document_.entry("meshes", index);
    if (!mesh) return mesh.error();
    const Json& primitives = member_of(**mesh, "primitives");
    size_t total = 0;
    if (!primitives.is_array()) return total;
    for (const Json& primitive : primitives) {
      const auto source = source_of(primitive);
      if (!source) return source.error();
      if (!*source) continue;
      const auto count = count_of(primitive, **source);
      if (!count) return count.error();
      if (auto counted = add_count(*count, (*source)->spz); !counted) return counted.error();
      total += *count;
    }
    return total;
  }

 private:
  // Visits the nodes of the scene. A node belongs to one parent, so a second visit is an error.
  Result<void> walk() {
    const Json& json = document_.json();
    const Json& nodes = member_of(json, "nodes");
    if (!nodes.is_array()) return {};
    std::vector<std::pair<size_t, Affine3d>> open;
    std::vector<bool> seen(nodes.size(), false);
    const auto add = [&](const Json& list, const Affine3d& placement) -> Result<void> {
      if (!list.is_array()) return {};
      for (auto index = list.rbegin(); index != list.rend(); ++index) {
        const auto node = document_.entry("nodes", *index);
        if (!node) return node.error();
        const auto number = static_cast<size_t>(index->get<double>());
        if (seen[number]) return document_.problem("nodes[" + std::to_string(number) + "] has two parents");
        seen[number] = true;
        open.emplace_back(number, placement);
      }
      return {};
    };
    if (member_of(json, "scenes").is_array() && !member_of(json, "scenes").empty()) {
      const Json first = 0;
      const auto scene = document_.entry("scenes", json.contains("scene") ? json["scene"] : first);
      if (!scene) return scene.error();
      if (auto added = add(member_of(**scene, "nodes"), Affine3d::Identity()); !added) return added;
    } else {
      std::vector<bool> child(nodes.size(), false);
      for (const Json& node : nodes) {
        for (const Json& index : member_of(node, "children")) {
          if (index.is_number_unsigned() && index.get<size_t>() < child.size())
            child[index.get<size_t>()] = true;
        }
      }
      Json roots = Json::array();
      for (size_t i = 0; i < nodes.size(); ++i) {
        if (!child[i]) roots.push_back(i);
      }
      if (auto added = add(roots, Affine3d::Identity()); !added) return added;
    }
    while (!open.empty()) {
      const auto [number, parent] = open.back();
      open.pop_back();
      const Json& node = nodes[number];
      const auto own = placement_of(node);
      if (!own)
        return document_.problem("nodes[" + std::to_string(number) +
                                 "] has no valid matrix, translation, rotation or scale");
      if (own->linear().isZero(0)) continue;  // of size zero: not drawn, with all nodes below it
      const Affine3d scene_from_node = parent * *own;
      if (!scene_from_node.matrix().allFinite() ||
          scene_from_node.matrix().cwiseAbs().maxCoeff() > kMaxPlacement)
        return document_.problem("nodes[" + std::to_string(number) + "] lies too far away");
      if (node.contains("mesh")) {
        if (auto added = add_mesh(node["mesh"], scene_from_node); !added) return added;
      }
      if (auto added = add(member_of(node, "children"), scene_from_node); !added) return added;
    }
    return {};
  }

  Result<void> add_mesh(const Json& index, const Affine3d& scene_from_node) {
    const auto mesh = document_.entry("meshes", index);
    if (!mesh) return mesh.error();
    const Json& primitives = member_of(**mesh, "primitives");
    if (!primitives.is_array()) return {};
    for (const Json& primitive : primitives) {
      const auto source = source_of(primitive);
      if (!source) return source.error();
      if (!*source) continue;
      const auto [splats, spz] = **source;
      auto kernels = spz ? read_spz_view(*spz) : read_attributes(member_of(primitive, "attributes"));
      if (!kernels) return kernels.error();
      if (auto counted = add_count(kernels->asset.size(), spz); !counted) return counted;
      const Json& space = member_of(*splats, "colorSpace");
      if (space.is_string() && space.get_ref<const std::string&>().starts_with("lin_")) {
        encode_linear_colours(kernels->asset);
        const std::string note =
            "colours are linear and were converted to sRGB, view-dependent ones to first order";
        if (std::find(notes_.begin(), notes_.end(), note) == notes_.end()) notes_.push_back(note);
      }
      kernels->asset.antialiased |= read_extras(primitive, nullptr, nullptr);
      unmarked_ |= !kernels->asset.antialiased;
      place(*kernels, scene_from_node);
      append_asset(all_.asset, kernels->asset, [](size_t) { return true; });
      all_.exact.insert(all_.exact.end(), kernels->exact.begin(), kernels->exact.end());
    }
    return {};
  }

  // Where the kernels of a primitive are stored.
  struct Source {
    const Json* splats = nullptr;  // the extension; a null value if there is only an .spz
    const Json* spz = nullptr;     // index of the buffer view; null: attributes
  };

  // nullopt: the primitive has no kernels.
  Result<std::optional<Source>> source_of(const Json& primitive) const {
    const Json& extensions = member_of(primitive, "extensions");
    const Json& splats = member_of(extensions, kExtension);
    const Json* spz = spz_view(member_of(splats, "extensions"));
    if (!spz) spz = spz_view(extensions);
    if (!splats.is_object() && !spz) return std::optional<Source>();
    const Json& kernel = member_of(splats, "kernel");
    if (kernel.is_string() && kernel != "ellipse")
      return document_.missing("has kernels of the kind " + quoted_name(kernel.get<std::string>()) +
                               " instead of ellipse; export it with the kernel ellipse");
    return std::optional(Source{&splats, spz});
  }

  Result<void> add_count(uint64_t kernels, bool spz) {
    const uint64_t most =
        (spz ? kMaxCompressionRatio : kMaxInstanceRatio) * document_.total_bytes() / kBytesOfKernel;
    if (kernels > most || count_ > most - kernels)
      return document_.problem("repeats its kernels more often than a file of its size may");
    count_ += kernels;
    return {};
  }

  Result<size_t> count_of(const Json& primitive, const Source& source) {
    const Json& position = member_of(member_of(primitive, "attributes"), "POSITION");
    if (!source.spz) {
      const auto numbers = document_.numbers(position, 3);
      if (!numbers) return numbers.error();
      return numbers->count;
    }
    if (!position.is_null()) {  // has no buffer view: only the .spz has the numbers
      const auto accessor = document_.entry("accessors", position);
      if (!accessor) return accessor.error();
      if (const Json& count = member_of(**accessor, "count"); count.is_number_unsigned())
        return count.get<size_t>();
      return document_.problem("an accessor has no valid count");
    }
    const auto kernels = read_spz_view(*source.spz);
    if (!kernels) return kernels.error();
    return kernels->asset.size();
  }

  static const Json* spz_view(const Json& extensions) {
    if (!extensions.is_object()) return nullptr;
    for (const auto& [key, value] : extensions.items()) {
      if (key.find("spz") != key.npos && value.is_object() && value.contains("bufferView"))
        return &value["bufferView"];
    }
    return nullptr;
  }

  Result<GltfKernels> read_spz_view(const Json& index) {
    const auto view = document_.entry("bufferViews", index);
    if (!view) return view.error();
    if (const auto known = decoded_.find(*view); known != decoded_.end()) return GltfKernels(known->second);
    const auto bytes = document_.buffer_view(index);
    if (!bytes) return bytes.error();
    auto file = read_spz(*bytes, "the .spz in the file");
    if (!file) return document_.problem(file.error().message);
    GltfKernels kernels;
    kernels.asset = std::move(file->asset);
    turn_half_about_x(kernels.asset);  // back to y up
    for (const Eigen::Vector3f& position : kernels.asset.positions)
      kernels.exact.push_back(position.cast<double>());
    decoded_[*view] = kernels;
    return kernels;
  }

  // The accessor of an attribute by its name in the extension, or by that of drafts.
  const Json& attribute(const Json& attributes, const std::string& name) const {
    std::string key = kExtension;
    key += ':';
    key += name;
    const Json& found = member_of(attributes, key.c_str());
    if (!found.is_null()) return found;
    key = "_";
    key += name;
    return member_of(attributes, key.c_str());
  }

  Result<GltfKernels> read_attributes(const Json& attributes) {
    GltfKernels kernels;
    GaussianAsset& asset = kernels.asset;
    const auto position = document_.numbers(member_of(attributes, "POSITION"), 3);
    if (!position) return position.error();
    const size_t count = position->count;
    const auto required = [&](const char* name, size_t components) -> Result<GltfNumbers> {
      const Json& index = attribute(attributes, name);
      if (index.is_null())
        return document_.problem(std::string("a splat primitive has no attribute ") + name);
      auto numbers = document_.numbers(index, components);
      if (numbers && numbers->count != count)
        return document_.problem(std::string("attribute ") + name + " has " + std::to_string(numbers->count) +
                                 " elements for " + std::to_string(count) + " kernels");
      return numbers;
    };
    const auto rotation = required("ROTATION", 4), scale = required("SCALE", 3);
    if (!rotation) return rotation.error();
    if (!scale) return scale.error();
    while (asset.sh_degree < 3 && !attribute(attributes, coefficient_name(asset.sh_degree + 1, 0)).is_null())
      ++asset.sh_degree;
    asset.resize(count);
    kernels.exact.resize(count);
    for (size_t i = 0; i < count; ++i) {
      for (size_t axis = 0; axis < 3; ++axis) {
        const double value = position->at(i, axis);
        kernels.exact[i][static_cast<int>(axis)] = value;
        asset.positions[i][static_cast<int>(axis)] = float_of(value);
        asset.log_scales[i][static_cast<int>(axis)] = float_of(std::log(scale->at(i, axis)));
      }
      for (size_t k = 0; k < 4; ++k)
        asset.rotations[i].coeffs()[static_cast<int>(k)] = float_of(rotation->at(i, k));
    }
    if (auto read = read_colours(attributes, required, asset); !read) return read.error();
    return kernels;
  }

  static std::string coefficient_name(int degree, int n) {
    return "SH_DEGREE_" + std::to_string(degree) + "_COEF_" + std::to_string(n);
  }

  template <class Required>
  Result<void> read_colours(const Json& attributes, const Required& required, GaussianAsset& asset) {
    const auto vector = [](const GltfNumbers& numbers, size_t i) {
      return Eigen::Vector3f(float_of(numbers.at(i, 0)), float_of(numbers.at(i, 1)),
                             float_of(numbers.at(i, 2)));
    };
    const bool harmonic = !attribute(attributes, coefficient_name(0, 0)).is_null();
    const bool with_opacity = !attribute(attributes, "OPACITY").is_null();
    if (harmonic) {
      const auto dc = required(coefficient_name(0, 0).c_str(), 3);
      if (!dc) return dc.error();
      for (size_t i = 0; i < asset.size(); ++i) asset.sh_dc[i] = vector(*dc, i);
    }
    const Json& colour_index = member_of(attributes, "COLOR_0");
    if (!harmonic || !with_opacity) {
      auto colour = document_.numbers(colour_index, 4);
      if (!colour && with_opacity) colour = document_.numbers(colour_index, 3);
      if (!colour)
        return document_.problem(
            "a splat primitive has no SH_DEGREE_0_COEF_0 and OPACITY, and no COLOR_0 with four components");
      if (colour->count != asset.size())
        return document_.problem("COLOR_0 has another number of elements than POSITION");
      for (size_t i = 0; i < asset.size(); ++i) {
        if (!harmonic) asset.sh_dc[i] = (vector(*colour, i).array() - 0.5f) / kShBand0;
        if (!with_opacity) asset.opacity_logits[i] = logit(colour->at(i, 3));
      }
    }
    if (with_opacity) {
      const auto opacity = required("OPACITY", 1);
      if (!opacity) return opacity.error();
      for (size_t i = 0; i < asset.size(); ++i) asset.opacity_logits[i] = logit(opacity->at(i, 0));
    }
    const size_t rest = asset.sh_rest_count();
    size_t k = 0;
    for (int degree = 1; degree <= asset.sh_degree; ++degree) {
      for (int n = 0; n < 2 * degree + 1; ++n, ++k) {
        const auto values = required(coefficient_name(degree, n).c_str(), 3);
        if (!values) return values.error();
        for (size_t i = 0; i < asset.size(); ++i) asset.sh_rest[i * rest + k] = vector(*values, i);
      }
    }
    return {};
  }

  // Infinite for 0 and 1, which establish_invariants repairs; NaN stays NaN.
  static float logit(double opacity) {
    const double clamped = opacity < 0 ? 0 : opacity > 1 ? 1 : opacity;
    return float_of(std::log(clamped / (1 - clamped)));
  }

  const GltfDocument& document_;
  std::map<const Json*, GltfKernels>
      decoded_;  // .spz views, by their entry: decoded once, however many nodes use them
  GltfKernels all_;
  uint64_t count_ = 0;     // of kernels, over all calls
  bool unmarked_ = false;  // a primitive without the antialiased mark
  std::vector<std::string> notes_;
};

Result<AssetFile> read_gltf(Bytes bytes, const std::filesystem::path& folder, std::string_view name) {
  const auto document = GltfDocument::open(bytes, folder, name);
  if (!document) return document.error();
  return GltfSplats(*document).read();
}

GltfMeshReader::GltfMeshReader(const GltfDocument& document)
    : splats_(std::make_unique<GltfSplats>(document)) {}
GltfMeshReader::~GltfMeshReader() = default;
Result<GaussianAsset> GltfMeshReader::read(const Json& index) { return splats_->read_mesh(index); }
Result<size_t> GltfMeshReader::count(const Json& index) { return splats_->count_mesh(index); }

}  // namespace livegs
