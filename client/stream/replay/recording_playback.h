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

// A recording (proto/recording_format.md) as what a stream would bring: from any moment on, objects before
// the frames they move in. One thread.
class RecordingPlayback final : public ItemSource {
 public:
  // InvalidArgument for one without frames.
  static Result<RecordingPlayback> open(const std::filesystem::path& path);

  const v1::RecordingStart& start() const { return recording_.start(); }
  double length_s() const;  // between its first frame and its last

  // What comes next is what it takes to be at this moment after the first frame: objects that came, changed
  // and went since the last item taken, and then the last frame that is not after it. Beyond the end: the
  // last frame.
  Result<void> seek(double seconds);
  // Frames decoded by the last seek().
  size_t decoded() const { return decoded_; }

  // Nothing at the end, and where the recording cannot be read further: then error() says why.
  std::optional<StreamItem> take() override;
  const std::optional<Error>& error() const { return error_; }

 private:
  explicit RecordingPlayback(RecordingReader recording) : recording_(std::move(recording)) {}
  // What the recording says of its objects, to `described`.
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
