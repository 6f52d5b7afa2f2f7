// SPDX-License-Identifier: Apache-2.0
#include "server/analysis/model/chat/model_endpoint_cases.h"

#include "server/analysis/model/chat/endpoint_case_groups.h"

namespace livegs {

EndpointSettings test_settings(const std::string& base_url) {
  EndpointSettings settings;
  settings.base_url = base_url;
  settings.model = "test-model";
  settings.api_key = Secret(kTestKey);
  settings.deadline_s = 20;
  settings.connect_timeout_s = 2;
  settings.probe_timeout_s = 2;
  settings.backoff_s = 0.002;
  settings.max_backoff_s = 0.01;
  settings.jitter_seed = 7;
  settings.requests_per_s = 1000;
  settings.request_burst = 1000;
  settings.breaker_failures = 100;
  settings.max_answer_tokens = 2000;
  return settings;
}

const std::vector<EndpointCase>& endpoint_cases() {
  static const std::vector<EndpointCase> all = [] {
    std::vector<EndpointCase> cases;
    for (auto group : {dialect_cases, tool_cases, refusal_cases, busy_cases, content_cases, stream_cases}) {
      for (EndpointCase& one : group()) cases.push_back(std::move(one));
    }
    return cases;
  }();
  return all;
}

}  // namespace livegs
