// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sanitizers of this build: LIVEGS_ADDRESS_SANITIZER and LIVEGS_THREAD_SANITIZER are 1 or 0. GCC defines a
// macro for each, clang has a feature.

#if defined(__has_feature)
#define LIVEGS_ADDRESS_SANITIZER __has_feature(address_sanitizer)
#define LIVEGS_THREAD_SANITIZER __has_feature(thread_sanitizer)
#else
#if defined(__SANITIZE_ADDRESS__)
#define LIVEGS_ADDRESS_SANITIZER 1
#else
#define LIVEGS_ADDRESS_SANITIZER 0
#endif
#if defined(__SANITIZE_THREAD__)
#define LIVEGS_THREAD_SANITIZER 1
#else
#define LIVEGS_THREAD_SANITIZER 0
#endif
#endif

#if LIVEGS_ADDRESS_SANITIZER
#include <sanitizer/lsan_interface.h>
#endif

namespace livegs {

// Leaks of memory that the thread allocates during the lifetime of this object are not reported. For calls of
// libraries that keep memory until the process ends.
#if LIVEGS_ADDRESS_SANITIZER
using IgnoredLeaks = __lsan::ScopedDisabler;
#else
struct IgnoredLeaks {};
#endif

}  // namespace livegs
