// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace livegs {

// Set by the top-level CMakeLists.txt.
inline constexpr const char* kVersion = LIVEGS_VERSION;

}  // namespace livegs
