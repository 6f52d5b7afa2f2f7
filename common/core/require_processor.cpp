// SPDX-License-Identifier: Apache-2.0
// Compiled for baseline x86-64 (see CMakeLists.txt), without precompiled headers and unity builds: this file
// must not need the instruction set that it checks.
#include <unistd.h>

#include <cstdlib>
#include <cstring>

namespace {

[[maybe_unused]] constexpr char kArch[] = LIVEGS_ARCH;

// True for instruction sets that the compiler cannot check, such as "native".
bool supports_arch() {
  if (std::getenv("LIVEGS_TEST_OLD_PROCESSOR") != nullptr) return false;
#if defined(__x86_64__) && !defined(__clang__)
  __builtin_cpu_init();
  if (std::strcmp(kArch, "x86-64-v2") == 0) return __builtin_cpu_supports("x86-64-v2") != 0;
  if (std::strcmp(kArch, "x86-64-v3") == 0) return __builtin_cpu_supports("x86-64-v3") != 0;
  if (std::strcmp(kArch, "x86-64-v4") == 0) return __builtin_cpu_supports("x86-64-v4") != 0;
#endif
  return true;
}

// Priority 101 is the first that programs may use.
__attribute__((constructor(101))) void check_processor() {
  if (supports_arch()) return;
  constexpr char kLine[] =
      "processor: has no " LIVEGS_ARCH
      " instructions (v3 is AVX2, FMA and BMI2); configure with -DLIVEGS_ARCH=x86-64-v2 and build again\n";
  [[maybe_unused]] const auto written = write(STDERR_FILENO, kLine, sizeof(kLine) - 1);
  _exit(1);
}

}  // namespace

namespace livegs {
void require_processor() {}
}  // namespace livegs
