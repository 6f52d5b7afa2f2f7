// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/analyze/decide_physics.h"

#include <cstdio>
#include <vector>

#include "analysis/gate/answer.h"
#include "analysis/physics_file.h"
#include "cli/commands.h"
#include "cli/shown_paths.h"
#include "core/text/shown_text.h"
#include "scene/check/check_object.h"
#include "scene/check/sidecar_paths.h"

namespace livegs {
namespace {

Result<std::filesystem::path> sidecar_of(const std::string& name, const v1::Scene& scene,
                                         const std::filesystem::path& folder, const std::string& scene_name) {
  const auto paths = sidecar_paths(scene, folder, scene_name);
  std::string known;
  for (int i = 0; i < scene.objects_size(); ++i) {
    const std::string one = object_name(scene.objects(i), i);
    if (one == name && !paths[static_cast<size_t>(i)].empty()) return paths[static_cast<size_t>(i)];
    known += (known.empty() ? "" : ", ") + shown_line(one);
  }
  return Error{ErrorCode::InvalidArgument,
               "object \"" + shown_line(name) +
                   "\": is not in the scene; available: " + (known.empty() ? "none" : known)};
}

std::string held_text(const v1::PhysicsFile& file) {
  std::string text;
  if (!file.name().empty()) text += "called \"" + shown_line(file.name()) + "\"; ";
  if (file.has_physics()) {
    char mass[96];
    const v1::EstimatedValue& mass_kg = file.physics().mass_kg();
    std::snprintf(mass, sizeof mass, "%.4g g (%.4g to %.4g) of ", 1e3 * mass_kg.best(), 1e3 * mass_kg.low(),
                  1e3 * mass_kg.high());
    text += mass + shown_line(file.physics().material()) + ", " +
            v1::Physics::Behavior_Name(file.physics().behavior());
    text += file.analysis().model().empty() ? ", offline" : ", from " + shown_line(file.analysis().model());
  } else {
    text += "not analysed, offline estimates apply";
  }
  return text + (file.has_edits() ? "; overridden by manual edits" : "");
}

}  // namespace

int decide_physics(const PhysicsDecision& decision, const v1::Scene& scene,
                   const std::filesystem::path& folder, const std::string& scene_name) {
  const std::string& name = !decision.accept.empty()    ? decision.accept
                            : !decision.decline.empty() ? decision.decline
                            : !decision.undo.empty()    ? decision.undo
                                                        : decision.redo;
  const auto path = sidecar_of(name, scene, folder, scene_name);
  if (!path) return report(path.error());
  const auto file = !decision.accept.empty()    ? accept_proposal(*path)
                    : !decision.decline.empty() ? decline_proposal(*path)
                    : !decision.undo.empty()    ? undo_physics(*path)
                                                : redo_physics(*path);
  if (!file) return report(file.error());
  std::printf("%s: %s\n", shown_line(name).c_str(), held_text(*file).c_str());
  std::fprintf(stderr, "saved in %s; reload the scene on a running server to apply it\n",
               with_shown_paths(path->string()).c_str());
  return 0;
}

}  // namespace livegs
