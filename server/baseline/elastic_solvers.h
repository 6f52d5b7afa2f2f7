// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>

#include "physics/elastic_body.h"

namespace livegs {

// As published: the same blend factor at any substep.
Result<std::unique_ptr<ElasticBody>> make_livegs_v1_body(const ElasticBodyDescription& description,
                                                         double rate_hz, int substeps, bool may_sleep);
// Blend factor converted to a stiffness at the paper's step of 1/240 s.
Result<std::unique_ptr<ElasticBody>> make_livegs_v1_steady_body(const ElasticBodyDescription& description,
                                                                double rate_hz, int substeps, bool may_sleep);

// The solvers by their names in `livegs simulate` and in recordings, the product's included.
const std::map<std::string, ElasticBodyFactory>& elastic_solvers();

}  // namespace livegs
