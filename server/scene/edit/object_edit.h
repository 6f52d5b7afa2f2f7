// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "core/result.h"
#include "livegs/v1/author.pb.h"
#include "livegs/v1/scene.pb.h"

namespace livegs {

// Writes the implicit name of every object (object_name()) into the scene, so that edits can refer to it.
void name_objects(v1::Scene& scene);

// Measurements that an edit uses.
struct ObjectMeasures {
  double longest_side_m = 0;         // now, at the object's scale
  double scale = 1;                  // metres per unit of the asset, given or guessed
  double bottom_m = 0;               // of its lowest point above the origin of its frame, along up
  std::optional<double> way_down_m;  // to the surface below; nullopt: there is none
};
using MeasureObject = std::function<Result<ObjectMeasures>(const v1::Object& object)>;

// Applies one edit to the scene and returns the object's name afterwards. The scene is not checked. After an
// error it may be changed in part. `measure` is called for edits of size and for those that drop an object.
Result<std::string> apply_edit(v1::Scene& scene, const v1::ObjectEdit& edit, const MeasureObject& measure);

// One line for the log and the undo button: "move cup".
std::string title_of(const v1::EditSceneRequest& request);

}  // namespace livegs
