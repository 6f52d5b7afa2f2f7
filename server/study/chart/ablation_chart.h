// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "physics/ablation/ablation.h"
#include "study/harness/setup.h"

// The figures of scenes without each mechanism of the solvers in turn: the stability scenes, where solvers
// fail, and the canonical scenes, which mostly should not change. LiveGS with its default settings, 90 Hz,
// one thread.

namespace livegs::study {

struct MechanismText {
  Mechanism mechanism;
  const char* name;  // "alternating_sweep"
  const char* what;  // one line, without full stop
};
std::span<const MechanismText> all_mechanisms();  // without None

struct AblationRun {
  std::vector<Measurement> measurements;
  double cpu_s = 0.0;
};
struct AblationPair {
  Mechanism mechanism = Mechanism::None;
  std::string scene;
  AblationRun without, with;
};

// Runs each scene without each mechanism that can act on its bodies, or only without `only`, and every few
// runs with all of them, so that a slow machine slows both. `progress` is called
// before each pair with the number of finished pairs, the total, the scene and the name of the mechanism.
// Precondition: no world exists.
std::vector<AblationPair> run_ablation(
    std::optional<Mechanism> only,
    const std::function<void(size_t done, size_t of, const std::string& scene, const char* without)>&
        progress);

// How far a figure is from its bar, in bars, without a mechanism less with all of them: above 0 it got worse.
struct AblationEffect {
  Mechanism without = Mechanism::None;
  std::string scene, quantity, unit;
  double error = 0.0, error_without = 0.0, bar = 0.0;
  double cost_ratio = 1.0;  // processor time of the scene without the mechanism over that with it

  double worse_bars() const;
};
// One per mechanism, scene and figure. Figures without a counterpart are left out.
std::vector<AblationEffect> effects_of(const std::vector<AblationPair>& pairs);

std::string ablation_csv(const std::vector<AblationEffect>& effects);
// The page in Markdown, with ablation.svg next to it.
std::string ablation_page(const std::vector<AblationEffect>& effects, const std::string& version);
// A map of mechanisms by scenes, coloured by the worst figure of each scene. Fails without gnuplot.
Result<void> draw_ablation(const std::vector<AblationEffect>& effects, const std::filesystem::path& svg);

}  // namespace livegs::study
