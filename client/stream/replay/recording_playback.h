// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <filesystem>
#include <optional>
#include <string>

#include "core/result.h"
#include "recording/recording_reader.h"
#include "stream/received/known_objects.h"
#include "stream/received/stream_item.h"
#include "wire/frame_stream.h"

namespace livegs {

// Plays a recording (proto/recording_format.md) as a stream, from any time on. Objects come before the frames
// that move them. One thread.
class RecordingPlayback final : public ItemSource {
 public:
  // InvalidArgument for a recording without frames.
  static Result<RecordingPlayback> open(const std::filesystem::path& path);

  const v1::RecordingStart& start() const { return recording_.start(); }
  double length_s() const;  // from the first frame to the last

  // Moves to `seconds` after the first frame. The next items are the objects added, changed and removed since
  // the last item taken, followed by the last frame that is not later. Beyond the end: the last frame.
  Result<void> seek(double seconds);
  // Frames decoded by the last seek().
  size_t decoded() const { return decoded_; }

  // Nothing at the end, or on a read error; error() then returns it.
  std::optional<StreamItem> take() override;
  const std::optional<Error>& error() const { return error_; }

 private:
  explicit RecordingPlayback(RecordingReader recording) : recording_(std::move(recording)) {}
  // Applies an event of the recording to `described`.
  static void follow(const v1::SessionEvent& event, std::map<uint32_t, v1::ObjectDescription>& described);
  Result<StreamItem> item(const v1::SessionEvent& event);
  Result<ReceivedFrame> frame(const TickRecord& record);
  Result<void> take_difference(const std::map<uint32_t, v1::ObjectDescription>& described);
  Result<std::optional<StreamItem>> next();

  RecordingReader recording_;
  StreamReader frames_;
  KnownObjects known_;
  std::deque<StreamItem> waiting_;
  std::optional<Error> error_;
  size_t decoded_ = 0;
};

}  // namespace livegs
