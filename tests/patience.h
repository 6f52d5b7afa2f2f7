// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace livegs {

// Timeout for conditions that normally hold at once. Long enough for a loaded machine with a sanitizer.
inline constexpr std::chrono::seconds kPatience{60};

}  // namespace livegs
