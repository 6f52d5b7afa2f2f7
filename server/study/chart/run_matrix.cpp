// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/chart/run_matrix.h"

#include <algorithm>
#include <mutex>

#include "core/parallel_for.h"
#include "study/harness/pulse.h"

namespace livegs::study {
namespace {

// Plans all curves of one panel: one scene at one modulus.
void plan_panel(const ChartScene& scene, double youngs_modulus_pa, const ChartPlan& plan,
                std::vector<PlannedRun>& runs) {
  const std::vector<int> substeps =
      plan.quick ? std::vector<int>{1, 4, 16} : std::vector<int>{1, 2, 4, 8, 16, 32, 64};
  const auto curve = [&](Setup setup, int most) {
    setup.youngs_modulus_pa = youngs_modulus_pa;
    setup.poisson_ratio = scene.poisson_ratio;
    setup.spacing_m = std::min(setup.spacing_m, setup.cell_width_m);
    for (const int n : substeps) {
      if (n > most) break;
      setup.substeps = n;
      runs.push_back({&scene, "", setup});
    }
  };
  const size_t widths = plan.quick ? 1 : scene.cell_widths_m.size();
  for (size_t i = 0; i < widths; ++i) {
    Setup setup;
    setup.cell_width_m = scene.cell_widths_m[i];
    curve(setup, 64);
  }
  for (const CellsOptions options :
       {CellsOptions{.compensate = false, .choose = false},
        CellsOptions{.second_order = false, .choose = false},
        CellsOptions{.second_order = false, .compensate = false, .choose = false}}) {
    Setup setup;
    setup.cell_width_m = scene.cell_widths_m[0];
    setup.cells = options;
    curve(setup, 64);
  }
  for (const Engine engine : {Engine::LivegsV1, Engine::LivegsV1Steady, Engine::Bullet}) {
    Setup setup;
    setup.engine = engine;
    // Bullet costs a hundred times as much per node, so it gets wide cells and few substeps.
    if (engine == Engine::Bullet) setup.cell_width_m = 0.05;
    curve(setup, engine == Engine::Bullet ? scene.max_bullet_substeps : 64);
  }
  Setup chosen;
  chosen.cells.choose = true;
  chosen.cell_width_m = 0.0;
  chosen.youngs_modulus_pa = youngs_modulus_pa;
  chosen.poisson_ratio = scene.poisson_ratio;
  runs.push_back({&scene, "chosen", chosen});
}

// Plans the table by modulus: 4 requested substeps, default budget.
void plan_table(const ChartPlan& plan, std::vector<PlannedRun>& runs) {
  for (const ChartScene& scene : chart_scenes()) {
    if (scene.name != "tension" && scene.name != "ring_down") continue;
    for (const double rate_hz : {60.0, 90.0}) {
      for (const double modulus : {1e4, 1e5, 1e6, 1e7}) {
        if (plan.quick && modulus > 5e5) continue;
        for (const Engine engine : {Engine::Cells, Engine::LivegsV1}) {
          Setup setup;
          setup.engine = engine;
          setup.rate_hz = rate_hz;
          setup.youngs_modulus_pa = modulus;
          setup.poisson_ratio = scene.poisson_ratio;
          setup.cells.choose = true;
          if (engine == Engine::Cells) setup.cell_width_m = 0.0;
          runs.push_back({&scene, "table", setup});
        }
      }
    }
  }
}

// Plans pulses at steps that resolve the wave and at the default step.
void plan_pulse(const ChartPlan& plan, std::vector<PlannedRun>& runs) {
  static const ChartScene scene{.name = "pulse", .run = [](const Setup& setup) { return pulse(setup); }};
  for (const double modulus : {1e4, 1e5, 1e6}) {
    if (plan.quick && modulus > 5e5) continue;
    Setup setup;
    setup.youngs_modulus_pa = modulus;
    setup.poisson_ratio = 0.0;
    for (const int substeps : {4, 8, 16, 32, 64}) {
      setup.substeps = substeps;
      runs.push_back({&scene, "table", setup});
    }
    setup.substeps = 4;
    setup.cells.choose = true;
    setup.cell_width_m = 0.0;
    runs.push_back({&scene, "table", setup});
  }
}

}  // namespace

std::vector<PlannedRun> plan_runs(const ChartPlan& plan) {
  std::vector<PlannedRun> runs;
  for (const ChartScene& scene : chart_scenes()) {
    if (!plan.only.empty() && scene.name != plan.only) continue;
    for (const double modulus : scene.youngs_moduli_pa) {
      if (plan.quick && modulus > 5e5 && scene.youngs_moduli_pa.size() > 1) continue;
      plan_panel(scene, modulus, plan, runs);
    }
  }
  if (plan.only.empty()) {
    plan_table(plan, runs);
    plan_pulse(plan, runs);
  }
  return runs;
}

std::vector<ChartRow> run_all(
    const std::vector<PlannedRun>& runs,
    const std::function<void(size_t done, size_t of, const PlannedRun&)>& progress) {
  std::vector<std::optional<ChartRow>> found(runs.size());
  std::mutex telling;  // guards `done` and the calls of `progress`
  size_t done = 0;
  parallel_for(runs.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const PlannedRun& run = runs[i];
      if (auto outcome = run.scene->run(run.setup))
        found[i] = ChartRow{run.scene->name, run.variant, run.setup, *outcome};
      const std::lock_guard lock(telling);
      progress(++done, runs.size(), run);
    }
  });
  std::vector<ChartRow> rows;
  for (auto& row : found) {
    if (row) rows.push_back(std::move(*row));
  }
  return rows;
}

}  // namespace livegs::study
