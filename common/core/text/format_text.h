// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace livegs {

// Formats as std::printf does, into a string of any length. The compiler checks the arguments. Any thread.
__attribute__((format(printf, 1, 2))) std::string format_text(const char* format, ...);

}  // namespace livegs
