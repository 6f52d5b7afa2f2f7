// SPDX-License-Identifier: Apache-2.0
#include "viewer/runs/run_panel.h"

#include <algorithm>

#include "core/text/format_text.h"

namespace livegs {
namespace {

constexpr const char* kHelp =
    "left: pull   right: rotate   middle: pan\nwheel: zoom   WASDQE: fly   space: shoot\n"
    "P: pause   full stop: step   H: hide panels\n1 to 5: pull, move, turn, scale, measure   F: frame";

}  // namespace

RunPanel run_panel(const RunPanelSource& source) {
  RunPanel run;
  const ReceivedFrame* frame = source.newest;
  const bool rests = source.picture.rests();
  run.paused = frame && frame->run.paused();
  run.loading = frame && frame->run.loading();
  run.waiting = frame && frame->run.waiting();
  run.notice = source.notice.empty() ? source.view.notice() : source.notice;
  run.lines.push_back(source.view.renderer_name());
  run.lines.push_back(source.picture.text());
  // The same number of lines at rest, so that nothing moves under the mouse.
  run.lines.push_back(rests ? "no new pictures"
                            : format_text("%.0f fps, %.0f server ticks/s", source.meter.pictures_a_second(),
                                          source.meter.ticks_a_second()));
  if (frame) {
    run.lines.push_back(format_text("tick %llu, %.1f s simulated%s",
                                    static_cast<unsigned long long>(frame->tick), frame->run.simulated_s(),
                                    run.paused ? ", paused"
                                    : rests    ? " at rest"
                                               : ""));
  }
  if (const auto& coming = source.coming; coming.objects > 0) {
    // On the renderer's line, so that the panel keeps its height.
    run.lines.front() += format_text(", loading %zu objects: %.0f %%", coming.objects,
                                     100.0 * static_cast<double>(coming.kernels_shown) /
                                         static_cast<double>(std::max<uint64_t>(coming.kernels_total, 1)));
  }
  run.graph = source.meter.graph();
  const auto& times = source.view.last_times();
  if (const auto latency_ms = source.meter.hand_to_picture_ms()) {
    run.latency = format_text("input latency %.0f ms\nskin %.1f ms, render %.1f ms", *latency_ms,
                              times.skin_ms, times.raster_ms);
  }
  if (const auto& device = times.device) {
    run.latency += format_text("%sdevice: skin %.1f, project %.1f, sort %.1f, draw %.1f, resolve %.1f ms",
                               run.latency.empty() ? "" : "\n", device->skin_ms, device->project_ms,
                               device->sort_ms, device->draw_ms, device->resolve_ms);
  }
  run.help = kHelp;
  return run;
}

void RestingCounters::hold(RunPanel& run, bool rests) {
  if (rested_ && rests && last_.paused == run.paused) {
    run.lines = last_.lines;
    run.latency = last_.latency;
  }
  rested_ = rests;
  last_ = run;
}

}  // namespace livegs
