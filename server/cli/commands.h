// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "core/result.h"

// The commands of `livegs`. Each function adds a command and its options to `app`. If the command is
// selected, it runs and sets the exit code: 0 success, 1 failure, 2 bad usage or input.

namespace livegs {

void add_info(CLI::App& app, int& exit_code);
void add_capture(CLI::App& app, int& exit_code);
void add_convert(CLI::App& app, int& exit_code);
void add_sample(CLI::App& app, int& exit_code);
void add_train(CLI::App& app, int& exit_code);
void add_render(CLI::App& app, int& exit_code);
void add_segment(CLI::App& app, int& exit_code);
void add_mesh(CLI::App& app, int& exit_code);
void add_fit(CLI::App& app, int& exit_code);
void add_fracture(CLI::App& app, int& exit_code);
void add_simulate(CLI::App& app, int& exit_code);
void add_analyze(CLI::App& app, int& exit_code);
void add_chart(CLI::App& app, int& exit_code);
void add_ctl(CLI::App& app, int& exit_code);
void add_token(CLI::App& app, int& exit_code);
void add_publish(CLI::App& app, int& exit_code);
void add_export(CLI::App& app, int& exit_code);

// Prints "livegs: " and the error on one line. Returns the exit code for it: 2 if the user can correct the
// input, 1 otherwise.
int report(const Error& error);

}  // namespace livegs
