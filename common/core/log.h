// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

// The only way a library room speaks. Lines go to standard error, so that standard output stays the program's
// answer. info is the story of a run and fits on a screen; debug may be verbose; warn means someone should
// look; error means something was lost. Any thread may call; a line is never torn.

namespace livegs {

enum class LogLevel { Debug, Info, Warn, Error, Off };

void set_log_level(LogLevel level);

void log_debug(const char* format, ...) __attribute__((format(printf, 1, 2)));
void log_info(const char* format, ...) __attribute__((format(printf, 1, 2)));
void log_warn(const char* format, ...) __attribute__((format(printf, 1, 2)));
void log_error(const char* format, ...) __attribute__((format(printf, 1, 2)));

}  // namespace livegs
