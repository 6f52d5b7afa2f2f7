// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/division/part_places.h"

#include <algorithm>
#include <cmath>

#include "analysis/knowledge/tables.h"
#include "core/text/format_text.h"
#include "core/text/shown_text.h"

namespace livegs {
namespace {

// Deviation from 1 of the sum of the shares that rounding by hand may leave.
constexpr double kShareSlack = 0.02;
// Bytes. Longer names fill a line of a table or panel.
constexpr size_t kMaxPartName = 80;

Result<void> check_box(const v1::MaterialPart::Box& box, const std::string& field) {
  for (const auto& [name, corner] : {std::pair("min_m", &box.min_m()), std::pair("max_m", &box.max_m())}) {
    const bool finite =
        std::all_of(corner->begin(), corner->end(), [](double one) { return std::abs(one) <= 1e4; });
    if ((corner->size() != 0 && corner->size() != 3) || !finite)
      return invalid_argument(field + "." + name + ": must be three numbers between -10000 and 10000");
  }
  const Eigen::AlignedBox3d sides = part_box(box);
  if (!(sides.min().array() < sides.max().array()).all())
    return invalid_argument(field + ": min_m is not below max_m; swap them");
  return {};
}

// The name of part i: given, short, and none of an earlier part.
Result<void> check_name(const MaterialParts& parts, int i, const std::string& field) {
  const std::string& name = parts[i].name();
  if (name.empty()) return invalid_argument(field + ".name: is empty; give the part a name");
  if (name.size() > kMaxPartName)
    return invalid_argument(field +
                            format_text(".name: has %zu bytes; give at most %zu", name.size(), kMaxPartName));
  const bool taken = std::any_of(parts.begin(), parts.begin() + i,
                                 [&](const v1::MaterialPart& earlier) { return earlier.name() == name; });
  if (taken)
    return invalid_argument(field + ".name: \"" + shown_text(name, 60) +
                            "\" is already that of another part; give another name");
  return {};
}

}  // namespace

void set_boxes(std::span<const Eigen::AlignedBox3d> boxes, v1::MaterialPart& part) {
  part.clear_boxes();
  for (const Eigen::AlignedBox3d& box : boxes) {
    v1::MaterialPart::Box& written = *part.add_boxes();
    if (box.min().allFinite()) written.mutable_min_m()->Add(box.min().data(), box.min().data() + 3);
    if (box.max().allFinite()) written.mutable_max_m()->Add(box.max().data(), box.max().data() + 3);
  }
}

void scale_parts(double factor, MaterialParts& parts) {
  for (v1::MaterialPart& part : parts) {
    for (v1::MaterialPart::Box& box : *part.mutable_boxes()) {
      for (double& one : *box.mutable_min_m()) one *= factor;
      for (double& one : *box.mutable_max_m()) one *= factor;
    }
  }
}

std::string part_line(const v1::MaterialPart& part) {
  std::string line = shown_text(part.name(), 40) + " of " + shown_text(part.material(), 60) +
                     format_text(", %.0f %% of the mass", 100 * part.mass_share());
  if (part.density_kg_m3() > 0) line += format_text(", %.3g kg/m3", part.density_kg_m3());
  if (part.boxes_size() > 0)
    line += format_text(", %d %s", part.boxes_size(), part.boxes_size() == 1 ? "box" : "boxes");
  return line;
}

Result<void> check_parts(const MaterialParts& parts) {
  if (parts.empty()) return {};
  if (parts.size() > kMaxMaterialParts)
    return invalid_argument(
        format_text("parts: %d are given; give at most %d", parts.size(), kMaxMaterialParts));
  double sum = 0;
  for (int i = 0; i < parts.size(); ++i) {
    const v1::MaterialPart& part = parts[i];
    const std::string field = "parts[" + std::to_string(i) + "]";
    if (auto checked = check_name(parts, i, field); !checked) return checked;
    if (!find_material_row(part.material())) {
      return invalid_argument(field + ".material: \"" + shown_text(part.material(), 60) +
                              "\" is not in the table; give a name of materials.csv");
    }
    if (!(part.mass_share() >= 0 && part.mass_share() <= 1))
      return invalid_argument(
          field + format_text(".mass_share: is %g; it must be between 0 and 1", part.mass_share()));
    const double modulus_pa = part.youngs_modulus_pa();
    if (!(modulus_pa == 0 || (modulus_pa >= 1 && modulus_pa <= 1e12)))
      return invalid_argument(
          field + format_text(".youngs_modulus_pa: is %g; it must be between 1 and 1e+12", modulus_pa));
    if (part.boxes_size() > kMaxPartBoxes)
      return invalid_argument(
          field + format_text(".boxes: has %d; give at most %d", part.boxes_size(), kMaxPartBoxes));
    for (int k = 0; k < part.boxes_size(); ++k) {
      auto checked = check_box(part.boxes(k), field + ".boxes[" + std::to_string(k) + "]");
      if (!checked) return checked;
    }
    sum += part.mass_share();
  }
  if (std::abs(sum - 1) > kShareSlack)
    return invalid_argument(format_text("parts: the mass shares sum to %g; they must sum to 1", sum));
  return {};
}

}  // namespace livegs
