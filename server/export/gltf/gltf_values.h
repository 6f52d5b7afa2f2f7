// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "export/portable_scene.h"
#include "gaussian/gltf/gltf_document.h"

// Private to the reader of glTF: checked values of the document, and the readers of its parts. `where` names
// the place in errors: "nodes[3]".

namespace livegs::gltf {

using Json = nlohmann::json;

// Largest number of a node, a mass, a measure.
inline constexpr double kMaxNumber = 1e15;

// A member of an object; null if there is none.
const Json& part_of(const Json& object, const char* key);
const Json& extension_of(const Json& object, const char* name);
bool flag_of(const Json& object, const char* key);
std::string text_of(const Json& object, const char* key);
std::string name_of_node(size_t index);
// Whether `json` is a valid message; unknown fields are ignored.
bool read_message(const Json& json, google::protobuf::Message& message);

class Values {
 public:
  explicit Values(const GltfDocument& document) : document_(document) {}

  const GltfDocument& document() const { return document_; }
  Error problem(const std::string& what) const {
    return with_remedy(document_.problem(what), "export the file again");
  }
  Error bad(const std::string& where, const std::string& what) const { return problem(where + " " + what); }

  Result<double> number(const Json& object, const char* key, double fallback,
                        const std::string& where) const {
    const Json& value = part_of(object, key);
    if (value.is_null()) return fallback;
    const double got = value.is_number() ? value.get<double>() : NAN;
    if (!(std::abs(got) <= kMaxNumber)) return bad(where, std::string("has no valid ") + key);
    return got;
  }

  // Counts numbers that are kept.
  Result<void> spend(size_t count) const {
    spent_ += count;
    if (spent_ <= kMaxRepeats * document_.total_bytes()) return {};
    return problem("repeats its numbers more often than a file of its size may");
  }

  template <int N>
  Result<Eigen::Matrix<double, N, 1>> numbers(const Json& object, const char* key,
                                              const Eigen::Matrix<double, N, 1>& fallback,
                                              const std::string& where) const {
    const Json& value = part_of(object, key);
    if (value.is_null()) return fallback;
    Eigen::Matrix<double, N, 1> got;
    bool valid = value.is_array() && value.size() == static_cast<size_t>(N);
    for (size_t i = 0; valid && i < static_cast<size_t>(N); ++i) {
      got[static_cast<int>(i)] = value[i].is_number() ? value[i].get<double>() : NAN;
      valid = std::abs(got[static_cast<int>(i)]) <= kMaxNumber;
    }
    if (!valid) return bad(where, std::string("has no valid ") + key);
    return got;
  }
  Result<Eigen::Vector3d> vector(const Json& object, const char* key, const Eigen::Vector3d& fallback,
                                 const std::string& where) const {
    return numbers<3>(object, key, fallback, where);
  }
  Result<Eigen::Quaterniond> quaternion(const Json& object, const char* key, const std::string& where) const {
    const auto read = numbers<4>(object, key, Eigen::Vector4d(0, 0, 0, 1), where);
    if (!read) return read.error();
    if (!(read->norm() > 0.5 && read->norm() < 2)) return bad(where, std::string("has no valid ") + key);
    return Eigen::Quaterniond(read->normalized());
  }
  // The values of a scalar accessor of whole numbers.
  Result<std::vector<uint32_t>> whole_numbers(const Json& accessor) const;
  // The entry of `list` that `index` names.
  Result<const Json*> entry_of(const Json& list, const Json& index, const std::string& where,
                               const char* key) const;

 private:
  // Nodes may share meshes and accessors: the numbers of all together take at most this many times the bytes
  // of the file.
  static constexpr uint64_t kMaxRepeats = 32;

  const GltfDocument& document_;
  mutable uint64_t spent_ = 0;
};

// A collider of KHR_physics_rigid_bodies, without its place.
Result<PortableShape> read_collider(const Values& values, const Json& collider, const std::string& where);
// `elastic` of LIVEGS_physics.
Result<PortableElastic> read_elastic(const Values& values, const Json& elastic, const std::string& where);
// The animation whose times `own`, the extension of the document, names; none without times. `body_of_node`:
// indices in `bodies`.
Result<std::optional<PortableAnimation>> read_animation(const Values& values, const Json& own,
                                                        const std::vector<PortableBody>& bodies,
                                                        const std::map<size_t, size_t>& body_of_node);

}  // namespace livegs::gltf
