// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "livegs/v1/physics.pb.h"

namespace livegs {

using MaterialParts = google::protobuf::RepeatedPtrField<v1::MaterialPart>;

// Maximum number of parts. More are hard to distinguish by eye or in a table.
inline constexpr int kMaxMaterialParts = 8;

// A box of a part; a corner that is not given is open.
Eigen::AlignedBox3d part_box(const v1::MaterialPart::Box& box);

// The places of the parts of an object, read once from their boxes (MaterialPart::boxes has the rule).
class PartPlaces {
 public:
  struct Box {
    Eigen::AlignedBox3d box;  // object frame at rest, metres; open sides are infinite
    size_t part;
    bool operator==(const Box& other) const {
      return box.min() == other.box.min() && box.max() == other.box.max() && part == other.part;
    }
  };
  explicit PartPlaces(const MaterialParts& parts);

  bool divided() const { return !boxes_.empty(); }       // false: the object is homogeneous
  size_t rest() const { return rest_; }                  // part of all points outside the boxes
  std::span<const Box> boxes() const { return boxes_; }  // a later box applies before an earlier one
  size_t at(const Eigen::Vector3d& point_m) const;       // index of the part; precondition: divided
  bool operator==(const PartPlaces&) const = default;

 private:
  std::vector<Box> boxes_;
  size_t rest_ = 0;
};

// Colour of a part in pictures, 0 … 1, display-encoded; distinct for the first kMaxMaterialParts.
Eigen::Vector3f part_rgb(size_t part);
// The same for a kernel of its own colour: the brightness of the kernel shades the colour of the part by up
// to a half, so that the shape stays visible.
Eigen::Vector3f shaded_part_rgb(size_t part, const Eigen::Vector3f& own_rgb);

}  // namespace livegs
