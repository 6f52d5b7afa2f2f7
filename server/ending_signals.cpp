// SPDX-License-Identifier: GPL-3.0-or-later
#include "ending_signals.h"

#include <string.h>
#include <time.h>

namespace livegs {

sigset_t block_ending_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN);  // a file over its size limit is a write error, like a full disk
  return signals;
}

std::string wait_for_signal(const sigset_t& signals, const std::function<bool()>& enough) {
  constexpr timespec kAskEvery{0, 20'000'000};
  while (!enough()) {
    const int signal_number = sigtimedwait(&signals, nullptr, &kAskEvery);
    if (signal_number > 0) return std::string("stopped by a signal (") + strsignal(signal_number) + ")";
  }
  return "";
}

}  // namespace livegs
