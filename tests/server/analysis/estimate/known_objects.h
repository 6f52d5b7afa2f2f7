// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "analysis/estimate.h"
#include "server/analysis/estimate/mass_scores.h"

// Objects of known mass: the 26 of shared/data/ycb, with their facts.

namespace livegs {

struct KnownObject {
  std::string id;     // file name: "025_mug"
  std::string label;  // label of an object in the hand: "metal mug"
  std::string noun;   // label of an object at sight: "mug"
  double mass_kg = 0;
  bool elastic = false;         // a judgement, not measured
  std::filesystem::path asset;  // its splat file
  ObjectFacts facts;            // metric, without a name
};

enum class KnownForm {
  Splats,  // kernels of splat.ply and the surface made from them, as in the server
  Mesh,    // the scanned mesh; no colours
};

// Empty if the shared data is absent. Computed once per form.
const std::vector<KnownObject>& known_objects(KnownForm form);

enum class NameGiven { Label, Noun, FileName, None };
inline constexpr const char* kNameGiven[] = {"label", "noun", "file name", "none"};

// Offline estimates of all objects. Without `metric`, the longest side of the asset is one unit and the scale
// is guessed as in the server: the usual size for its name, or 0.4 m without one.
std::vector<MassAnswer> estimate_known(const std::vector<KnownObject>& objects, NameGiven name, bool metric);

}  // namespace livegs
