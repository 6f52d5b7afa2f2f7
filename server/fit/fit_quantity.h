// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "livegs/v1/scene.pb.h"
#include "scene/scene.h"

namespace livegs {

// Fields of Physics that a fit finds from motion.
enum class FitQuantity { YoungsModulus, Damping, Mass, Friction, Restitution };

// Names on the command line and in reports, in the order of the enum.
struct FitQuantityName {
  FitQuantity quantity;
  const char* name;  // the field of Physics
};
inline constexpr FitQuantityName kFitQuantities[] = {
    {FitQuantity::YoungsModulus, "youngs_modulus_pa"},
    {FitQuantity::Damping, "damping"},
    {FitQuantity::Mass, "mass_kg"},
    {FitQuantity::Friction, "friction"},
    {FitQuantity::Restitution, "restitution"},
};
inline const FitQuantityName& names_of(FitQuantity quantity) {
  return kFitQuantities[static_cast<int>(quantity)];
}
// nullopt: no such quantity.
std::optional<FitQuantity> fit_quantity(std::string_view name);

// Half the width of a 90 % range, in standard deviations.
inline constexpr double kHalfRange_sd = 1.645;

// One number that a fit varies, by its natural logarithm.
struct FitParameter {
  std::string object;
  FitQuantity quantity = FitQuantity::YoungsModulus;
  bool asked = true;  // false: varied only because its uncertainty widens the range of others
  // Prior: the value and the standard deviation of its logarithm.
  double before = 0, before_sd = 0;
  std::string source;              // of the prior value: source_name() (physics_values.h)
  double lowest = 0, highest = 0;  // limits of the search
};

// Returns the parameters of an object for the requested quantities. Empty: the default of the body, which is
// youngs_modulus_pa and damping if it is elastic, friction and restitution if it is rigid. An estimated mass
// is added. Fails for a quantity that the body does not have.
Result<std::vector<FitParameter>> fit_parameters(const SceneObject& object,
                                                 std::span<const FitQuantity> asked);

// Writes a value into the object of a scene and removes contradicting values.
void set_quantity(v1::Object& object, FitQuantity quantity, double value);

}  // namespace livegs
