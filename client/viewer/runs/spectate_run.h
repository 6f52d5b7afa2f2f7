// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <optional>

#include "stream/session/spectator.h"
#include "viewer/runs/offscreen_run.h"

namespace livegs {

struct SpectateSummary {
  std::string published, renderer;
  std::string notice;  // as OffscreenRunSummary has it
  size_t objects = 0;
  Spectator::Totals spectated;
  AssetLibrary::Totals assets;
  ReceivedLog::Summary received;
  DrawnLog::Summary drawn;
  uint64_t dropped_frames = 0;
  std::optional<Error> stream_error;  // that nothing came any more; the outputs are complete up to there
};

// Watches the frames that a server publishes, tcp://127.0.0.1:PORT, and draws them into options.output as
// run_offscreen() does; scripts and pokes are nothing to it. Fails when nothing comes within
// options.connect_timeout_s, or options.seconds if that is less; ends when nothing came for
// options.reconnect_s, a second and three frames at least.
Result<SpectateSummary> run_spectator(const std::string& published, const OffscreenRunOptions& options,
                                      const std::atomic<bool>& interrupted);
std::string summary_text(const SpectateSummary& summary);

}  // namespace livegs
