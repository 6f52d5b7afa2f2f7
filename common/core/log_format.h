// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace livegs {

// Switches the log to one JSON object per line, for log collectors:
//   {"time":"2026-11-22T17:00:00.123Z","level":"info","message":"session 1a2b3c4d: …"}
// Call before other threads log.
void log_as_json();

}  // namespace livegs
