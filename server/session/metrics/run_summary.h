// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "session/publish/frame_publisher.h"
#include "session/simulation/simulation_loop.h"

namespace livegs {

// Human-readable summary of a server run. One block per object (kernels, elastic or rigid, accuracy, mass,
// stiffness, source of each value), then ticks and frames. Balls are counted, not listed.
std::string run_summary(const Scene& scene, const SimulationSummary& simulated,
                        const PublisherSummary& published, const SessionTable::Totals& sessions);

}  // namespace livegs
