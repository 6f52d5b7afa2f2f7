// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace livegs {

// As in the top-level CMakeLists.txt, which passes it in.
inline constexpr const char* kVersion = LIVEGS_VERSION;

}  // namespace livegs
