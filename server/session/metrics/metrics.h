// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/result.h"
#include "session/publish/frame_publisher.h"
#include "session/simulation/simulation_loop.h"

namespace livegs {

// What a server counts, for Prometheus to fetch: GET http://127.0.0.1:PORT/metrics. Everything is gathered
// when it is asked for, from what is counted anyway, on a thread of its own. A client's label is the first
// eight digits of its session's id, and goes with the session. Nothing of it is secret, but it is for this
// machine only.
class Metrics {
 public:
  struct Sources {
    const SessionTable& sessions;
    std::function<SimulationSummary()> simulation;
    std::function<PublisherSummary()> publisher;
  };
  // Port 0 lets the system choose. Unavailable when the port is in use. The sources outlive it.
  static Result<std::unique_ptr<Metrics>> serve(int port, Sources sources);
  ~Metrics();
  int port() const;

 private:
  struct Parts;
  explicit Metrics(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace livegs
