// SPDX-License-Identifier: Apache-2.0
#include "server/export/gltf_structure.h"

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>

namespace livegs {
namespace {

using Json = nlohmann::json;

class Structure {
 public:
  explicit Structure(const GltfFiles& files) : bytes_(files.binary), json_(Json::parse(files.json)) {}

  std::vector<std::string> violations() {
    check_buffers();
    for (size_t i = 0; i < size_of("accessors"); ++i) check_accessor(i);
    check_nodes();
    check_meshes();
    check_animations();
    check_physics();
    std::set<std::string> used;
    collect_extensions(json_, used);
    std::set<std::string> stated;
    for (const Json& name : json_.value("extensionsUsed", Json::array())) stated.insert(name);
    if (used != stated) add("extensionsUsed differs from the extensions that are used");
    return found_;
  }

 private:
  void add(const std::string& what) { found_.push_back(what); }
  size_t size_of(const char* list) const { return json_.contains(list) ? json_[list].size() : 0; }
  bool has(const char* list, const Json& index, const std::string& where) {
    const bool valid = index.is_number_unsigned() && index.get<size_t>() < size_of(list);
    if (!valid) add(where + " refers to no entry of " + list);
    return valid;
  }

  void check_buffers() {
    if (size_of("buffers") != (bytes_.empty() ? 0 : 1)) return add("there is not one buffer");
    if (!bytes_.empty() && json_["buffers"][0]["byteLength"] != bytes_.size())
      add("byteLength of the buffer");
    for (size_t i = 0; i < size_of("bufferViews"); ++i) {
      const Json& view = json_["bufferViews"][i];
      const size_t offset = view.value("byteOffset", 0u), length = view["byteLength"];
      const std::string where = "bufferViews[" + std::to_string(i) + "]";
      if (length == 0) add(where + " is empty");
      if (offset % 4 != 0) add(where + " is not aligned");
      if (offset > bytes_.size() || length > bytes_.size() - offset) add(where + " ends beyond its buffer");
    }
  }

  static size_t components_of(const Json& accessor) {
    const std::string type = accessor["type"];
    return type == "SCALAR" ? 1 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 0;
  }
  static size_t bytes_of(const Json& accessor) {
    const int type = accessor["componentType"];
    return type == 5121 ? 1 : type == 5125 || type == 5126 ? 4 : 0;
  }
  double at(const Json& accessor, size_t i) const {
    const size_t offset =
        json_["bufferViews"][accessor["bufferView"].get<size_t>()].value("byteOffset", size_t{0});
    float value;
    std::memcpy(&value, bytes_.data() + offset + i * sizeof value, sizeof value);
    return static_cast<double>(value);
  }

  void check_accessor(size_t i) {
    const Json& accessor = json_["accessors"][i];
    const std::string where = "accessors[" + std::to_string(i) + "]";
    const size_t components = components_of(accessor), bytes = bytes_of(accessor);
    if (components == 0 || bytes == 0) return add(where + " has an unknown type");
    const size_t count = accessor["count"];
    if (count == 0) add(where + " is empty");
    if (!accessor.contains("bufferView")) return;  // compressed
    if (!has("bufferViews", accessor["bufferView"], where)) return;
    const size_t length = json_["bufferViews"][accessor["bufferView"].get<size_t>()]["byteLength"];
    if (count * components * bytes != length) add(where + " does not fill its view");
    if (accessor["componentType"] != 5126) return;
    for (size_t k = 0; k < count * components; ++k) {
      if (!std::isfinite(at(accessor, k))) return add(where + " has a number that is not finite");
    }
    if (!accessor.contains("min")) return;
    for (size_t c = 0; c < components; ++c) {
      double low = INFINITY, high = -INFINITY;
      for (size_t k = c; k < count * components; k += components) {
        low = std::min(low, at(accessor, k));
        high = std::max(high, at(accessor, k));
      }
      if (accessor["min"][c] != low || accessor["max"][c] != high) add(where + " has other bounds");
    }
  }

  void check_nodes() {
    std::vector<int> parents(size_of("nodes"), 0);
    for (size_t i = 0; i < size_of("nodes"); ++i) {
      const Json& node = json_["nodes"][i];
      const std::string where = "nodes[" + std::to_string(i) + "]";
      if (node.contains("mesh")) has("meshes", node["mesh"], where);
      for (const Json& child : node.value("children", Json::array())) {
        if (has("nodes", child, where)) ++parents[child.get<size_t>()];
      }
      if (node.contains("rotation")) {
        double square = 0;
        for (const Json& number : node["rotation"]) square += number.get<double>() * number.get<double>();
        if (std::abs(square - 1) > 1e-6) add(where + " has a rotation that is not unit");
      }
    }
    for (const Json& scene : json_["scenes"]) {
      for (const Json& root : scene.value("nodes", Json::array())) {
        if (!has("nodes", root, "a scene")) continue;
        if (parents[root.get<size_t>()] > 0) add("a root has a parent");
      }
    }
    for (const int count : parents) {
      if (count > 1) add("a node has two parents");
    }
  }

  void check_meshes() {
    for (size_t i = 0; i < size_of("meshes"); ++i) {
      for (const Json& primitive : json_["meshes"][i]["primitives"]) {
        const std::string where = "meshes[" + std::to_string(i) + "]";
        std::set<size_t> counts;
        for (const auto& [name, accessor] : primitive["attributes"].items()) {
          if (!has("accessors", accessor, where + " " + name)) continue;
          const Json& entry = json_["accessors"][accessor.get<size_t>()];
          counts.insert(entry["count"].get<size_t>());
          if (name == "POSITION" && !entry.contains("min")) add(where + " has positions without bounds");
        }
        if (counts.size() != 1) add(where + " has attributes of different lengths");
        if (!primitive.contains("indices") || !has("accessors", primitive["indices"], where)) continue;
        const Json& indices = json_["accessors"][primitive["indices"].get<size_t>()];
        const size_t offset =
            json_["bufferViews"][indices["bufferView"].get<size_t>()].value("byteOffset", size_t{0});
        for (size_t k = 0; k < indices["count"].get<size_t>(); ++k) {
          uint32_t index;
          std::memcpy(&index, bytes_.data() + offset + 4 * k, 4);
          if (index >= *counts.begin()) {
            add(where + " has an index beyond its vertices");
            break;
          }
        }
      }
    }
  }

  void check_animations() {
    for (const Json& animation : json_.value("animations", Json::array())) {
      std::set<std::pair<size_t, std::string>> targets;
      for (const Json& channel : animation["channels"]) {
        const Json& target = channel["target"];
        has("nodes", target["node"], "a channel");
        if (!targets.emplace(target["node"].get<size_t>(), target["path"].get<std::string>()).second)
          add("a node has two channels of one path");
        if (channel["sampler"].get<size_t>() >= animation["samplers"].size()) add("a channel has no sampler");
      }
      for (const Json& sampler : animation["samplers"]) {
        if (!has("accessors", sampler["input"], "a sampler") ||
            !has("accessors", sampler["output"], "a sampler"))
          continue;
        const Json& input = json_["accessors"][sampler["input"].get<size_t>()];
        const Json& output = json_["accessors"][sampler["output"].get<size_t>()];
        if (!input.contains("min")) add("times have no bounds");
        if (input["count"] != output["count"]) add("a sampler has more times than values");
        for (size_t k = 1; k < input["count"].get<size_t>(); ++k) {
          if (!(at(input, k) > at(input, k - 1))) add("times do not increase");
        }
      }
    }
  }

  void check_physics() {
    const Json extensions = json_.value("extensions", Json::object());
    const Json bodies = extensions.value("KHR_physics_rigid_bodies", Json::object());
    const auto count = [&](const Json& of, const char* list) {
      return of.contains(list) ? of[list].size() : size_t{0};
    };
    const size_t shapes = count(extensions.value("KHR_implicit_shapes", Json::object()), "shapes");
    for (const Json& node : json_.value("nodes", Json::array())) {
      const Json own =
          node.value("extensions", Json::object()).value("KHR_physics_rigid_bodies", Json::object());
      if (own.contains("collider")) {
        const Json& collider = own["collider"];
        const Json& geometry = collider["geometry"];
        if (geometry.contains("shape") == geometry.contains("node")) add("a collider has not one geometry");
        if (geometry.contains("shape") && geometry["shape"].get<size_t>() >= shapes)
          add("a collider has no shape");
        if (geometry.contains("node")) {
          has("nodes", geometry["node"], "a collider");
          has("meshes", geometry["mesh"], "a collider");
        }
        if (collider["physicsMaterial"].get<size_t>() >= count(bodies, "physicsMaterials"))
          add("a collider has no material");
      }
      if (own.contains("joint")) {
        has("nodes", own["joint"]["connectedNode"], "a joint");
        if (own["joint"]["joint"].get<size_t>() >= count(bodies, "physicsJoints"))
          add("a joint has no limits");
      }
    }
  }

  static void collect_extensions(const Json& json, std::set<std::string>& used) {
    if (json.is_object()) {
      for (const auto& [key, value] : json.items()) {
        if (key == "extensions" && value.is_object()) {
          for (const auto& [name, extension] : value.items()) used.insert(name);
        }
        collect_extensions(value, used);
      }
    } else if (json.is_array()) {
      for (const Json& value : json) collect_extensions(value, used);
    }
  }

  const std::vector<std::byte>& bytes_;
  const Json json_;
  std::vector<std::string> found_;
};

}  // namespace

std::vector<std::string> gltf_violations(const GltfFiles& files) { return Structure(files).violations(); }

}  // namespace livegs
