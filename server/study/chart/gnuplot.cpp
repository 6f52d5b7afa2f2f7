// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/chart/gnuplot.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/file.h"

namespace livegs::study {
namespace {

// Runs `gnuplot SCRIPT` and waits for it.
bool run_gnuplot(const std::string& script) {
  std::string program = "gnuplot", argument = script;
  char* words[] = {program.data(), argument.data(), nullptr};
  pid_t child = 0;
  if (posix_spawnp(&child, "gnuplot", nullptr, nullptr, words, environ) != 0) return false;
  int status = 0;
  return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

std::string gnuplot_text(const std::string& text) {
  std::string twice;
  for (const char c : text) twice += c == '\'' ? "''" : std::string(1, c);
  return twice;
}

Result<void> draw_with_gnuplot(const std::filesystem::path& svg, size_t width, size_t height,
                               const std::function<void(std::FILE* out)>& write) {
  const std::string path = svg.string();
  const std::filesystem::path script = path + ".gp";
  std::FILE* out = std::fopen(script.c_str(), "w");
  if (!out) return file_error(script, "cannot be written");
  std::fprintf(out,
               "set terminal svg size %zu,%zu font 'Helvetica,12' background rgb 'white'\nset output '%s'\n",
               width, height, gnuplot_text(path).c_str());
  write(out);
  std::fclose(out);
  const bool drawn = run_gnuplot(script.string());
  std::error_code ignored;
  std::filesystem::remove(script, ignored);
  if (!drawn)
    return Error{ErrorCode::Unavailable, "gnuplot: could not draw " + path + "; install gnuplot-nox"};
  return {};
}

}  // namespace livegs::study
