// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "session/publish/frame_publisher.h"
#include "session/simulation/simulation_loop.h"

namespace livegs {

// What a run of the server came to, for a person: a block an object (kernels, elastic or rigid, how far its
// numbers hold, mass, stiffness, where each value came from), then the ticks and the frames. Balls are
// counted, not listed.
std::string run_summary(const Scene& scene, const SimulationSummary& simulated,
                        const PublisherSummary& published, const SessionTable::Totals& sessions);

}  // namespace livegs
