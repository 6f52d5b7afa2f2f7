// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cstdio>
#include <string>

#include "cli/commands.h"
#include "core/log.h"
#include "core/parallel_for.h"
#include "core/require_processor.h"
#include "core/text/help_format.h"

namespace {

const CLI::Option* option_of(const CLI::App* app, const std::string& name) {
  for (; app != nullptr; app = app->get_parent()) {
    if (const auto* option = app->get_option_no_throw(name)) return option;
  }
  return nullptr;
}

// Returns the error for an unknown word in the position of a command; empty if there is none.
std::string unknown_command(const CLI::App& app, int argc, char** argv) {
  const CLI::App* at = &app;
  std::string path = app.get_name();
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.size() > 1 && word.front() == '-') {
      const auto* option = option_of(at, word);  // an option with `=` includes its value
      if (option && option->get_items_expected_max() > 0) ++i;
      continue;
    }
    const auto commands = at->get_subcommands([](const CLI::App*) { return true; });
    if (commands.empty()) return "";
    const auto known = std::find_if(commands.begin(), commands.end(),
                                    [&](const CLI::App* one) { return one->get_name() == word; });
    if (known == commands.end()) {
      std::string names;
      for (const CLI::App* one : commands) names += (names.empty() ? "" : ", ") + one->get_name();
      return path + ": unknown command \"" + word + "\"; available: " + names;
    }
    at = *known;
    path += " " + at->get_name();
  }
  return "";
}

}  // namespace

int main(int argc, char** argv) {
  livegs::require_processor();
  CLI::App app("Command-line tools for LiveGS, physically simulated Gaussian splats", "livegs");
  app.set_version_flag("--version", LIVEGS_VERSION);
  app.require_subcommand(1);
  int threads = 0;
  bool quiet = false, verbose = false;
  app.add_option("--threads", threads, "Number of threads (0: one per core); does not affect results")
      ->check(CLI::Range(0, 256));
  app.add_flag("--quiet", quiet, "Print errors only");
  app.add_flag("--verbose", verbose, "Print debug messages");
  app.parse_complete_callback([&] {
    livegs::set_thread_count(threads);
    if (quiet) livegs::set_log_level(livegs::LogLevel::Warn);
    if (verbose) livegs::set_log_level(livegs::LogLevel::Debug);
  });
  app.formatter(std::make_shared<livegs::HelpFormatter>());  // also of the commands
  app.fallthrough();  // global options are also accepted after the command

  int exit_code = 0;
  livegs::add_info(app, exit_code);
  livegs::add_convert(app, exit_code);
  livegs::add_sample(app, exit_code);
  livegs::add_capture(app, exit_code);
  livegs::add_train(app, exit_code);
  livegs::add_render(app, exit_code);
  livegs::add_segment(app, exit_code);
  livegs::add_mesh(app, exit_code);
  livegs::add_fracture(app, exit_code);
  livegs::add_simulate(app, exit_code);
  livegs::add_analyze(app, exit_code);
  livegs::add_fit(app, exit_code);
  livegs::add_chart(app, exit_code);
  livegs::add_export(app, exit_code);
  livegs::add_publish(app, exit_code);
  livegs::add_ctl(app, exit_code);
  livegs::add_token(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (const std::string unknown = error.get_exit_code() == 0 ? "" : unknown_command(app, argc, argv);
        !unknown.empty()) {
      std::fprintf(stderr, "%s\n", unknown.c_str());
      return 2;
    }
    return app.exit(error) == 0 ? 0 : 2;
  }
  return exit_code;
}
