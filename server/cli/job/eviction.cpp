// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/job/eviction.h"

#include <semaphore.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <utility>

namespace livegs {
namespace {

// Attempts to remove a folder in which the work still creates files, and the pause between them.
constexpr int kRemovals = 20;
constexpr std::chrono::milliseconds kRemovalPause{5};

std::atomic<int> eviction_asked = 0;  // the signal
static_assert(std::atomic<int>::is_always_lock_free, "a handler may write it");
sem_t eviction_wake;  // a handler may post it

extern "C" void note_eviction(int signal_number) {
  const int kept = errno;
  eviction_asked = signal_number;
  ::sem_post(&eviction_wake);
  errno = kept;
}

}  // namespace

Eviction::Eviction(std::filesystem::path folder) : folder_(std::move(folder)) {
  ::sem_init(&eviction_wake, 0, 0);
  watcher_ = std::thread([this] { watch(); });
  listen();
  for (const int number : {SIGINT, SIGHUP}) {
    if (std::signal(number, note_eviction) == SIG_IGN) std::signal(number, SIG_IGN);
  }
}

void Eviction::listen() const { std::signal(SIGTERM, note_eviction); }
bool Eviction::asked() const { return eviction_asked != 0; }

Eviction::~Eviction() {
  ::sem_post(&eviction_wake);
  watcher_.join();
}

void Eviction::watch() const {
  while (::sem_wait(&eviction_wake) != 0) {
  }
  if (eviction_asked == 0) return;
  std::error_code ignored;
  for (int i = 0; i < kRemovals && std::filesystem::exists(folder_, ignored); ++i) {
    if (i > 0) std::this_thread::sleep_for(kRemovalPause);
    std::filesystem::remove_all(folder_, ignored);
  }
  ::_exit(eviction_asked == SIGTERM ? kRetryExit : 128 + eviction_asked);
}

}  // namespace livegs
