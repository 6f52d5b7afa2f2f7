// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "compute/backend.h"
#include "device/elastic_cost.h"
#include "physics/elastic_device.h"

namespace livegs {

// Steps elastic bodies of the `cells` solver by the passes of passes/elastic_passes.h. The lattices of the
// bodies are uploaded when a body or its lattice changes, their state at the start of each tick. All steps of
// a tick are recorded and submitted together. The result has the same bits for every run on one backend.
class DeviceElastic final : public ElasticDevice {
 public:
  // Totals since the start.
  struct Counts {
    uint64_t ticks = 0;       // in which a body was stepped
    uint64_t body_ticks = 0;  // bodies stepped, summed over the ticks
    uint64_t node_steps = 0;
    uint64_t dispatches = 0;
    uint64_t lattice_uploads = 0;
  };

  // `backend` must outlive the object. With `cost`, a tick is stepped on the device only if its predicted
  // cost is lower.
  explicit DeviceElastic(Backend& backend, std::optional<ElasticCost> cost = {});
  ~DeviceElastic() override;

  // A failure of the backend is logged once; from then on every body has a reason.
  void step(std::span<DeviceBody> bodies, const FlatTick& tick) override;

  const Counts& counts() const;
  // The error that ended the use of the backend; empty: none.
  const std::string& failure() const;

 private:
  struct Fleet;
  std::unique_ptr<Fleet> fleet_;
};

}  // namespace livegs
