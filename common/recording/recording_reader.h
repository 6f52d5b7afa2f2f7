// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/result.h"
#include "livegs/v1/session.pb.h"
#include "recording/recording_file.h"
#include "recording/recording_totals.h"
#include "recording/recording_writer.h"
#include "recording/tick_record.h"

namespace livegs {

struct RecordedEvent {
  uint64_t tick = 0;
  v1::SessionEvent event;
};
using RecordedItem = std::variant<RecordedEvent, TickRecord>;

// A piece of a file from which the scene was built.
struct RecordedFilePiece {
  std::string name;  // name in the scene; must not be used as a path unchecked
  uint64_t offset = 0, total = 0;
  std::span<const std::byte> bytes;
};

// Reads a recording (proto/recording_format.md) from its start or from any key tick. Any bytes are accepted;
// invalid ones give an error. Memory is bounded by the largest chunk and the index. One thread.
class RecordingReader {
 public:
  // Opens a recording by its index. If it has none, because it is truncated or still being written, every
  // chunk is scanned.
  static Result<RecordingReader> open(const std::filesystem::path& path);

  const v1::RecordingStart& start() const { return start_; }
  const v1::RecordingTotals& totals() const { return totals_; }
  const std::vector<KeyTick>& keys() const { return keys_; }
  // False: the recording is truncated; the part before can be read.
  bool ended_in_order() const { return ended_in_order_; }
  uint64_t bytes() const { return file_.size(); }
  const std::filesystem::path& path() const { return file_.path(); }

  // The next event or tick, in order. Empty at the end, also of a truncated file. Damaged bytes give an
  // error; seek() still works.
  Result<std::optional<RecordedItem>> next();
  void rewind();
  // Seeks to the last key tick at or before this time, or to the first one. Returns the objects that exist
  // then; next() continues with that tick. NotFound if the recording has no key tick.
  Result<std::vector<v1::ObjectDescription>> seek(int64_t simulated_ns);
  // The complete bytes of an asset (proto/asset_format.md). NotFound if the recording has no asset with this
  // hash (64 hexadecimal digits). The caller verifies the hash.
  Result<std::vector<std::byte>> asset(const std::string& hash);
  // Calls `take` for each piece of the recorded files: one file after the other, each from start to end.
  // Stops at an error of `take`. A truncated file is left out if no piece of it was recorded.
  Result<void> files(const std::function<Result<void>(const RecordedFilePiece& piece)>& take) const;

 private:
  struct Chunk {
    uint8_t kind = 0;
    uint64_t offset = 0;
    std::vector<std::byte> payload;
  };
  explicit RecordingReader(RecordingFile file) : file_(std::move(file)) {}
  Error bad(const std::string& what) const;
  // Empty if the file ends within the chunk.
  Result<std::optional<Chunk>> read_chunk(uint64_t offset) const;
  Result<RecordedEvent> read_event(const Chunk& chunk) const;
  Result<void> read_start();
  Result<void> read_index();
  Result<void> look_through();
  Result<std::vector<uint64_t>> read_objects(const Chunk& chunk) const;

  RecordingFile file_;
  v1::RecordingStart start_;
  v1::RecordingTotals totals_;
  std::vector<KeyTick> keys_;
  bool ended_in_order_ = false;
  uint64_t first_ = 0, at_ = 0;  // chunk offsets
  SamplesBefore samples_;
};

}  // namespace livegs
