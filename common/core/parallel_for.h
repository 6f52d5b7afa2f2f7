// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

namespace livegs {

// Sets the maximum number of threads of parallel_for in the whole process; 0: one per core. Call before work
// starts: running calls keep their threads.
void set_thread_count(int threads);
int thread_count();

// Calls `body(begin, end)` for consecutive blocks of `block` items that cover [0, count), on several threads.
// Returns when every block is done.
//
// Blocks depend only on `count` and `block`, never on the number of threads. A body that writes only its own
// items, or one partial sum per block that is added in block order afterwards, gives the same bits for any
// thread count.
//
// If bodies throw, one of the exceptions is rethrown to the caller after all running bodies have returned.
// Blocks that had not started are skipped.
void parallel_for(size_t count, size_t block, const std::function<void(size_t begin, size_t end)>& body);

}  // namespace livegs
