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
  // The first difference between the recorded and the repeated run.
  struct Difference {
    uint64_t tick = 0;  // 0: before the first tick
    uint32_t object_id = 0;
    std::string object, what;
  };
  uint64_t ticks = 0;   // ticks simulated
  uint64_t frames = 0;  // frames compared
  std::optional<Difference> difference;
};

// Builds the scene of a recording again, repeats its inputs and compares the drivers of every tick, bit by
// bit, and every frame. Stops at the first difference. `folder` contains the files of the scene; if empty,
// the embedded files are used, or the original paths if none are embedded. InvalidArgument if the recording
// does not contain all inputs since the scene was built; NotFound and other errors if the scene cannot be
// loaded.
Result<Verification> verify_recording(RecordingReader& recording, const std::filesystem::path& folder,
                                      const std::function<void(uint64_t tick)>& progress = {});

}  // namespace livegs
