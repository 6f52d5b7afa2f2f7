// SPDX-License-Identifier: Apache-2.0
#include "server/session/simulation/failing_memory.h"

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>

namespace livegs {
namespace {

enum State { kNothing, kArmed, kArmedForGood, kFailed, kFailing };
std::atomic<State> state{kNothing};
std::atomic<bool> no_threads{false};
std::atomic<int64_t> left{0};
char name_of_thread[16] = {};
thread_local int unfailing = 0;

bool fails_here() {
  const State now = state.load(std::memory_order_acquire);
  if (now == kNothing || now == kFailed || unfailing > 0) return false;
  char name[16] = {};
  if (pthread_getname_np(pthread_self(), name, sizeof name) != 0 || std::strcmp(name, name_of_thread) != 0) return false;
  if (now == kFailing) return true;
  if (--left != 0) return false;
  State armed = now;
  return state.compare_exchange_strong(armed, now == kArmed ? kFailed : kFailing);
}

void arm(std::string_view thread_name, int64_t number, State how) {
  state = kNothing;
  name_of_thread[thread_name.copy(name_of_thread, sizeof name_of_thread - 1)] = 0;
  left = number;
  state.store(how, std::memory_order_release);
}

void* allocate(std::size_t bytes, std::size_t alignment = 0) {
  while (fails_here()) {
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
  if (bytes == 0) bytes = 1;
  void* const memory = alignment == 0 ? std::malloc(bytes) : std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void fail_allocation(std::string_view thread_name, int64_t number) { arm(thread_name, number, kArmed); }
void fail_allocations_from(std::string_view thread_name, int64_t number) { arm(thread_name, number, kArmedForGood); }

bool allocation_has_failed() { return state == kFailed || state == kFailing; }
bool end_failing() {
  const State was = state.exchange(kNothing);
  return was == kFailed || was == kFailing;
}

Unfailing::Unfailing() { ++unfailing; }
Unfailing::~Unfailing() { --unfailing; }

void fail_threads(bool fail) { no_threads = fail; }
bool threads_fail() { return no_threads; }

}  // namespace livegs

void* operator new(std::size_t bytes) { return livegs::allocate(bytes); }
void* operator new(std::size_t bytes, std::align_val_t alignment) { return livegs::allocate(bytes, static_cast<std::size_t>(alignment)); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

// Sanitizers have one of their own.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
namespace livegs {
bool threads_fail();
}
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*begin)(void*), void* argument) noexcept {
  if (livegs::threads_fail()) return EAGAIN;
  static const auto create = reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
  return create(thread, attributes, begin, argument);
}
#endif
