// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstdio>
#include <filesystem>
#include <memory>

#include "cli/commands.h"
#include "cli/output_path.h"
#include "core/clock.h"
#include "core/file.h"
#include "core/log.h"
#include "core/parallel_for.h"
#include "core/written_files.h"
#include "study/chart/ablation_chart.h"
#include "study/chart/chart_figure.h"
#include "study/chart/chart_page.h"
#include "study/chart/rigid_chart.h"
#include "study/chart/run_matrix.h"

namespace livegs {
namespace {

struct ChartCommand {
  std::filesystem::path output = "out/chart";
  std::string only, without;
  bool quick = false;
};

constexpr const char* kAblation = "ablation";

// Writes ablation.csv, ablation.md and ablation.svg.
int run_ablation_chart(const ChartCommand& options) {
  set_thread_count(1);
  const int64_t start_ns = now_ns();
  int64_t reported_ns = start_ns;
  std::optional<Mechanism> only;
  for (const study::MechanismText& text : study::all_mechanisms()) {
    if (options.without == text.name) only = text.mechanism;
  }
  const auto pairs =
      study::run_ablation(only, [&](size_t done, size_t of, const std::string& scene, const char* without) {
        if (now_ns() - reported_ns < 2'000'000'000) return;
        reported_ns = now_ns();
        std::fprintf(stderr, "%3zu %%  %zu of %zu pairs of runs, %.0f s; %s without %s\n", 100 * done / of,
                     done, of, seconds_from_ns(reported_ns - start_ns), scene.c_str(), without);
      });
  const auto effects = study::effects_of(pairs);
  for (const auto& [name, text] : {std::pair{"ablation.csv", study::ablation_csv(effects)},
                                   std::pair{"ablation.md", study::ablation_page(effects, LIVEGS_VERSION)}}) {
    if (auto written = write_file_atomically(options.output / name, text); !written)
      return report(written.error());
    note_written(options.output / name);
  }
  const std::filesystem::path svg = options.output / "ablation.svg";
  if (auto drawn = study::draw_ablation(effects, svg); !drawn) return report(drawn.error());
  note_written(svg);
  std::fputs(written_files_text().c_str(), stdout);
  std::printf("%zu pairs of runs in %.0f s\n", pairs.size(), seconds_from_ns(now_ns() - start_ns));
  return 0;
}

int run(const ChartCommand& options) {
  if (auto checked = check_output_folder(options.output); !checked) return report(checked.error());
  std::error_code error;
  std::filesystem::create_directories(options.output, error);
  if (error) {
    return report({ErrorCode::PermissionDenied, options.output.string() + ": cannot be created: " +
                                                    error.message() + "; give another folder with --output"});
  }
  // Warnings are suppressed: the study runs solvers beyond their limits on purpose.
  set_log_level(LogLevel::Error);
  if (options.only == kAblation) return run_ablation_chart(options);
  const int64_t start_ns = now_ns();
  int64_t reported_ns = start_ns;
  const auto progress = [&](size_t done, size_t of, const study::PlannedRun& run) {
    if (now_ns() - reported_ns < 2'000'000'000 && done != of) return;
    reported_ns = now_ns();
    std::fprintf(stderr, "%3zu %%  %zu of %zu runs, %.0f s; %s, %s at %d substeps\n", 100 * done / of, done,
                 of, seconds_from_ns(reported_ns - start_ns), run.scene->name.c_str(),
                 study::solver_name(run.setup).c_str(), run.setup.substeps);
  };
  const study::ChartPlan plan{options.only, options.quick};
  const auto rows = study::run_all(study::plan_runs(plan), progress);
  set_thread_count(1);
  const auto rigid_progress = [&](size_t done, size_t of, const study::RigidChartScene& scene,
                                  const study::RigidSetup& setup) {
    if (now_ns() - reported_ns < 2'000'000'000) return;
    reported_ns = now_ns();
    std::fprintf(stderr, "%3zu %%  %zu of %zu rigid runs, %.0f s; %s, %s at %d substeps\n", 100 * done / of,
                 done, of, seconds_from_ns(reported_ns - start_ns), scene.name.c_str(),
                 study::engine_name(setup.engine).c_str(), setup.substeps);
  };
  const auto rigid_rows = study::run_rigid_scenes(plan, rigid_progress);

  if (auto written = write_file_atomically(options.output / "chart.csv",
                                           study::chart_csv(rows) + study::rigid_csv(rigid_rows));
      !written) {
    return report(written.error());
  }
  const std::string how = options.quick ? "--quick" : "";
  const std::string page = study::chart_page(rows, how, LIVEGS_VERSION) + study::rigid_page(rigid_rows);
  if (auto written = write_file_atomically(options.output / "chart.md", page); !written)
    return report(written.error());
  note_written(options.output / "chart.csv");
  note_written(options.output / "chart.md");
  for (const study::ChartScene& scene : study::chart_scenes()) {
    for (const std::string& quantity : scene.quantities) {
      const auto panels = study::panels_of(scene, quantity, rows);
      if (panels.empty()) continue;
      const std::filesystem::path svg = options.output / scene.figure(quantity);
      if (auto drawn = draw_figure(study::elastic_figure(scene, panels), svg); !drawn)
        return report(drawn.error());
      note_written(svg);
    }
  }
  for (const study::RigidChartScene& scene : study::rigid_chart_scenes()) {
    const std::filesystem::path svg = options.output / scene.figure();
    if (auto drawn = draw_figure(rigid_figure(scene, rigid_rows), svg); !drawn) return report(drawn.error());
    note_written(svg);
  }
  std::fputs(written_files_text().c_str(), stdout);
  std::printf("%zu runs in %.0f s\n", rows.size() + rigid_rows.size(), seconds_from_ns(now_ns() - start_ns));
  return 0;
}

}  // namespace

void add_chart(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ChartCommand>();
  CLI::App* command =
      app.add_subcommand("chart",
                         "Run the benchmark scenes, elastic and rigid, over substeps, cell widths "
                         "and stiffness, and plot error against cost");
  std::vector<std::string> names;
  for (const study::ChartScene& scene : study::chart_scenes()) names.push_back(scene.name);
  for (const study::RigidChartScene& scene : study::rigid_chart_scenes()) names.push_back(scene.name);
  names.emplace_back(kAblation);
  command->add_option("--output,-o", options->output, "Folder for the CSV, the page and the pictures")
      ->type_name("FOLDER")
      ->capture_default_str();
  command
      ->add_option("--only", options->only,
                   "Run this scene only; ablation: instead of the curves, disable each "
                   "mechanism of the solvers in turn")
      ->check(CLI::IsMember(names));
  std::vector<std::string> mechanisms;
  for (const study::MechanismText& text : study::all_mechanisms()) mechanisms.emplace_back(text.name);
  command->add_option("--without", options->without, "With --only ablation: disable this mechanism only")
      ->check(CLI::IsMember(mechanisms));
  command->add_flag("--quick", options->quick, "Short run: few substeps, one cell width, soft bodies");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace livegs
