// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "livegs/v1/physics.pb.h"

namespace livegs {

using MaterialParts = google::protobuf::RepeatedPtrField<v1::MaterialPart>;

// Limits of a division. More parts are not distinguished by eye or in a table; more boxes than these follow
// noise of the kernels instead of the form.
inline constexpr int kMaxMaterialParts = 8, kMaxPartBoxes = 16;

// The places of the parts of an object, read once from their boxes (MaterialPart::boxes has the rule).
class PartPlaces {
 public:
  struct Box {
    Eigen::AlignedBox3d box;  // object frame at rest, metres; open sides are infinite
    size_t part;
  };
  explicit PartPlaces(const MaterialParts& parts);

  bool divided() const { return !boxes_.empty(); }       // false: the object is homogeneous
  size_t rest() const { return rest_; }                  // part of all points outside the boxes
  std::span<const Box> boxes() const { return boxes_; }  // a later box applies before an earlier one
  size_t at(const Eigen::Vector3d& point_m) const;       // index of the part; precondition: divided

 private:
  std::vector<Box> boxes_;
  size_t rest_ = 0;
};

// Sets the boxes of a part; a corner with an infinite coordinate is left out, so that its sides are open.
void set_boxes(std::span<const Eigen::AlignedBox3d> boxes, v1::MaterialPart& part);
// Multiplies all boxes, for an object whose size changes.
void scale_parts(double factor, MaterialParts& parts);
// Colour of a part in pictures, 0 … 1, display-encoded; distinct for the first kMaxMaterialParts.
Eigen::Vector3f part_rgb(size_t part);
// One line: "pot of terracotta, 40 % of the mass, 1900 kg/m3, 2 boxes"; what is unknown is left out.
std::string part_line(const v1::MaterialPart& part);
// Checks materials, shares, limits and boxes that a person or an author wrote. The error begins with
// "parts[0].mass_share" or the like.
Result<void> check_parts(const MaterialParts& parts);

}  // namespace livegs
