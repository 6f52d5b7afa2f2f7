// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace livegs::bench {

// Parses the arguments. Prints --help, or one line for an invalid argument with exit code 2.
inline void read_arguments(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) std::exit(app.exit(error));  // --help
    std::fprintf(stderr, "%s: %s; see --help\n", app.get_name().c_str(), error.what());
    std::exit(2);
  }
}

// Accepts numbers in a range. NaN is never in range, which CLI::Range does not check.
inline CLI::Validator between(double lowest, double highest) {
  char range[64];
  std::snprintf(range, sizeof range, "%g to %g", lowest, highest);
  return CLI::Validator(
      [lowest, highest, wanted = std::string(range)](const std::string& text) {
        double value = 0;
        const bool is_in = CLI::detail::lexical_cast(text, value) && value >= lowest && value <= highest;
        return is_in ? std::string() : "\"" + text + "\" is not " + wanted;
      },
      range);
}

}  // namespace livegs::bench
