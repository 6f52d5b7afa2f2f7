// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "gpu_report/pass_bytes.h"
#include "render/splat_renderer.h"

namespace livegs::gpu_report {

// Median and maximum over the timed frames.
struct Span {
  double median_ms = 0, max_ms = 0;
};

// Times of one number of kernels and eyes.
struct TimesRow {
  size_t kernels = 0;
  int eyes = 1, width = 0, height = 0;  // pixels per eye
  DrawMethod method = DrawMethod::Quads;
  int blend_bits = 16, frames = 0;  // whole pictures
  // By the host's clock, with an empty queue between the steps. skin: the pass alone; skin_rigid: the same
  // for the kernels of 1000 rigid bodies. upload: the drivers. project includes skinning; draw includes
  // resolve and the read-back.
  Span skin, skin_rigid, upload, project, sort, draw;
  // By the host's clock: whole pictures in one submission.
  Span frame;
  // By the device's clock, in whole pictures: medians. Zero if the device has no clock.
  DeviceTimes device;
  RenderTimes whole;                 // the counts of the last whole picture
  PassBytes bytes;                   // of a picture
  double memory_bytes_a_kernel = 0;  // with its share of cells and nodes, without pictures
};

struct TimesOptions {
  std::vector<size_t> kernels;
  int width = 0, height = 0;
};

// Draws a shell of kernels with three bands, bound to a twisted lattice and moved in each frame, while the
// camera orbits: for one eye and for two, by quads with 16-bit blending and by tiles. Calls `measured`
// after each row. A number of kernels that the device cannot hold is skipped, with a line on standard error.
// Progress goes to standard error.
Result<void> measure_times(const std::shared_ptr<VulkanDevice>& device, const TimesOptions& options,
                           const std::function<void(const TimesRow&)>& measured);

}  // namespace livegs::gpu_report
