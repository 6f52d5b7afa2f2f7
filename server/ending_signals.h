// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <signal.h>

#include <functional>
#include <string>

// Signals that end the server: SIGINT and SIGTERM.

namespace livegs {

// Blocks them for all threads that are started later, and ignores SIGPIPE and SIGXFSZ. Call before other
// threads.
sigset_t block_ending_signals();

// Waits for one of them, or until `enough` returns true; asks it every 20 ms. Returns the reason; empty
// without a signal.
std::string wait_for_signal(const sigset_t& signals, const std::function<bool()>& enough);

}  // namespace livegs
