// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "analysis/estimate.h"
#include "server/analysis/estimate/mass_scores.h"

// Objects whose masses are known: the 26 of shared/data/ycb, with what is known of each.

namespace livegs {

struct KnownObject {
  std::string id;     // file name: "025_mug"
  std::string label;  // as a person who holds it would put it: "metal mug"
  std::string noun;   // as one who only sees it would: "mug"
  double mass_kg = 0;
  bool elastic = false;         // as a judgement; not measured
  std::filesystem::path asset;  // its splats
  ObjectFacts facts;            // metric, without a name
};

enum class KnownForm {
  Splats,  // the kernels of splat.ply, and the surface made from them: as the server sees an asset
  Mesh,    // the scan's mesh itself; no colours
};

// Empty when the shared data is not here. Measured once a form, then kept.
const std::vector<KnownObject>& known_objects(KnownForm form);

enum class NameGiven { Label, Noun, FileName, None };
inline constexpr const char* kNameGiven[] = {"label", "noun", "file name", "none"};

// What the estimator says of all of them. Without `metric` the asset's longest side is one unit and the scale
// is guessed as the server does: the usual size for its name, and 0.4 m for none.
std::vector<MassAnswer> estimate_known(const std::vector<KnownObject>& objects, NameGiven name, bool metric);

}  // namespace livegs
