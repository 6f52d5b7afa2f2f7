// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/estimate/class_mass.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "analysis/knowledge/value_ranges.h"
#include "analysis/text/message_templates.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

// Ranges in the tables enclose 90 %: 3.29 standard deviations wide.
constexpr double kRange90Deviations = 3.29;
// Standard deviation of the logarithm of a captured surface's volume and area. Sheets and threads are drawn
// as thick as the surface radius allows, so their volume is uncertain.
constexpr double kVolumeSd = 0.15, kThinVolumeSd = 0.6, kAreaSd = 0.15;
// Upper bound of ln(thickening) of unresolved features. A judgement.
constexpr double kMaxThickening_ln = 0.25;
// Lower bound of the sd of ln(mass) for estimates from appearance.
constexpr double kMinSd = 0.05;
// Additional sd of ln(mass) for a material unusual in the class.
constexpr double kOtherMaterialSd = 0.35;
// Sd of the logarithm of a guessed size, as in kind_likelihood.
constexpr double kGuessedSizeSd = 0.7;

const MessageTemplates& reasons() { return MessageTemplates::reasons(); }

double log_sd(const Span3& span) {
  return std::max(0.01, std::log(span.high / span.low) / kRange90Deviations);
}

bool walled(const ObjectRow& row) {
  return row.fill == v1::Physics::SHELL || row.fill == v1::Physics::OPEN_SHELL;
}

// Usual wall thickness of objects of a material.
Span3 usual_wall_m(const MaterialRow& material) {
  const auto mm = [](double low, double best, double high) {
    return Span3{1e-3 * low, 1e-3 * best, 1e-3 * high};
  };
  const std::string& kind = material.material_class;
  if (kind == "metal") return mm(0.5, 0.9, 2);
  if (kind == "plastic") return mm(1, 2, 3.5);
  if (kind == "glass") return mm(1.8, 3, 5);
  if (kind == "ceramic") return mm(3, 5, 8);
  if (kind == "wood") return mm(4, 8, 15);
  if (kind == "stone") return mm(8, 15, 30);
  if (kind == "paper") return mm(0.5, 1.5, 4);
  return mm(1, 2.5, 6);
}

// Most likely size as a factor on the measured size, and its remaining uncertainty.
struct Size {
  double factor = 1, sd = 0;
};
Size true_size(const ObjectRow& row, const ObjectFacts& facts) {
  if (facts.scale_known) return {};
  const double usual_sd = std::max(0.12, std::log(row.size_m.high / row.size_m.low) / kRange90Deviations);
  const Eigen::Vector3d box_m = sorted_box_m(facts.mesh).cwiseMax(1e-5);
  // ln of the factor to the usual size.
  const double towards = std::log(row.size_m.best * row.middle_m * row.short_m / box_m.prod()) / 3;
  const double share =
      kGuessedSizeSd * kGuessedSizeSd / (kGuessedSizeSd * kGuessedSizeSd + usual_sd * usual_sd);
  return {std::exp(share * towards), usual_sd * std::sqrt(share)};
}

// Error of density times filled volume for the typical object of the class, in ln(mass). Assemblies are less
// full than their outline, so the surface of a bed or a chair gives little information.
double own_misfit(const ObjectRow& row) {
  const double volume_m3 = row.box_filling * row.size_m.best * row.middle_m * row.short_m;
  return std::log(row.mass_kg / (material_row(row.material).density_kg_m3.best * volume_m3));
}

struct PhysicsMass {
  LogNormal mass;
  double density_kg_m3 = 0, wall_m = 0, extent = 0;  // as in ClassMass
};

PhysicsMass physics_mass(const ObjectClass& kind, const ObjectFacts& facts) {
  const ObjectRow& row = *kind.row;
  const MeshFacts& mesh = facts.mesh;
  const MaterialRow& material = kind.material ? *kind.material : material_row(row.material);
  PhysicsMass physics;
  physics.density_kg_m3 = material.density_kg_m3.best;
  if (walled(row) && !facts.solid) {
    const Span3 wall_m = kind.material ? usual_wall_m(*kind.material) : row.wall_m;
    // The area of a captured hollow counts the wall twice, inside and outside.
    const bool both_sides =
        row.fill == v1::Physics::OPEN_SHELL && (mesh.openness > 0.15 || mesh.solidity < 0.6);
    const double area_m2 = std::max(both_sides ? 0.5 * mesh.area_m2 : mesh.area_m2, 1e-12);
    physics.mass = {std::log(material.density_kg_m3.best * wall_m.best * area_m2),
                    std::hypot(log_sd(material.density_kg_m3), log_sd(wall_m), kAreaSd)};
    physics.wall_m = wall_m.best;
    physics.extent = area_m2;
  } else {
    const double volume_m3 = std::max(mesh.volume_m3, 1e-12);
    // Features thinner than the surface radius are drawn too thick.
    const double resolved = mesh.mean_wall_m / min_drawn_wall_m(mesh);
    const double thin = std::clamp(1.5 - resolved, 0.0, 1.0);
    const double volume_sd = facts.solid ? 0.02 : kVolumeSd + (kThinVolumeSd - kVolumeSd) * thin;
    physics.mass = {
        std::log(material.density_kg_m3.best * volume_m3) - (facts.solid ? 0.0 : kMaxThickening_ln * thin),
        std::hypot(log_sd(material.density_kg_m3), volume_sd, facts.solid ? 0.0 : own_misfit(row))};
    physics.extent = volume_m3;
  }
  return physics;
}

LogNormal usual_mass(const ObjectClass& kind, const ObjectFacts& facts) {
  const ObjectRow& row = *kind.row;
  const double usual_box_m3 = row.size_m.best * row.middle_m * row.short_m;
  const double box_m3 = std::max(sorted_box_m(facts.mesh).prod(), 1e-15);
  LogNormal mass{std::log(row.mass_kg) + mass_exponent(row) / 3 * std::log(box_m3 / usual_box_m3),
                 row.mass_log_sd};
  if (kind.material) {
    const MaterialRow& own = material_row(row.material);
    double ratio = kind.material->density_kg_m3.best / own.density_kg_m3.best;
    if (walled(row)) ratio *= usual_wall_m(*kind.material).best / row.wall_m.best;
    mass.mean_ln += std::log(ratio);
    mass.sd = std::hypot(mass.sd, kOtherMaterialSd);
  }
  return mass;
}

std::string factors_of(const ClassMass& mass) {
  return mass.wall_m > 0 ? wall_factors(mass.density_kg_m3, mass.wall_m, mass.extent)
                         : volume_factors(mass.density_kg_m3, mass.extent);
}

std::string grams_or_kg(double mass_kg) {
  return mass_kg < 1 ? reasons().say("reason_grams", {{"mass", format_text("%.3g", mass_kg * 1e3)}})
                     : reasons().say("reason_kilograms", {{"mass", format_text("%.3g", mass_kg)}});
}

}  // namespace

ClassMass kind_mass(const ObjectClass& kind, const ObjectFacts& facts) {
  const LogNormal usual = usual_mass(kind, facts);
  const PhysicsMass physics = physics_mass(kind, facts);
  ClassMass result;
  if (facts.solid) {
    result.mass = physics.mass;  // given as a volume: no hidden hollow
  } else {
    result.mass = fuse(usual, physics.mass, kErrorCorrelation);
  }
  const Size size = true_size(*kind.row, facts);
  const double exponent = mass_exponent(*kind.row);
  result.mass.mean_ln += exponent * std::log(size.factor);
  result.mass.sd = std::max(kMinSd, std::hypot(result.mass.sd, exponent * size.sd));
  result.usual_kg = std::exp(usual.mean_ln);
  result.physics_kg = std::exp(physics.mass.mean_ln);
  result.physics_sd = physics.mass.sd;
  result.density_kg_m3 = physics.density_kg_m3;
  result.wall_m = physics.wall_m;
  result.extent = physics.extent;
  return result;
}

MassEstimate mass_of_classes(const ObjectClasses& kinds, const ObjectFacts& facts) {
  std::vector<WeightedLogNormal> mixture;
  for (const ObjectClass& kind : kinds.kinds)
    mixture.push_back({kind.probability, kind_mass(kind, facts).mass});
  const auto kilograms = [](double ln) {
    return std::clamp(std::exp(ln), kMassRange_kg.low, kMassRange_kg.high);
  };
  MassEstimate estimate;
  estimate.mass_kg = {kilograms(mixture_quantile_ln(mixture, 0.05)), kilograms(mixture_mean_ln(mixture)),
                      kilograms(mixture_quantile_ln(mixture, 0.95))};
  const ObjectClass& first = kinds.kinds.front();
  const ClassMass mass = kind_mass(first, facts);
  if (facts.solid) {
    estimate.reason = factors_of(mass);
  } else if (kinds.match.row) {
    const std::string& label = first.row->label;
    const std::string kind =
        first.material
            ? reasons().say("reason_of_material", {{"kind", label}, {"material", first.material->name}})
            : label;
    estimate.reason = reasons().say("reason_usual", {{"kind", kind},
                                                     {"usual", grams_or_kg(mass.usual_kg)},
                                                     {"physics", grams_or_kg(mass.physics_kg)},
                                                     {"factors", factors_of(mass)}});
  } else {
    estimate.reason = reasons().say("reason_looks");
  }
  const size_t others = kinds.match.row ? 2 : 3;
  for (size_t i = kinds.match.row ? 1 : 0; i < std::min(others + 1, kinds.kinds.size()); ++i) {
    const ObjectClass& kind = kinds.kinds[i];
    if (kind.probability < 0.02) break;
    const std::string other =
        reasons().say("reason_other", {{"kind", kind.row->label},
                                       {"share", format_text("%.0f", 100 * kind.probability)},
                                       {"mass", grams_or_kg(std::exp(kind_mass(kind, facts).mass.mean_ln))}});
    estimate.reason += kinds.match.row ? reasons().say("reason_or", {{"other", other}})
                       : i             ? reasons().say("reason_next_look", {{"other", other}})
                                       : reasons().say("reason_first_look", {{"other", other}});
  }
  if (!facts.scale_known) estimate.reason += reasons().say("reason_guessed_scale");
  return estimate;
}

}  // namespace livegs
