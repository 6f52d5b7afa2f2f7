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

// A piece of a file that the scene was built from.
struct RecordedFilePiece {
  std::string name;  // as the scene names it: never to be taken for a path as it is
  uint64_t offset = 0, total = 0;
  std::span<const std::byte> bytes;
};

// Reads a recording, proto/recording_format.md, from its beginning or from any key tick; any bytes, with an
// error for those that are none. Memory is bounded by the largest chunk and the index. One thread.
class RecordingReader {
 public:
  // By its index, or, where it has none because it was cut, or is being written, by a look at every chunk.
  static Result<RecordingReader> open(const std::filesystem::path& path);

  const v1::RecordingStart& start() const { return start_; }
  const v1::RecordingTotals& totals() const { return totals_; }
  const std::vector<KeyTick>& keys() const { return keys_; }
  // False: it breaks off; what it has up to there can be read.
  bool ended_in_order() const { return ended_in_order_; }
  uint64_t bytes() const { return file_.size(); }
  const std::filesystem::path& path() const { return file_.path(); }

  // The events and ticks in their order. Nothing at the end, also where the file breaks off; an error for
  // bytes that were changed, which leaves seek().
  Result<std::optional<RecordedItem>> next();
  void rewind();
  // To the last key tick that is not after the moment, or the first: the objects that are there then; next()
  // goes on with that tick. NotFound in a recording without one.
  Result<std::vector<v1::ObjectDescription>> seek(int64_t simulated_ns);
  // The bytes of an asset, whole, as proto/asset_format.md has them; NotFound when the recording has none of
  // this name (64 hexadecimal digits). Whether they are it is for the caller to check.
  Result<std::vector<std::byte>> asset(const std::string& hash);
  // Each piece of the files that it holds: one file after the other, each from its beginning to its end.
  // Stops at an error of `take`. A file that breaks off is left out if nothing of it came.
  Result<void> files(const std::function<Result<void>(const RecordedFilePiece& piece)>& take) const;

 private:
  struct Chunk {
    uint8_t kind = 0;
    uint64_t offset = 0;
    std::vector<std::byte> payload;
  };
  explicit RecordingReader(RecordingFile file) : file_(std::move(file)) {}
  Error bad(const std::string& what) const;
  // Nothing where the file ends before its end.
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
  uint64_t first_ = 0, at_ = 0;  // offsets of chunks
  SamplesBefore samples_;
};

}  // namespace livegs
