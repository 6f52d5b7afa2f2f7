// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "core/result.h"

// The verbs of `livegs`. Each adds its options to `app` and, when it is the one that was called, runs and
// returns the exit code: 0 done, 1 could not do it, 2 bad usage or input.

namespace livegs {

void add_info(CLI::App& app, int& exit_code);
void add_convert(CLI::App& app, int& exit_code);
void add_sample(CLI::App& app, int& exit_code);
void add_render(CLI::App& app, int& exit_code);
void add_mesh(CLI::App& app, int& exit_code);
void add_fracture(CLI::App& app, int& exit_code);
void add_simulate(CLI::App& app, int& exit_code);
void add_analyze(CLI::App& app, int& exit_code);
void add_chart(CLI::App& app, int& exit_code);
void add_ctl(CLI::App& app, int& exit_code);

// Prints "livegs: " and the one line, and gives the exit code that belongs to it: 2 for what the user can
// mend in the input, 1 for what the machine would not do.
int report(const Error& error);

}  // namespace livegs
