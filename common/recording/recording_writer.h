// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "livegs/v1/session.pb.h"
#include "recording/driver_hash.h"
#include "recording/recording_file.h"
#include "recording/recording_totals.h"
#include "recording/tick_record.h"
#include "wire/frame_stream.h"

namespace livegs {

// One key tick of the index.
struct KeyTick {
  uint64_t tick = 0;
  int64_t simulated_ns = 0;
  uint64_t offset = 0;  // offset of its objects chunk
};

// Writes a recording (proto/recording_format.md), chunk by chunk. After the first failed write, every call
// returns the same error, and the file is valid up to that point. One thread.
class RecordingWriter {
 public:
  static Result<RecordingWriter> create(const std::filesystem::path& path, const v1::RecordingStart& start);

  // Adds an event that occurred at `tick`. Call before add_tick() of that tick.
  Result<void> add_event(uint64_t tick, const v1::SessionEvent& event);
  // Adds the bytes (proto/asset_format.md) of the asset with this hash, 64 hexadecimal digits.
  Result<void> add_asset(const std::string& hash, std::span<const std::byte> bytes);

  // Adds a file by its name in the scene, 1 to 4096 bytes long.
  Result<void> add_file(const std::string& name, std::span<const std::byte> bytes);

  struct Tick {
    uint64_t tick = 0;
    TickActions actions;
    std::optional<v1::SceneSource> scene;  // set if the scene was replaced
    const DriverFrame* drivers = nullptr;  // state after the tick; never null; has the same tick number
  };
  // Adds the result of encode_tick() for a tick before the start of the recording. Call before add_tick().
  Result<void> add_past(std::span<const std::byte> encoded);
  // Tick numbers must increase.
  Result<void> add_tick(Tick tick);
  // Writes the index. Nothing may be added afterwards.
  Result<void> finish();

  const v1::RecordingTotals& totals() const { return count_.totals(); }
  uint64_t bytes() const { return file_.size(); }
  const std::filesystem::path& path() const { return file_.path(); }

 private:
  RecordingWriter(RecordingFile file, const v1::RecordingStart& start);
  Result<void> append(uint8_t kind, std::span<const std::byte> payload);
  Result<void> add_objects(uint64_t tick);

  RecordingFile file_;
  std::optional<Error> failed_;
  const bool inputs_only_;
  const double rate_hz_;
  RecordingCount count_;
  std::map<uint32_t, uint64_t> described_at_;  // by object id, offset of the latest description
  std::vector<KeyTick> keys_;
  SamplesBefore samples_;
  DriverHashes hashes_;
  StreamBaselinePtr written_;
};

}  // namespace livegs
