// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "livegs/v1/physics.pb.h"
#include "physics/elastic_body.h"

// How far an elastic body's numbers can be trusted, as it is told to people and to clients.

namespace livegs {

v1::ElasticAccuracy accuracy_message(const ElasticAccuracy& accuracy);

// One line: "E 1e+05 Pa exact (0.98 to 1.02 of it); cells 50 mm, 4 substeps, Courant 0.56; 90 nodes, 26 kB".
std::string accuracy_line(const ElasticAccuracy& accuracy);

// What a person should be warned of before anything runs: a clipped stiffness. Nothing when the numbers hold.
std::optional<std::string> accuracy_warning(const ElasticAccuracy& accuracy);

}  // namespace livegs
