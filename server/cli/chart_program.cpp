// SPDX-License-Identifier: GPL-3.0-or-later
// `livegs chart` runs livegs-chart, which is in the folder of this program if the study was built
// (LIVEGS_STUDY).
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.h"

namespace livegs {
namespace {

int run_chart_program(const std::vector<std::string>& arguments) {
  std::error_code unreadable;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", unreadable);
  const std::filesystem::path program = own.parent_path() / "livegs-chart";
  if (unreadable || !std::filesystem::exists(program)) {
    return report({ErrorCode::Unsupported,
                   "chart: livegs-chart is missing next to livegs; build the target livegs-chart (it is not "
                   "installed)"});
  }
  std::vector<std::string> words = {program.string(), "chart"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  execv(program.c_str(), pointers.data());
  return report({ErrorCode::Unavailable, program.string() + ": cannot be started: " + std::strerror(errno) +
                                             "; build the target livegs-chart again"});
}

}  // namespace

void add_chart(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "chart", "Run the benchmark scenes and plot error against cost; options: livegs chart --help");
  command->set_help_flag("");  // livegs-chart prints the help of its options
  command->fallthrough(false);
  command->allow_extras();
  command->callback([&app, command, &exit_code] {
    std::vector<std::string> arguments = command->remaining();
    if (const CLI::Option* threads = app.get_option("--threads"); threads->count() > 0) {
      arguments.insert(arguments.end(), {"--threads", threads->as<std::string>()});
    }
    exit_code = run_chart_program(arguments);
  });
}

}  // namespace livegs
