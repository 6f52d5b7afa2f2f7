// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace livegs {

// From now on each line of the log is one JSON object, for who collects logs:
//   {"time":"2026-11-22T17:00:00.123Z","level":"info","message":"session 1a2b3c4d: …"}
// Before other threads log.
void log_as_json();

}  // namespace livegs
