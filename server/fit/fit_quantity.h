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

// What is found from motion: fields of Physics.
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
  // Before the video: the value and the standard deviation of its logarithm.
  double before = 0, before_sd = 0;
  std::string source;              // of the value before: source_name() (physics_values.h)
  double lowest = 0, highest = 0;  // limits of the search
};

// The parameters of an object for the quantities that are asked for; empty: the default of its body,
// youngs_modulus_pa and damping of an elastic one, friction and restitution of a rigid one. The mass of an
// object joins them if it is only estimated. Fails for a quantity that the body does not have.
Result<std::vector<FitParameter>> fit_parameters(const SceneObject& object,
                                                 std::span<const FitQuantity> asked);

// Writes a value into the object of a scene; what contradicts it there is removed.
void set_quantity(v1::Object& object, FitQuantity quantity, double value);

}  // namespace livegs
