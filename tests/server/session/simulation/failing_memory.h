// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

// operator new and pthread_create of the whole program, which fail when a test says so. An allocation that fails asks the new handler, if
// there is one, and is tried again: one that fails once is helped by it, one of those that go on failing is not.

namespace livegs {

// From now on the `number`-th allocation (1: the next) of threads of this name throws std::bad_alloc; no other does. One thread
// of a test calls it.
void fail_allocation(std::string_view thread_name, int64_t number);
// The same, and each of its allocations after that one.
void fail_allocations_from(std::string_view thread_name, int64_t number);
// Whether it has come.
bool allocation_has_failed();
// The same, and from now on none fails.
bool end_failing();

// While one lives nothing fails on this thread: what is the test's own.
class Unfailing {
 public:
  Unfailing();
  ~Unfailing();
};

// Whether a thread can be made.
void fail_threads(bool fail);

}  // namespace livegs
