// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "livegs/v1/physics.pb.h"
#include "physics/elastic_body.h"

// Reports how accurate the stiffness of an elastic body is, for users and clients.

namespace livegs {

// Converts the accuracy of the body's own material. Clipped regions are reported as warnings.
v1::ElasticAccuracy accuracy_message(const ElasticAccuracy& accuracy);

// Formats one line: "E 1e+05 Pa exact (simulated at 0.98 to 1.02 times E); cells 50 mm, 4 substeps, Courant
// 0.56; 90 nodes, 26 kB". Regions follow the material: "E 1e+05 Pa exact (simulated at 0.96 to 1.04 times E);
// in foot E 1e+09 Pa clipped to 4e+06 Pa (simulated at 0.0038 to 0.0042 times E); cells …".
std::string accuracy_line(const ElasticAccuracy& accuracy);

// Returns one warning per problem: clipped stiffness, budget limits, and resets after divergence. Empty if
// the stiffness is accurate and the body never diverged.
std::vector<std::string> accuracy_warnings(const ElasticAccuracy& accuracy);

}  // namespace livegs
