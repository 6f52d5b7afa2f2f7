// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "physics/elastic_body.h"

namespace livegs {

// `rate_hz` and `substeps` are the scene's. A body may take more substeps, never fewer. Fails as
// check_elastic_body, and if `rate_hz` or `substeps` is out of range.
Result<std::unique_ptr<ElasticBody>> make_elastic_body(const ElasticBodyDescription& description,
                                                       ElasticSolver solver, double rate_hz, int substeps,
                                                       bool may_sleep);

}  // namespace livegs
