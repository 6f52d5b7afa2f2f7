// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

namespace livegs {

// How many threads parallel_for may use from now on, in the whole process; 0 means one a core. Call before
// work starts: it does not stop what is running.
void set_thread_count(int threads);
int thread_count();

// Calls `body(begin, end)` for consecutive blocks of `block` items that cover [0, count), on several threads.
// Blocks depend on `count` and `block` only, never on the number of threads: a body that writes only its own
// items (or one partial sum a block, added up in block order afterwards) gives the same bits for any thread
// count. Returns when every block is done. Of what bodies throw one exception reaches the caller, once no
// body runs any more; blocks that had not begun are left out.
void parallel_for(size_t count, size_t block, const std::function<void(size_t begin, size_t end)>& body);

}  // namespace livegs
