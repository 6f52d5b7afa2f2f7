// SPDX-License-Identifier: GPL-3.0-or-later
#include "fit/fit_quantity.h"

#include <algorithm>
#include <cmath>

#include "analysis/estimate/physics_values.h"

namespace livegs {
namespace {

// Prior standard deviation of the logarithm of a requested value: a factor of thirty. A smaller value pulls
// the result to the estimate, a larger one has no effect.
const double kAskedSd = std::log(30.0);
// Prior standard deviation of the logarithm of a requested mass that the scene file states: a factor of two.
const double kStatedMassSd = std::log(2.0);
// Standard deviation of the logarithm below which a range counts as exact: 1 %.
constexpr double kExactSd = 0.01;

double sd_of(const v1::EstimatedValue& value) {
  if (!(value.low() > 0) || !(value.high() > value.low())) return 0;
  return 0.5 * std::log(value.high() / value.low()) / kHalfRange_sd;
}

}  // namespace

std::optional<FitQuantity> fit_quantity(std::string_view name) {
  for (const FitQuantityName& one : kFitQuantities)
    if (name == one.name) return one.quantity;
  return std::nullopt;
}

Result<std::vector<FitParameter>> fit_parameters(const SceneObject& object,
                                                 std::span<const FitQuantity> asked) {
  const v1::PhysicalParameters& physics = object.physics;
  const bool elastic = physics.behavior() == v1::Physics::ELASTIC;
  std::vector<FitQuantity> quantities(asked.begin(), asked.end());
  if (quantities.empty()) {
    quantities = elastic ? std::vector{FitQuantity::YoungsModulus, FitQuantity::Damping}
                         : std::vector{FitQuantity::Friction, FitQuantity::Restitution};
  }
  if (physics.behavior() == v1::Physics::STATIC)
    return invalid_argument(object.name + ": does not move; name an object that does");
  std::vector<FitParameter> parameters;
  const auto add = [&](FitQuantity quantity, const v1::EstimatedValue& value, bool is_asked, double before,
                       double sd, double lowest, double highest) {
    parameters.push_back({object.name, quantity, is_asked, std::clamp(before, lowest, highest), sd,
                          source_name(value.source()), lowest, highest});
  };
  for (size_t i = 0; i < quantities.size(); ++i)
    if (std::find(quantities.begin(), quantities.begin() + static_cast<std::ptrdiff_t>(i), quantities[i]) !=
        quantities.begin() + static_cast<std::ptrdiff_t>(i))
      return invalid_argument(object.name + ": " + names_of(quantities[i]).name +
                              " is named twice; name it once");
  bool mass = false;
  for (const FitQuantity quantity : quantities) {
    const bool of_lattice = quantity == FitQuantity::YoungsModulus || quantity == FitQuantity::Damping;
    if (of_lattice && !elastic)
      return invalid_argument(object.name + ": is rigid and has no " + names_of(quantity).name +
                              "; find friction or restitution, or set its behavior to ELASTIC");
    switch (quantity) {
      case FitQuantity::YoungsModulus:
        add(quantity, physics.youngs_modulus_pa(), true,
            physics.structure_coefficient().best() * physics.youngs_modulus_pa().best(), kAskedSd, 10, 1e11);
        break;
      case FitQuantity::Damping:
        add(quantity, physics.damping(), true, physics.damping().best(), kAskedSd, 1e-3, 2);
        break;
      case FitQuantity::Friction:
        add(quantity, physics.friction(), true, physics.friction().best(), kAskedSd, 0.01, 2);
        break;
      case FitQuantity::Restitution:
        add(quantity, physics.restitution(), true, physics.restitution().best(), kAskedSd, 0.01, 1);
        break;
      case FitQuantity::Mass: {
        mass = true;
        const double sd = sd_of(physics.mass_kg());
        add(quantity, physics.mass_kg(), true, object.mass_kg, sd > kExactSd ? sd : kStatedMassSd,
            1e-3 * object.mass_kg, 1e3 * object.mass_kg);
        break;
      }
    }
  }
  if (const double sd = sd_of(physics.mass_kg()); elastic && !mass && sd > kExactSd)
    add(FitQuantity::Mass, physics.mass_kg(), false, object.mass_kg, sd, 1e-3 * object.mass_kg,
        1e3 * object.mass_kg);
  return parameters;
}

void set_quantity(v1::Object& object, FitQuantity quantity, double value) {
  v1::Physics& physics = *object.mutable_physics();
  switch (quantity) {
    case FitQuantity::YoungsModulus:
      physics.clear_deformation_resistance();
      physics.clear_structure_coefficient();
      physics.set_youngs_modulus_pa(value);
      break;
    case FitQuantity::Damping:
      physics.set_damping(value);
      break;
    case FitQuantity::Mass:
      physics.clear_density_kg_m3();
      physics.set_mass_kg(value);
      break;
    case FitQuantity::Friction:
      physics.set_friction(value);
      break;
    case FitQuantity::Restitution:
      physics.set_restitution(value);
      break;
  }
}

}  // namespace livegs
