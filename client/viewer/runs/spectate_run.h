// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <optional>

#include "stream/session/spectator.h"
#include "viewer/runs/offscreen_run.h"

namespace livegs {

struct SpectateSummary {
  std::string published, renderer;
  std::string notice;  // as in OffscreenRunSummary
  size_t objects = 0;
  Spectator::Totals spectated;
  AssetLibrary::Totals assets;
  ReceivedLog::Summary received;
  DrawnLog::Summary drawn;
  uint64_t dropped_frames = 0;
  std::optional<Error> stream_error;  // the publications stopped; the outputs are complete up to there
};

// Draws the frames published at tcp://127.0.0.1:PORT into options.output as run_offscreen() does; scripts and
// pokes are ignored. Fails if no frame arrives within options.connect_timeout_s, or options.seconds if that
// is less. Ends after options.reconnect_s without a frame, at least a second and three frame intervals.
Result<SpectateSummary> run_spectator(const std::string& published, const OffscreenRunOptions& options,
                                      const std::atomic<bool>& interrupted);
std::string summary_text(const SpectateSummary& summary);

}  // namespace livegs
