// SPDX-License-Identifier: Apache-2.0
#include "xr/offscreen_display.h"

#include <cmath>
#include <cstdio>

#include "core/assert.h"
#include "core/log.h"
#include "core/written_files.h"

namespace livegs {

Result<std::unique_ptr<OffscreenDisplay>> OffscreenDisplay::open(const OffscreenOptions& options) {
  std::error_code error;
  std::filesystem::create_directories(options.folder, error);
  if (error)
    return invalid_argument(options.folder.string() + ": the folder cannot be created: " + error.message() +
                            "; choose another folder with --output");
  std::unique_ptr<OffscreenDisplay> display(new OffscreenDisplay(options));
  if (options.video) {
    auto video =
        VideoFile::create(options.folder / "out.mp4", options.width, options.height, options.rate_hz);
    if (video) {
      display->video_.emplace(std::move(*video));
    } else {
      log_warn("%s (every picture is saved as PNG)", video.error().message.c_str());
      display->options_.png_every = 1;
    }
  }
  return display;
}

bool OffscreenDisplay::is_saved(uint64_t index) const {
  return options_.png_every > 0 && index % static_cast<uint64_t>(options_.png_every) == 0;
}

std::optional<PlannedFrame> OffscreenDisplay::wait_frame() {
  PlannedFrame frame;
  frame.index = planned_++;
  frame.display_time_ns =
      static_cast<int64_t>(std::llround(static_cast<double>(frame.index) * 1e9 / options_.rate_hz));
  frame.views = {camera_};
  frame.kept = video_ || is_saved(frame.index);
  return frame;
}

Result<void> OffscreenDisplay::submit(const PlannedFrame& frame, std::span<const Image> images) {
  LIVEGS_ASSERT(images.size() == 1);
  ++pictures_;
  if (is_saved(frame.index)) {
    char name[32];
    std::snprintf(name, sizeof name, "frame_%05llu.png", static_cast<unsigned long long>(frame.index));
    if (auto written = write_png(options_.folder / name, images[0]); !written) return written;
    note_written(options_.folder / name);
  }
  return video_ ? video_->add(images[0]) : Result<void>();
}

Result<void> OffscreenDisplay::finish() { return video_ ? video_->finish() : Result<void>(); }

}  // namespace livegs
