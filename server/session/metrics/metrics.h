// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/result.h"
#include "session/publish/frame_publisher.h"
#include "session/simulation/simulation_loop.h"
#include "trust/host_port.h"

namespace livegs {

// Reads "PORT", a port of 127.0.0.1, or "HOST:PORT". InvalidArgument for another text.
Result<HostPort> parse_metrics_address(const std::string& text);

// Counters of a server for Prometheus: GET http://HOST:PORT/metrics. Values are collected on request, on
// a separate thread, from counters that exist anyway. A client's label is the first eight digits of its
// session id and exists as long as the session. The values are not secret. They are sent in clear text to any
// caller, so another host than 127.0.0.1 is for a network that admits only the monitoring, as that of a pod.
class Metrics {
 public:
  struct Sources {
    const SessionTable& sessions;
    std::function<SimulationSummary()> simulation;
    std::function<PublisherSummary()> publisher;
    std::function<uint64_t()> asset_bytes;  // sent to clients
  };
  // Port 0 lets the system choose. Unavailable if the port is in use. The sources must outlive the object.
  static Result<std::unique_ptr<Metrics>> serve(const HostPort& where, Sources sources);
  ~Metrics();
  std::string url() const;  // with the port that the system chose

 private:
  struct Parts;
  explicit Metrics(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace livegs
