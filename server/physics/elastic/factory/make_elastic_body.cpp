// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/factory/make_elastic_body.h"

#include <cmath>

#include "core/text/format_text.h"
#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/livegs_v1/livegs_v1_body.h"

namespace livegs {

Result<std::unique_ptr<ElasticBody>> make_elastic_body(const ElasticBodyDescription& description,
                                                       ElasticSolver solver, double rate_hz, int substeps,
                                                       bool may_sleep) {
  if (auto checked = check_elastic_body(description); !checked) return checked.error();
  if (!(rate_hz > 0.0) || !std::isfinite(rate_hz)) {
    return invalid_argument(
        format_text("object %u: rate_hz is %g; it must be above 0", description.object_id, rate_hz));
  }
  if (substeps < 1 || substeps > 10000) {
    return invalid_argument(
        format_text("object %u: substeps is %d; it must be 1 to 10000", description.object_id, substeps));
  }
  if (solver != ElasticSolver::Cells) {
    const bool steady = solver == ElasticSolver::LivegsV1Steady;
    return std::unique_ptr<ElasticBody>(
        std::make_unique<LivegsV1Body>(description, rate_hz, substeps, may_sleep, steady));
  }
  return std::unique_ptr<ElasticBody>(
      std::make_unique<cells::CellsBody>(description, rate_hz, substeps, may_sleep));
}

}  // namespace livegs
