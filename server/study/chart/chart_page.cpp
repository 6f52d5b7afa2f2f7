// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/chart/chart_page.h"

#include <algorithm>
#include <cmath>

#include "core/text/format_text.h"
#include "study/chart/chart_curves.h"
#include "study/chart/chart_words.h"

namespace livegs::study {
namespace {

std::string modulus(double pa) { return format_text("%.0e Pa", pa); }

std::string percent(double error) { return error_text(error, "relative"); }

// A table of the smallest and largest E_app / E of livegs-v1 in tension over all substeps.
std::string v1_spread(const std::vector<ChartRow>& rows) {
  std::string lines;
  for (const Engine engine : {Engine::LivegsV1, Engine::LivegsV1Steady}) {
    for (const double pa : {1e4, 1e5, 1e6, 1e7}) {
      double low = 1e300, high = 0.0;
      std::pair<int, int> substeps{1 << 30, 0};
      int runs = 0;
      for (const ChartRow& row : rows) {
        if (row.scene != "tension" || row.variant == "table" || row.setup.engine != engine ||
            row.setup.youngs_modulus_pa != pa) {
          continue;
        }
        const double ratio = row.outcome.measurements.front().measured;
        if (!std::isfinite(ratio)) continue;
        low = std::min(low, ratio);
        high = std::max(high, ratio);
        ++runs;
        substeps.first = std::min(substeps.first, row.setup.substeps);
        substeps.second = std::max(substeps.second, row.setup.substeps);
      }
      if (runs > 1)
        lines += format_text("| `%s` | %s | %d to %d | %.2g | %.2g |\n",
                             engine == Engine::LivegsV1 ? "livegs-v1" : "livegs-v1 steady",
                             modulus(pa).c_str(), substeps.first, substeps.second, low, high);
    }
  }
  if (lines.empty()) return lines;
  return "`livegs-v1` blends towards its goals by a constant share per substep, so its stiffness depends on "
         "the substep count. The blend of `livegs-v1 steady` is converted once to a stiffness at 1/240 s.\n\n"
         "| method | E | substeps | smallest E_app / E | largest E_app / E |\n|---|---|---|---|---|\n" +
         lines;
}

const ChartRow* table_row(const std::vector<ChartRow>& rows, const char* scene, Engine engine, double rate_hz,
                          double pa) {
  for (const ChartRow& row : rows) {
    if (row.variant == "table" && row.scene == scene && row.setup.engine == engine &&
        row.setup.rate_hz == rate_hz && row.setup.youngs_modulus_pa == pa) {
      return &row;
    }
  }
  return nullptr;
}

std::string table(const std::vector<ChartRow>& rows) {
  std::string words;
  for (const double rate_hz : {60.0, 90.0}) {
    for (const double pa : {1e4, 1e5, 1e6, 1e7}) {
      const ChartRow* pulled = table_row(rows, "tension", Engine::Cells, rate_hz, pa);
      const ChartRow* rung = table_row(rows, "ring_down", Engine::Cells, rate_hz, pa);
      const ChartRow* baseline = table_row(rows, "tension", Engine::LivegsV1, rate_hz, pa);
      if (!pulled || !rung || !baseline) continue;
      const ElasticAccuracy& a = pulled->outcome.accuracy;
      const auto& m = pulled->outcome.measurements;
      words += format_text(
          "| %g | %s | %.3g mm | %d | %.2f | %s | %.2f to %.2f | %.3f | %.3f | %+.1f %% | %.2f | %.3g | %.2g "
          "|\n",
          rate_hz, modulus(pa).c_str(), 1e3 * a.cell_width_m, a.substeps, a.courant, name_of(a.band),
          a.modulus_ratio_low, a.modulus_ratio_high, m[0].measured, m[1].measured,
          100 * (rung->outcome["frequency"].measured / rung->outcome["frequency"].reference - 1),
          rung->outcome["amplitude"].measured, 1e-3 * pulled->outcome.cost.cpu_ns_per_simulated_s() / rate_hz,
          baseline->outcome.measurements[0].measured);
    }
  }
  if (words.empty()) return words;
  return "## Results by modulus\n\n4 substeps requested, default budget, cells and substeps chosen by the "
         "program. Bar of 0.4 x 0.1 x 0.1 m, particles 25 mm apart, nu 0.3 in tension and 0 in "
         "ring-down.\n\n| Hz | requested E | cells | substeps | Courant | band | predicted E_app / E | "
         "measured | nu measured (0.3) | ring-down f | amplitude left | us per frame | `livegs-v1`, E_app "
         "/ E |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n" +
         words + "\n";
}

// A table of longitudinal pulses at different steps, with an explanation.
std::string pulse_remark(const std::vector<ChartRow>& rows) {
  constexpr double kVeryShort = 0.1;  // Courant number
  std::string lines;
  double tallest = 0.0;
  for (const ChartRow& row : rows) {
    if (row.scene != "pulse") continue;
    const ElasticAccuracy& a = row.outcome.accuracy;
    const double speed = row.outcome["speed"].measured;
    if (!row.setup.cells.choose && a.courant < kVeryShort)
      tallest = std::max(tallest, row.outcome["height"].measured);
    lines += format_text("| %s | %.3g mm | %s%d | %.2f | %s | %s | %.2f |\n",
                         modulus(row.setup.youngs_modulus_pa).c_str(), 1e3 * a.cell_width_m,
                         row.setup.cells.choose ? "chosen: " : "", a.substeps, a.courant, name_of(a.band),
                         std::isfinite(speed) ? format_text("%.3f", speed).c_str() : "not measured",
                         row.outcome["height"].measured);
  }
  if (lines.empty()) return lines;
  const std::string overshoot = tallest > 1.0
                                    ? format_text(
                                          " With very short steps (Courant number under %.1f) its height "
                                          "overshoots by up to %.0f %%, although the body is called exact:"
                                          " this refers to the stiffness, not to a wave front.",
                                          kVeryShort, 100.0 * (tallest - 1.0))
                                    : std::string();
  return "## A pulse in a thin bar\n\nA velocity pulse, 0.4 m wide at its foot, starts in the middle of a "
         "free bar of 2.4 x 0.1 x 0.1 m at 60 Hz. It splits into two halves, which should travel at sqrt(E"
         " / rho) and keep their height. One Gauss-Seidel pass transports a stress little more than one "
         "cell per substep. The pulse is right if the step resolves the wave (Courant number well under 1)"
         " and the cells are much narrower than the pulse. With the default 4 substeps, the pulse of a "
         "stiff bar is early or late and flat, or missing before its echo. The cells chosen for this bar "
         "fit its stiffness and are nearly as wide as the pulse, so no step gives the right pulse. This "
         "matters for struck bodies, not for hanging, standing or pressed ones." +
         overshoot +
         "\n\n"
         "| E | cells | substeps | Courant | band | speed over sqrt(E / rho) | height kept "
         "|\n|---|---|---|---|---|---|---|\n" +
         lines + "\n";
}

}  // namespace

std::string chart_page(const std::vector<ChartRow>& rows, const std::string& how,
                       const std::string& version) {
  std::string page =
      "# Accuracy and cost\n\nGenerated by `livegs chart" + (how.empty() ? std::string() : " " + how) +
      "`, version " + version +
      ". All figures were measured in one run, in one process; `chart.csv` contains all of them, one "
      "measurement per line, with every setting. Costs are processor time of substeps and ends of frames "
      "on one core of a shared machine: compare them only within this page.\n\nMethods: `cells` (embedded "
      "lattice of eight-node cells, BDF2, compensated numerical compliance), the same without either or "
      "both, the paper's `livegs-v1` and its steady form, and `bullet`, the deformable body of Bullet 3 "
      "(five tetrahedra per cube, corotated linear elasticity, implicit Euler, its own Krylov solver with "
      "default settings). On the curves, cells and substeps are fixed, not chosen. Only `cells` is run in "
      "three widths. BDF1 and uncompensated cells are run in cells of 25 mm only. Bullet costs a hundred "
      "times as much per node, so it is run with cubes of 50 mm and at most 4 or 16 substeps.\n\nA table "
      "below a figure has a row for each method of each case. The first rows are the methods within the bar, "
      "at "
      "their cheapest number of substeps. The others follow at the substeps of their smallest error. \"Not "
      "within the bar\" refers to these runs only. The last row has the cells and substeps that the program "
      "chooses if 4 substeps are requested.\n\n";
  page += table(rows);
  page += pulse_remark(rows);
  for (const ChartScene& scene : chart_scenes()) {
    if (panels_of(scene, scene.quantities.front(), rows).empty()) continue;
    page += "## " + scene.title + "\n\n" + scene.what + "\n\n";
    for (const std::string& quantity : scene.quantities) {
      page += "![" + scene.title + ": " + quantity + "](" + scene.figure(quantity) + ")\n\n";
      const std::vector<Panel> panels = panels_of(scene, quantity, rows);
      page += format_text("`%s`, bar %s:\n\n", quantity.c_str(), percent(panels.front().bar).c_str());
      page += compare_curves(panels) + "\n";
    }
    if (scene.max_bullet_substeps == 0)
      page += "Bullet is not run here: it has no plasticity and is not connected to plates.\n\n";
    if (scene.name == "tension") page += v1_spread(rows) + "\n";
  }
  return page;
}

}  // namespace livegs::study
