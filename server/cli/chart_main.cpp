// SPDX-License-Identifier: GPL-3.0-or-later
// livegs-chart: the program behind `livegs chart`. It alone links the study room with its peers, Bullet and
// ODE, so that `livegs` does not. Exit codes: 0 done, 1 could not do it, 2 bad usage or input.
#include "cli/commands.h"
#include "core/parallel_for.h"
#include "core/require_processor.h"

int main(int argc, char** argv) {
  livegs::require_processor();
  CLI::App app("Charts of error against cost; called by `livegs chart`", "livegs");
  app.require_subcommand(1);
  int threads = 0;
  app.add_option("--threads", threads, "Number of threads (0: one per core)")->check(CLI::Range(0, 256));
  app.parse_complete_callback([&] { livegs::set_thread_count(threads); });
  app.fallthrough();
  int exit_code = 0;
  livegs::add_chart(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return exit_code;
}
