// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>
#include <string_view>

// Mechanisms of the solvers that can be disabled one at a time, which shows the purpose of each and what it
// costs (tests/bench/ablation, which finds their names in the sources). Only in a build with LIVEGS_ABLATION,
// by the environment variable LIVEGS_WITHOUT; otherwise nothing is left out, at no cost.

namespace livegs {

#ifdef LIVEGS_ABLATION
inline bool without(std::string_view mechanism) {
  static const char* const named = std::getenv("LIVEGS_WITHOUT");
  return named != nullptr && mechanism == named;
}
#else
constexpr bool without(std::string_view) { return false; }
#endif

}  // namespace livegs
