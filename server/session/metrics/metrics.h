// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/result.h"
#include "session/publish/frame_publisher.h"
#include "session/simulation/simulation_loop.h"

namespace livegs {

// Counters of a server for Prometheus: GET http://127.0.0.1:PORT/metrics. Values are collected on request, on
// a separate thread, from counters that exist anyway. A client's label is the first eight digits of its
// session id and exists as long as the session. The values are not secret, but the port is local only.
class Metrics {
 public:
  struct Sources {
    const SessionTable& sessions;
    std::function<SimulationSummary()> simulation;
    std::function<PublisherSummary()> publisher;
    std::function<uint64_t()> asset_bytes;  // sent to clients
  };
  // Port 0 lets the system choose. Unavailable if the port is in use. The sources must outlive the object.
  static Result<std::unique_ptr<Metrics>> serve(int port, Sources sources);
  ~Metrics();
  int port() const;

 private:
  struct Parts;
  explicit Metrics(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace livegs
