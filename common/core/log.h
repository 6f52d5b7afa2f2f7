// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

// The only output channel of library rooms. Lines go to standard error; standard output is reserved for the
// program's result.
//
//   info   the story of a run; fits on a screen
//   debug  may be verbose
//   warn   needs attention
//   error  something was lost
//
// Any thread. Lines are never interleaved.

namespace livegs {

enum class LogLevel { Debug, Info, Warn, Error, Off };

void set_log_level(LogLevel level);

void log_debug(const char* format, ...) __attribute__((format(printf, 1, 2)));
void log_info(const char* format, ...) __attribute__((format(printf, 1, 2)));
void log_warn(const char* format, ...) __attribute__((format(printf, 1, 2)));
void log_error(const char* format, ...) __attribute__((format(printf, 1, 2)));

}  // namespace livegs
