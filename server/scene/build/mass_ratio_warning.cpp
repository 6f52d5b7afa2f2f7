// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/mass_ratio_warning.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "core/text/format_text.h"
#include "scene/check/check_scene.h"
#include "scene/check/joint_parts.h"

namespace livegs {
namespace {

// Mass of a load over that of its support, for each substep of a second, up to which a box rests on another
// one. Boxes of 0.3 m rested up to 300 s; half of that is the margin. Larger: a load may sink in without a
// warning.
constexpr double kRestingRatio_s = 150;

std::string warning_of(const SceneObject& heavy, const SceneObject& light, const WorldSettings& settings) {
  const double ratio = heavy.mass_kg / light.mass_kg;
  const double for_each_substep = kRestingRatio_s * settings.rate_hz;
  const double most = for_each_substep * settings.substeps;
  if (ratio <= most) return "";
  const double substeps = std::ceil(ratio / for_each_substep);
  return format_text(
             "physics.mass_kg: %.3g kg is %.0f times the %.3g kg of %s, and a load above %.0f times its "
             "support sinks in; ",
             heavy.mass_kg, ratio, light.mass_kg, light.name.c_str(), most) +
         (substeps <= kMaxSubsteps
              ? format_text("give %.0f substeps, or a smaller ratio", substeps)
              : format_text("give more similar masses, at most %.0f times at %d substeps",
                            for_each_substep * kMaxSubsteps, kMaxSubsteps));
}

}  // namespace

std::vector<uint32_t> update_mass_ratio_warnings(std::deque<SceneObject>& objects,
                                                 const google::protobuf::RepeatedPtrField<v1::Joint>& joints,
                                                 const WorldSettings& settings) {
  std::vector<const SceneObject*> rigid;  // lightest first; balls are no objects of the file
  for (const SceneObject& one : objects) {
    if (one.facts && one.physics.behavior() == v1::Physics::RIGID && one.mass_kg > 0) rigid.push_back(&one);
  }
  if (settings.gravity_m_s2.isZero(0)) rigid.clear();
  std::stable_sort(rigid.begin(), rigid.end(),
                   [](const SceneObject* a, const SceneObject* b) { return a->mass_kg < b->mass_kg; });
  std::set<std::pair<std::string, std::string>> joined;
  for (const v1::Joint& joint : joints) {
    const JointParts parts = parts_of(joint);
    joined.emplace(parts.object, parts.other);
    joined.emplace(parts.other, parts.object);
  }
  std::vector<uint32_t> changed;
  for (SceneObject& object : objects) {
    std::string warning;
    if (std::find(rigid.begin(), rigid.end(), &object) != rigid.end()) {
      const auto lightest = std::find_if(rigid.begin(), rigid.end(), [&](const SceneObject* other) {
        return other != &object && !joined.contains({object.name, other->name});
      });
      if (lightest != rigid.end()) warning = warning_of(object, **lightest, settings);
    }
    if (warning == object.mass_ratio_warning) continue;
    object.mass_ratio_warning = std::move(warning);
    changed.push_back(object.id);
  }
  return changed;
}

}  // namespace livegs
