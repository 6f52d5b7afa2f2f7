// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>

#include "physics/elastic/flat_body.h"

// The seam between a World and a device that steps elastic bodies (server/device). Physics itself needs no
// device: without one every body is stepped on the CPU.

namespace livegs {

// A body that may be stepped elsewhere in this tick.
struct DeviceBody {
  FlatBody* body = nullptr;
  std::span<const PointForce> forces;  // constant over the tick
  const char* reason = nullptr;        // output: null if the body was stepped, otherwise why not
};

class ElasticDevice {
 public:
  virtual ~ElasticDevice() = default;
  // Takes all steps of a tick of the bodies that it can take. The others are unchanged, and so are all of
  // them if the device fails. `tick.forces` is not used. Any thread; one call at a time runs.
  virtual void step(std::span<DeviceBody> bodies, const FlatTick& tick) = 0;
};

// The device of all Worlds of the process; null: none. Set before work starts (as set_thread_count).
void set_elastic_device(std::shared_ptr<ElasticDevice> device);
ElasticDevice* elastic_device();

}  // namespace livegs
