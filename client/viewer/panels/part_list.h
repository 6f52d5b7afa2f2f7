// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <string>

#include "material/part_places.h"

namespace livegs {

// The parts of an object while a user corrects them. Shares sum to 1 after each edit: the others are scaled
// in proportion. Indices that do not exist are ignored. The server checks the rest.
class PartList {
 public:
  // Drops the densities, which follow from the body, and names parts that have no name or that of an earlier
  // one.
  explicit PartList(MaterialParts parts);
  const MaterialParts& parts() const { return parts_; }
  bool operator==(const PartList& other) const;

  void rename(size_t part, const std::string& name);
  void set_material(size_t part, const std::string& material);
  void set_share(size_t part, double share);  // 0 to 1; of a single part always 1
  // Adds a part in the upper half of the body, object frame. An undivided object first gets a part of
  // `material` that has the rest.
  void add(const std::string& material, const Eigen::AlignedBox3d& body_m);
  void remove(size_t part);  // the last one has the whole object, without boxes
  void add_box(size_t part, const Eigen::AlignedBox3d& body_m);  // in the upper half
  void remove_box(size_t part, size_t box);
  void move_box(size_t part, size_t box, const v1::MaterialPart::Box& to);

 private:
  v1::MaterialPart* at(size_t part);
  std::string unused_name() const;
  void scale_to(double sum, const v1::MaterialPart* except);

  MaterialParts parts_;
};

}  // namespace livegs
