// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/chart/ablation_chart.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/text/format_text.h"
#include "study/chart/chart_scenes.h"
#include "study/chart/chart_words.h"
#include "study/chart/gnuplot.h"
#include "study/harness/rigid_scenes.h"
#include "study/stability/stability_scenes.h"

namespace livegs::study {
namespace {

constexpr double kRate_hz = 90.0;
// A figure has changed if it is further from or nearer to its bar by this part of the bar.
constexpr double kChange_bars = 0.1;
// Mechanisms that share one run with all mechanisms. Larger: faster; a machine that becomes slower in the
// meantime falsifies costs.
constexpr size_t kPairsOfRun = 8;

bool acts_on_rigid(Mechanism mechanism) { return mechanism >= Mechanism::BodyCores; }

struct Scene {
  std::string name;
  bool elastic, rigid;
  std::function<void(AblationRun&)> run;
};

Scene elastic_scene(const std::string& name, Result<Outcome> (*run)(const Setup&), double poisson_ratio) {
  return {name, true, false, [run, poisson_ratio](AblationRun& row) {
            Setup setup;
            setup.rate_hz = kRate_hz;
            setup.cell_width_m = 0.0;
            setup.cells.choose = true;
            setup.poisson_ratio = poisson_ratio;
            const auto outcome = run(setup);
            if (!outcome) return;
            row.measurements = outcome->measurements;
            row.cpu_s = outcome->cost.cpu_s;
          }};
}

Scene rigid_scene(const std::string& name, Result<RigidOutcome> (*run)(const RigidSetup&), double parameter) {
  return {name, false, true, [run, parameter](AblationRun& row) {
            RigidSetup setup;
            setup.rate_hz = kRate_hz;
            setup.parameter = parameter;
            const auto outcome = run(setup);
            if (!outcome) return;
            row.measurements = outcome->measurements;
            row.cpu_s = outcome->cost.cpu_s;
          }};
}

std::vector<Scene> scenes() {
  std::vector<Scene> all;
  for (const StabilityScene& scene : stability_scenes()) {
    all.push_back({scene.name, scene.elastic, scene.rigid, [run = scene.run](AblationRun& row) {
                     StabilityRun clock(kRate_hz);
                     row.measurements = run(clock);
                     row.cpu_s = clock.cost().cpu_s;
                   }});
  }
  for (const ChartScene& scene : chart_scenes())
    all.push_back(elastic_scene(scene.name, scene.run, scene.poisson_ratio));
  all.push_back(rigid_scene("stopping", stopping, 0));
  all.push_back(rigid_scene("rolling_box", rolling_box, 0));
  all.push_back(rigid_scene("ball_pendulum", ball_pendulum, 60));
  all.push_back(rigid_scene("tumbling", tumbling, 0));
  all.push_back(rigid_scene("box_stack", box_stack, 0));
  all.push_back(rigid_scene("dominoes", dominoes, 0));
  all.push_back(rigid_scene("overlap", overlap, 0));
  all.push_back(rigid_scene("break_height", break_height, 1));
  return all;
}

const MechanismText& text_of(Mechanism mechanism) {
  for (const MechanismText& text : all_mechanisms()) {
    if (text.mechanism == mechanism) return text;
  }
  static constexpr MechanismText kNone{Mechanism::None, "none", ""};
  return kNone;
}

// The effects of one mechanism.
struct Summary {
  const MechanismText* text = nullptr;
  const AblationEffect* worst = nullptr;  // null: nothing got worse
  int figures = 0, worse = 0, better = 0;
  double cost_ratio = 1.0;  // of all scenes: geometric mean
};

std::vector<Summary> summaries_of(const std::vector<AblationEffect>& effects) {
  std::vector<Summary> summaries;
  for (const MechanismText& text : all_mechanisms()) {
    Summary one{&text};
    std::map<std::string, double> costs;
    for (const AblationEffect& effect : effects) {
      if (effect.without != text.mechanism) continue;
      ++one.figures;
      one.worse += effect.worse_bars() > kChange_bars;
      one.better += effect.worse_bars() < -kChange_bars;
      if (effect.worse_bars() > (one.worst ? one.worst->worse_bars() : kChange_bars)) one.worst = &effect;
      costs[effect.scene] = effect.cost_ratio;
    }
    if (one.figures == 0) continue;
    double sum = 0.0;
    for (const auto& [scene, ratio] : costs) sum += std::log(ratio);
    one.cost_ratio = std::exp(sum / static_cast<double>(costs.size()));
    summaries.push_back(one);
  }
  return summaries;
}

}  // namespace

double AblationEffect::worse_bars() const {
  const auto in_bars = [this](double value) {
    return std::isfinite(value) ? std::min(value / bar, 1e6) : 1e6;
  };
  return in_bars(error_without) - in_bars(error);
}

std::vector<AblationPair> run_ablation(
    std::optional<Mechanism> only,
    const std::function<void(size_t, size_t, const std::string&, const char*)>& progress) {
  const std::vector<Scene> all = scenes();
  std::vector<AblationPair> pairs;
  std::vector<const Scene*> of;
  for (const Scene& scene : all) {
    for (const MechanismText& text : all_mechanisms()) {
      if (only && *only != text.mechanism) continue;
      if (!(acts_on_rigid(text.mechanism) ? scene.rigid : scene.elastic)) continue;
      pairs.push_back({text.mechanism, scene.name, {}, {}});
      of.push_back(&scene);
    }
  }
  size_t since = 0;  // pairs since the last run with all mechanisms
  for (size_t i = 0; i < pairs.size(); ++i) {
    progress(i, pairs.size(), pairs[i].scene, text_of(pairs[i].mechanism).name);
    disabled_mechanism = pairs[i].mechanism;
    of[i]->run(pairs[i].without);
    disabled_mechanism = Mechanism::None;
    if (i > 0 && of[i] == of[i - 1] && ++since < kPairsOfRun) {
      pairs[i].with = pairs[i - 1].with;
    } else {
      of[i]->run(pairs[i].with);
      since = 0;
    }
  }
  return pairs;
}

std::vector<AblationEffect> effects_of(const std::vector<AblationPair>& pairs) {
  std::vector<AblationEffect> effects;
  for (const AblationPair& pair : pairs) {
    const auto &with = pair.with.measurements, &without = pair.without.measurements;
    for (size_t i = 0; i < std::min(with.size(), without.size()); ++i) {
      effects.push_back({pair.mechanism, pair.scene, with[i].quantity, with[i].unit, with[i].error,
                         without[i].error, with[i].bar, pair.without.cpu_s / pair.with.cpu_s});
    }
  }
  return effects;
}

std::string ablation_csv(const std::vector<AblationEffect>& effects) {
  std::string lines = "without,scene,quantity,unit,bar,error,error_without,worse_bars,cost_ratio\n";
  for (const AblationEffect& one : effects) {
    lines += format_text("%s,%s,%s,%s,%g,%.4g,%.4g,%.3g,%.2f\n", text_of(one.without).name, one.scene.c_str(),
                         one.quantity.c_str(), one.unit.c_str(), one.bar, one.error, one.error_without,
                         one.worse_bars(), one.cost_ratio);
  }
  return lines;
}

std::string ablation_page(const std::vector<AblationEffect>& effects, const std::string& version) {
  std::string page = format_text(
      "# Mechanisms of the solvers\n\nGenerated by `livegs chart --only ablation`, version %s. Each "
      "mechanism is "
      "disabled in turn. The scenes are those where solvers fail and the canonical ones, at the default "
      "settings and %g Hz. A figure changes if its error changes by at least a tenth of its bar. "
      "`ablation.csv` "
      "has all figures. The cost is the processor time without the mechanism over that with it, a geometric "
      "mean of the scenes, on a shared machine.\n\n![Mechanisms by scenes](ablation.svg)\n\n"
      "| without | it does | most affected figure | with | without | bar | worse | better | unchanged | cost "
      "|\n"
      "|---|---|---|---|---|---|---|---|---|---|\n",
      version.c_str(), kRate_hz);
  std::string idle;
  for (const Summary& one : summaries_of(effects)) {
    page += format_text("| `%s` | %s | ", one.text->name, one.text->what);
    if (one.worst) {
      page += format_text("%s of `%s` | %s | %s | %s", spaced(one.worst->quantity).c_str(),
                          one.worst->scene.c_str(), error_text(one.worst->error, one.worst->unit).c_str(),
                          error_text(one.worst->error_without, one.worst->unit).c_str(),
                          error_text(one.worst->bar, one.worst->unit).c_str());
    } else {
      page += "none | | | ";
      idle += format_text("%s`%s`", idle.empty() ? "" : ", ", one.text->name);
    }
    page += format_text(" | %d | %d | %d | %.2f |\n", one.worse, one.better,
                        one.figures - one.worse - one.better, one.cost_ratio);
  }
  if (!idle.empty()) page += "\nNo figure here gets worse without " + idle + ".\n";
  return page;
}

Result<void> draw_ablation(const std::vector<AblationEffect>& effects, const std::filesystem::path& svg) {
  const std::vector<Summary> summaries = summaries_of(effects);
  std::vector<std::string> columns;
  std::map<std::pair<std::string, Mechanism>, double> cells;  // the figure that changes most
  for (const AblationEffect& one : effects) {
    if (std::find(columns.begin(), columns.end(), one.scene) == columns.end()) columns.push_back(one.scene);
    double& cell = cells[{one.scene, one.without}];
    if (std::abs(one.worse_bars()) > std::abs(cell)) cell = one.worse_bars();
  }
  const size_t width = 360 + 24 * columns.size(), height = 240 + std::max<size_t>(160, 20 * summaries.size());
  return draw_with_gnuplot(svg, width, height, [&](std::FILE* out) {
    std::fprintf(
        out,
        "set title 'Change of the error without a mechanism, in bars' font ',14'\n"
        "set palette defined (-2 '#2166AC', 0 '#F7F7F7', 2 '#B2182B')\nset cbrange [-2:2]\n"
        "set cbtics ('100 better' -2, '10' -1.47, '1' -0.93, '0' 0, '1' 0.93, '10' 1.47, '100 worse' 2)\n"
        "set xrange [-0.5:%g]\nset yrange [%g:-0.5]\nset xtics rotate by 60 right font ',10' nomirror "
        "scale 0\nset ytics font ',10' nomirror scale 0\nset grid front lt 1 lc rgb '#dddddd'\n"
        "unset key\nset bmargin 12\nset lmargin 28\nset rmargin 18\n",
        static_cast<double>(columns.size()) - 0.5, static_cast<double>(summaries.size()) - 0.5);
    std::fprintf(out, "set xtics (");
    for (size_t i = 0; i < columns.size(); ++i)
      std::fprintf(out, "%s'%s' %zu", i ? ", " : "", spaced(columns[i]).c_str(), i);
    std::fprintf(out, ")\nset ytics (");
    for (size_t i = 0; i < summaries.size(); ++i)
      std::fprintf(out, "%s'%s' %zu", i ? ", " : "", spaced(summaries[i].text->name).c_str(), i);
    std::fprintf(out, ")\n$cells << EOD\n");
    for (size_t row = 0; row < summaries.size(); ++row) {
      for (size_t column = 0; column < columns.size(); ++column) {
        const auto found = cells.find({columns[column], summaries[row].text->mechanism});
        if (found == cells.end()) continue;
        // Logarithmic from 0.4 for a tenth of a bar to 2 for a hundred bars, by sign.
        const double decades = std::log10(std::abs(found->second) / kChange_bars);
        const double size = decades < 0.0 ? 0.0 : 0.4 + 1.6 * std::min(1.0, decades / 3.0);
        std::fprintf(out, "%zu %zu %g\n", column, row, std::copysign(size, found->second));
      }
    }
    std::fprintf(out,
                 "EOD\nplot $cells using 1:2:(0.46):(0.46):3 with boxxyerror fillstyle solid lc palette\n");
  });
}

}  // namespace livegs::study
