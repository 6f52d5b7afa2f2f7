// SPDX-License-Identifier: Apache-2.0
// parallel_for for targets without threads (WebAssembly), instead of parallel_for.cpp: the same blocks, in
// order.
#include <algorithm>

#include "core/parallel_for.h"
#include "core/serial_here.h"

namespace livegs {

void set_thread_count(int) {}
int thread_count() { return 1; }
void set_serial_here(bool) {}

void parallel_for(size_t count, size_t block, const std::function<void(size_t, size_t)>& body) {
  block = std::max<size_t>(block, 1);
  for (size_t begin = 0; begin < count; begin += block) body(begin, std::min(count, begin + block));
}

}  // namespace livegs
