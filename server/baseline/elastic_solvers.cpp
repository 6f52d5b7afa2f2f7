// SPDX-License-Identifier: GPL-3.0-or-later
#include "baseline/elastic_solvers.h"

#include "baseline/livegs_v1_body.h"

namespace livegs {
namespace {

Result<std::unique_ptr<ElasticBody>> make_body(const ElasticBodyDescription& description, double rate_hz,
                                               int substeps, bool may_sleep, bool steady) {
  if (auto checked = check_elastic_body(description, rate_hz, substeps); !checked) return checked.error();
  return std::unique_ptr<ElasticBody>(
      std::make_unique<LivegsV1Body>(description, rate_hz, substeps, may_sleep, steady));
}

}  // namespace

Result<std::unique_ptr<ElasticBody>> make_livegs_v1_body(const ElasticBodyDescription& description,
                                                         double rate_hz, int substeps, bool may_sleep) {
  return make_body(description, rate_hz, substeps, may_sleep, false);
}

Result<std::unique_ptr<ElasticBody>> make_livegs_v1_steady_body(const ElasticBodyDescription& description,
                                                                double rate_hz, int substeps,
                                                                bool may_sleep) {
  return make_body(description, rate_hz, substeps, may_sleep, true);
}

const std::map<std::string, ElasticBodyFactory>& elastic_solvers() {
  static const std::map<std::string, ElasticBodyFactory> solvers{
      {"cells", make_elastic_body},
      {"livegs-v1", make_livegs_v1_body},
      {"livegs-v1-steady", make_livegs_v1_steady_body}};
  return solvers;
}

}  // namespace livegs
