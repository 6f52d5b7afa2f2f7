// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <functional>

#include "analysis/estimate/log_normal.h"
#include "analysis/estimate/object_classes.h"

// The widths below are judgements, not fits. They cover the variation within a class and the error of a
// surface reconstructed from kernels.

namespace livegs {
namespace {

constexpr double kProportionSd = 0.3;      // of the logarithms of the box's two ratios, within a class
constexpr double kGuessedSizeLogSd = 0.7;  // of the logarithm of a guessed size: a factor of 2 either way

double normal(double value, double sd) { return std::exp(-0.5 * value * value / (sd * sd)) / sd; }

// Normal density with a broad tail, so that one odd measurement never excludes a class.
double forgiving(double value, double sd) {
  return (1 - kBroadShare) * normal(value, sd) + kBroadShare * normal(value, std::max(sd, kBroadSd));
}

double size_fit(const ObjectRow& row, const ObjectFacts& facts) {
  const Eigen::Vector3d box_m = sorted_box_m(facts.mesh).cwiseMax(1e-5);
  const double longest = std::log(box_m[0]), middle = std::log(box_m[1]), shortest = std::log(box_m[2]);
  const double usual_longest = std::log(row.size_m.best), usual_middle = std::log(row.middle_m),
               usual_shortest = std::log(row.short_m);
  // The range in the table encloses 90 %.
  double sd = std::max(0.12, std::log(row.size_m.high / row.size_m.low) / 3.29);
  if (!facts.scale_known) sd = std::hypot(sd, kGuessedSizeLogSd);
  const double size = (longest + middle + shortest - usual_longest - usual_middle - usual_shortest) / 3;
  return forgiving(size, sd) * forgiving(longest - middle - usual_longest + usual_middle, kProportionSd) *
         forgiving(middle - shortest - usual_middle + usual_shortest, kProportionSd);
}

// Box filling of a class and its spread (of the logarithm). The spread grows with emptiness, and captured
// walls and frames increase it further.
struct Filling {
  double usual, sd;
};
Filling usual_filling(const ObjectRow& row, bool hollow_seen) {
  if (row.fill == v1::Physics::OPEN_SHELL) return hollow_seen ? Filling{0.2, 0.8} : Filling{0.5, 0.5};
  if (row.category == "ball") return {row.box_filling, 0.12};
  return {row.box_filling, 0.12 + 0.7 * (1 - row.box_filling)};
}

double shape_fit(const ObjectRow& row, const MeshFacts& mesh) {
  double fit = 1;
  const bool open_kind = row.fill == v1::Physics::OPEN_SHELL, hollow_seen = mesh.openness > 0.2;
  // A hollow that is seen implies an open class. In one of three open objects haze closes the hollow.
  if (!open_kind && hollow_seen) fit *= std::max(0.1, 1 - 2 * (mesh.openness - 0.2));
  if (open_kind && !hollow_seen && mesh.solidity > 0.6) fit *= 0.33;
  // A wall of the mesh is not thinner than the real one, except for noise. Most are thicker, in scans and
  // alpha shapes.
  if (open_kind && mesh.mean_wall_m > 0 && mesh.mean_wall_m < row.wall_m.low) {
    fit *= std::max(0.02, std::exp(-0.5 * std::pow(std::log(mesh.mean_wall_m / row.wall_m.low) / 0.3, 2)));
  }
  const double box_m3 = sorted_box_m(mesh).prod();
  if (box_m3 > 0 && mesh.volume_m3 > 0) {
    const Filling filling = usual_filling(row, hollow_seen);
    fit *= forgiving(std::log(mesh.volume_m3 / box_m3 / filling.usual), filling.sd);
  }
  return fit;
}

// Tie-break by appearance: colours carry little information about mass.
double looks_fit(const MaterialRow& material, const AppearanceFacts& look) {
  const Eigen::Vector3f& rgb = look.mean_rgb;
  const std::string& kind = material.material_class;
  if (look.mean_opacity > 0 && look.mean_opacity < 0.35f && look.saturation < 0.25f) {
    return kind == "glass" ? 3 : kind == "plastic" ? 1.5 : 1;  // semi-transparent and colourless
  }
  if (look.saturation > 0.25f && rgb.y() > 1.1f * rgb.x() && rgb.y() > 1.2f * rgb.z()) {
    return kind == "plant" ? 3 : 1;  // mostly green
  }
  if (look.saturation > 0.3f && look.hue_spread < 0.5f && rgb.x() > 1.15f * rgb.y() &&
      rgb.y() > 1.15f * rgb.z()) {
    return kind == "wood" ? 2 : kind == "textile" || kind == "food" ? 1.3 : 1;  // brown throughout
  }
  if (look.saturation > 0.6f) return kind == "plastic" ? 1.5 : kind == "stone" || kind == "wood" ? 0.5 : 1;
  if (look.saturation < 0.12f && look.mean_opacity > 0) {
    return kind == "stone" || kind == "ceramic" || kind == "metal" ? 1.3 : kind == "food" ? 0.6 : 1;
  }
  return 1;
}

}  // namespace

Eigen::Vector3d sorted_box_m(const MeshFacts& mesh) {
  Eigen::Vector3d box_m = mesh.box_m.minCoeff() > 0 ? mesh.box_m : mesh.size_m;
  std::sort(box_m.data(), box_m.data() + 3, std::greater<>());
  return box_m;
}

double min_drawn_wall_m(const MeshFacts& mesh) { return 0.03 * sorted_box_m(mesh).norm(); }

double kind_likelihood(const ObjectRow& row, const ObjectFacts& facts) {
  return size_fit(row, facts) * shape_fit(row, facts.mesh) *
         looks_fit(material_row(row.material), facts.appearance);
}

}  // namespace livegs
