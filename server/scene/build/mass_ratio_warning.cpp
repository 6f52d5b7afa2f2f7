// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/mass_ratio_warning.h"

#include <algorithm>
#include <cmath>

#include "core/text/format_text.h"

namespace livegs {
namespace {

// Mass of a load over that of its support, for each substep of a second, up to which a box rests on another
// one. Boxes of 0.3 m rested up to 300 s; half of that is the margin. Larger: a load may sink in without a
// warning.
constexpr double kRestingRatio_s = 150;

}  // namespace

void warn_of_mass_ratios(std::span<std::optional<Result<BuiltObject>>> built, const WorldSettings& settings) {
  const SceneObject* lightest = nullptr;
  const auto rigid = [](const BuiltObject& one) {
    return std::holds_alternative<RigidBodyDescription>(one.body) && one.drawn.mass_kg > 0;
  };
  for (const auto& object : built) {
    const BuiltObject& one = **object;
    if (rigid(one) && (!lightest || one.drawn.mass_kg < lightest->mass_kg)) lightest = &one.drawn;
  }
  if (!lightest) return;
  const double most = kRestingRatio_s * settings.rate_hz * settings.substeps;
  for (auto& object : built) {
    SceneObject& heavy = (**object).drawn;
    const double ratio = heavy.mass_kg / lightest->mass_kg;
    if (!rigid(**object) || ratio <= most) continue;
    heavy.warnings.push_back(format_text(
        "physics.mass_kg: %.3g kg is %.0f times the %.3g kg of %s, and a load above %.0f times its support "
        "sinks in; give %.0f substeps, or a smaller ratio",
        heavy.mass_kg, ratio, lightest->mass_kg, lightest->name.c_str(), most,
        std::ceil(ratio / (kRestingRatio_s * settings.rate_hz))));
  }
}

}  // namespace livegs
