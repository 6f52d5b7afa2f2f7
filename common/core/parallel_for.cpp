// SPDX-License-Identifier: Apache-2.0
#include "core/parallel_for.h"

#include "core/sanitizers.h"
#include "core/serial_here.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace livegs {
namespace {

std::mutex control_mutex;  // guards control
std::unique_ptr<tbb::global_control> control;
thread_local bool serial_here = false;

#if LIVEGS_THREAD_SANITIZER
// TBB is not built for the thread sanitizer, which would report each of its hand-overs as a race. This build
// uses plain threads with relaxed atomics: only their start and join order memory.
template <class Run>
void run_blocks(size_t blocks, const Run& run) {
  std::atomic<size_t> next{0};
  std::mutex mutex;  // guards thrown
  std::exception_ptr thrown;
  const auto work = [&] {
    try {
      for (size_t i = next.fetch_add(1, std::memory_order_relaxed); i < blocks;
           i = next.fetch_add(1, std::memory_order_relaxed)) {
        run(i);
      }
    } catch (...) {
      next.store(blocks, std::memory_order_relaxed);
      std::lock_guard lock(mutex);
      thrown = std::current_exception();
    }
  };
  std::vector<std::thread> helpers;
  for (size_t k = 1; k < std::min(blocks, static_cast<size_t>(thread_count())); ++k)
    helpers.emplace_back(work);
  work();
  for (std::thread& helper : helpers) helper.join();
  if (thrown) std::rethrow_exception(thrown);
}
#else
template <class Run>
void run_blocks(size_t blocks, const Run& run) {
  tbb::parallel_for(size_t{0}, blocks, run);
}
#endif

}  // namespace

void set_thread_count(int threads) {
  const int count =
      threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  std::lock_guard lock(control_mutex);
  control.reset();
  control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                  static_cast<size_t>(count));
}

void set_serial_here(bool serial) { serial_here = serial; }

int thread_count() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void parallel_for(size_t count, size_t block, const std::function<void(size_t, size_t)>& body) {
  if (count == 0) return;
  block = std::max<size_t>(block, 1);
  const size_t blocks = (count + block - 1) / block;
  const auto run = [&](size_t index) { body(index * block, std::min(count, (index + 1) * block)); };
  if (blocks == 1 || serial_here) {
    for (size_t index = 0; index < blocks; ++index) run(index);
    return;
  }
  run_blocks(blocks, run);
}

}  // namespace livegs
