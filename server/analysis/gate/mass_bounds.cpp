// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/gate/mass_bounds.h"

#include <algorithm>

#include "analysis/estimate/object_classes.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

using v1::Physics;

// Lower bounds of density and areal density: air, and the thinnest films sold (cling film, rescue blankets,
// balloons).
constexpr double kAir_kg_m3 = 1.0, kFilm_kg_m2 = 5e-3;
// Maximum factor by which a hull, or a table density, is too small.
constexpr double kRoomSlack = 4.0, kFoamSlack = 2.0;
// A surface is that of a lump if it is compact and thicker than the thinnest wall of the reconstruction.
constexpr double kCompactSolidity = 0.7, kCompactOpenness = 0.15, kMinResolvedRatio = 1.5;
// Solid objects of one material may enclose air: a bed, a wheel, a seashell, a candlestick. kAirSlack is the
// maximum ratio of enclosed volume to material; kMinMemberThickness_m is the thickness of sheet metal. The
// emptiest resolved class of objects.csv, a ladle, has a ratio of 32.
constexpr double kAirSlack = 64.0, kMinMemberThickness_m = 1e-4;
// Wall thickness is stated in round millimetres at the thickest place, and walls may be pierced. That of
// inflated rubber may be stated before inflation; kBlownSlack allows five times the length and width.
constexpr double kWallSlack = 12.0, kBlownSlack = 25.0;
// Parts below this share of the mass are not named.
constexpr double kMinNamedShare = 0.1;

bool of_class(const MaterialRow& material, std::initializer_list<const char*> classes) {
  return std::any_of(classes.begin(), classes.end(),
                     [&](const char* one) { return material.material_class == one; });
}

// True for materials that hold air: cloth, stuffing, paper, leaves, wickerwork; and for machines.
bool airy(const MaterialRow& material) {
  return of_class(material, {"textile", "stuffed", "paper", "plant", "assembly"}) ||
         material.name == "wicker";
}

// True for materials that come as films, foils, threads or veneers.
bool comes_thin(const MaterialRow& material) {
  return !of_class(material, {"ceramic", "glass", "stone", "food", "stuffed", "assembly", "other"});
}

bool drawn_true(const MeshFacts& mesh) {
  return mesh.mean_wall_m >= kMinResolvedRatio * min_drawn_wall_m(mesh);
}

double box_area_m2(const MeshFacts& mesh) {
  const Eigen::Vector3d box_m = sorted_box_m(mesh);
  return 2 * (box_m[0] * box_m[1] + box_m[1] * box_m[2] + box_m[2] * box_m[0]);
}

// Minimum volume of the named materials for the stated fill, m³; 0 if unknown. Filled objects and assemblies
// may contain unnamed material, and a surface may enclose air.
double least_stuff_m3(const Answer& answer, const ObjectFacts& facts) {
  const MeshFacts& mesh = facts.mesh;
  for (const AnswerPart& part : answer.parts) {
    if (part.share >= kMinNamedShare && airy(*part.material)) return 0;
  }
  // The area of a hull is at most that of its box; surfaces captured inside and outside count once.
  const double seen_m2 = std::min(mesh.area_m2, box_area_m2(mesh));
  if (answer.fill == Physics::SOLID) {
    const bool compact =
        mesh.solidity >= kCompactSolidity && mesh.openness <= kCompactOpenness && drawn_true(mesh);
    if (!compact) return 0;
    return std::max(mesh.volume_m3 / kAirSlack, seen_m2 * kMinMemberThickness_m);
  }
  const std::optional<double> wall_m = answer.parts.front().thickness_m;
  if ((answer.fill != Physics::SHELL && answer.fill != Physics::OPEN_SHELL) || !wall_m) return 0;
  // An open object may have been captured inside and outside.
  const double wall_m2 = answer.fill == Physics::OPEN_SHELL ? 0.5 * mesh.area_m2 : seen_m2;
  const bool blown = answer.fill == Physics::SHELL && of_class(*answer.parts.front().material, {"elastomer"});
  return std::min(*wall_m * wall_m2, mesh.volume_m3) / (blown ? kBlownSlack : kWallSlack);
}

}  // namespace

double min_mass_kg(const Answer& answer, const ObjectFacts& facts) {
  const double air_kg = kAir_kg_m3 * sorted_box_m(facts.mesh).prod();
  const bool thin = std::any_of(answer.parts.begin(), answer.parts.end(),
                                [](const AnswerPart& part) { return comes_thin(*part.material); });
  if (!thin) return air_kg;
  if (!drawn_true(facts.mesh)) return 0;
  return std::min(air_kg, kFilm_kg_m2 * 0.5 * facts.mesh.area_m2);
}

std::string mass_at_odds(const Answer& answer, const ObjectFacts& facts) {
  double least_m3 = 0, most_m3 = 0;
  for (const AnswerPart& part : answer.parts) {
    // Foams exist at much higher densities than those of the table.
    const double slack = of_class(*part.material, {"foam"}) ? kFoamSlack : 1.0;
    least_m3 += answer.mass_kg.best * part.share / (slack * part.material->density_kg_m3.high);
    most_m3 += answer.mass_kg.best * part.share / part.material->density_kg_m3.low;
  }
  const double scale = facts.scale_known ? 1.0 : kGuessedVolumeRatio;
  const double holds_m3 = std::max(facts.mesh.volume_m3, facts.mesh.hull_volume_m3);
  // Filled objects may contain unnamed material.
  if (answer.fill != Physics::FILLED && holds_m3 > 0 && least_m3 > holds_m3 * kRoomSlack * scale) {
    return format_text("mass_g.best: %.4g g of %s take up at least %.3g cm3, and the object has %.3g cm3",
                       answer.mass_kg.best * 1e3, materials_of(answer).c_str(), least_m3 * 1e6,
                       holds_m3 * 1e6);
  }
  const double needed_m3 = least_stuff_m3(answer, facts) / scale;
  if (most_m3 >= needed_m3) return "";
  return format_text("mass_g.best: %.4g g of %s are at most %.3g cm3, and %s has at least %.3g cm3 of it",
                     answer.mass_kg.best * 1e3, materials_of(answer).c_str(), most_m3 * 1e6,
                     answer.fill == Physics::SOLID ? "a thing of this size, even if hollow,"
                                                   : "a wall of this thickness and area",
                     needed_m3 * 1e6);
}

std::string materials_of(const Answer& answer) {
  std::string names;
  for (size_t i = 0; i < std::min<size_t>(answer.parts.size(), 3); ++i)
    names += (i ? ", " : "") + answer.parts[i].material->name;
  return names;
}

}  // namespace livegs
