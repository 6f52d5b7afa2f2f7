// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "livegs/v1/physics.pb.h"
#include "physics/elastic_body.h"

// How far an elastic body's numbers can be trusted, as it is told to people and to clients.

namespace livegs {

// Of the body's own material; a region that is out of reach is among the object's warnings.
v1::ElasticAccuracy accuracy_message(const ElasticAccuracy& accuracy);

// One line: "E 1e+05 Pa exact (0.98 to 1.02 of it); cells 50 mm, 4 substeps, Courant 0.56; 90 nodes, 26 kB";
// with regions "E 1e+05 Pa exact (0.96 to 1.04 of it); in foot E 1e+09 Pa clipped to 4e+06 Pa (0.0038 to
// 0.0042 of it); cells …".
std::string accuracy_line(const ElasticAccuracy& accuracy);

// What a person should be warned of, a line each: clipped stiffnesses, and once it has run, that it was lost
// on the way. Nothing when the numbers hold.
std::vector<std::string> accuracy_warnings(const ElasticAccuracy& accuracy);

}  // namespace livegs
