// SPDX-License-Identifier: Apache-2.0
#include "viewer/panels/part_list.h"

#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

// Corners of new boxes are rounded away from the body to this, so that the numbers are short.
constexpr double kCornerStep_m = 1e-4;

v1::MaterialPart::Box upper_half(const Eigen::AlignedBox3d& body_m) {
  v1::MaterialPart::Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = axis == 1 ? body_m.center().y() : body_m.min()[axis];
    box.add_min_m(std::floor(low / kCornerStep_m) * kCornerStep_m);
    box.add_max_m(std::ceil(body_m.max()[axis] / kCornerStep_m) * kCornerStep_m);
  }
  return box;
}

}  // namespace

PartList::PartList(MaterialParts parts) : parts_(std::move(parts)) {
  for (auto part = parts_.begin(); part != parts_.end(); ++part) {
    part->clear_density_kg_m3();
    const bool taken = std::any_of(parts_.begin(), part,
                                   [&](const auto& earlier) { return earlier.name() == part->name(); });
    if (part->name().empty() || taken) part->set_name(unused_name());
  }
}

bool PartList::operator==(const PartList& other) const {
  return std::equal(parts_.begin(), parts_.end(), other.parts_.begin(), other.parts_.end(),
                    [](const v1::MaterialPart& a, const v1::MaterialPart& b) {
                      return google::protobuf::util::MessageDifferencer::Equals(a, b);
                    });
}

v1::MaterialPart* PartList::at(size_t part) {
  return part < static_cast<size_t>(parts_.size()) ? &parts_[static_cast<int>(part)] : nullptr;
}

std::string PartList::unused_name() const {
  for (int number = 1;; ++number) {
    std::string name = "part " + std::to_string(number);
    if (std::none_of(parts_.begin(), parts_.end(), [&](const auto& part) { return part.name() == name; }))
      return name;
  }
}

// Scales the shares of all parts but one to this sum; equal shares if they have none.
void PartList::scale_to(double sum, const v1::MaterialPart* except) {
  double before = 0;
  int count = 0;
  for (const v1::MaterialPart& part : parts_) {
    if (&part == except) continue;
    before += part.mass_share();
    ++count;
  }
  for (v1::MaterialPart& part : parts_) {
    if (&part != except) part.set_mass_share(before > 0 ? part.mass_share() * (sum / before) : sum / count);
  }
}

void PartList::rename(size_t part, const std::string& name) {
  if (auto* one = at(part)) one->set_name(name);
}

void PartList::set_material(size_t part, const std::string& material) {
  if (auto* one = at(part)) one->set_material(material);
}

void PartList::set_share(size_t part, double share) {
  v1::MaterialPart* one = at(part);
  if (!one || !std::isfinite(share)) return;
  one->set_mass_share(parts_.size() == 1 ? 1.0 : std::clamp(share, 0.0, 1.0));
  scale_to(1.0 - one->mass_share(), one);
}

void PartList::add(const std::string& material, const Eigen::AlignedBox3d& body_m) {
  if (body_m.isEmpty()) return;
  const auto append = [&]() -> v1::MaterialPart& {
    const std::string name = unused_name();
    v1::MaterialPart& part = *parts_.Add();
    part.set_name(name);
    part.set_material(material);
    return part;
  };
  if (parts_.empty()) append();
  v1::MaterialPart& added = append();
  *added.add_boxes() = upper_half(body_m);
  set_share(static_cast<size_t>(parts_.size() - 1), 1.0 / parts_.size());
}

void PartList::remove(size_t part) {
  if (!at(part) || parts_.size() < 2) return;
  parts_.DeleteSubrange(static_cast<int>(part), 1);
  scale_to(1.0, nullptr);
  if (parts_.size() == 1) parts_[0].clear_boxes();
}

void PartList::add_box(size_t part, const Eigen::AlignedBox3d& body_m) {
  if (auto* one = at(part); one && !body_m.isEmpty()) *one->add_boxes() = upper_half(body_m);
}

void PartList::remove_box(size_t part, size_t box) {
  auto* one = at(part);
  if (one && box < static_cast<size_t>(one->boxes_size()))
    one->mutable_boxes()->DeleteSubrange(static_cast<int>(box), 1);
}

void PartList::move_box(size_t part, size_t box, const v1::MaterialPart::Box& to) {
  auto* one = at(part);
  if (one && box < static_cast<size_t>(one->boxes_size())) *one->mutable_boxes(static_cast<int>(box)) = to;
}

}  // namespace livegs
