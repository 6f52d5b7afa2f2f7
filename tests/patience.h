// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace livegs {

// How long a test waits for what should be there at once: a loaded machine under a sanitizer is slow.
inline constexpr std::chrono::seconds kPatience{60};

}  // namespace livegs
