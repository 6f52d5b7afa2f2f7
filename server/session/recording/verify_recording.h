// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "core/result.h"
#include "recording/recording_reader.h"

namespace livegs {

struct Verification {
  // Where the run that is simulated again first is not the one that was recorded.
  struct Difference {
    uint64_t tick = 0;  // 0: before the first
    uint32_t object_id = 0;
    std::string object, what;
  };
  uint64_t ticks = 0;   // simulated again
  uint64_t frames = 0;  // compared
  std::optional<Difference> difference;
};

// Builds the scene of a recording anew, with the files in `folder` (empty: those that it holds, or, where it
// holds none, where they were), does again what was done, and compares the drivers of every tick to the last
// bit, and every frame. Stops at the first difference. InvalidArgument when the recording has not all that
// was done since its scene was built, NotFound and others when that cannot be loaded.
Result<Verification> verify_recording(RecordingReader& recording, const std::filesystem::path& folder,
                                      const std::function<void(uint64_t tick)>& progress = {});

}  // namespace livegs
