// SPDX-License-Identifier: Apache-2.0
#include "bench/support/made_up_endpoint.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <regex>
#include <utility>

#include "test_http_server.h"

namespace livegs {
namespace {

using nlohmann::json;

// An answer of half a gram per cubic centimetre of the volume in a request (worded as in facts.json).
std::string answer_to(const std::string& request) {
  static const std::regex line(R"(Surface: volume ([0-9.e+-]+) cm3)");
  std::smatch volume;
  if (!std::regex_search(request, volume, line)) return "";
  const double best = 0.5 * std::strtod(volume[1].str().c_str(), nullptr);
  return json{
      {"description", "made up"},
      {"evidence", "made up"},
      {"name", "object"},
      {"name_confidence", 0.9},
      {"is_replica", false},
      {"fill", "assembly"},
      {"parts",
       {{{"name", "all"}, {"material_id", "polypropylene"}, {"share", 1}, {"thickness_mm", nullptr}}}},
      {"behaviour", "rigid"},
      {"size_m", nullptr},
      {"mass_g", {{"low", best / 4}, {"high", best * 4}, {"best", best}}},
      {"alternatives", nullptr},
      {"young_mpa", nullptr},
      {"structure_s", nullptr},
      {"plasticity_level", nullptr},
      {"plasticity", nullptr},
      {"fragile", false},
      {"friction", 0.4},
      {"restitution", 0.3},
      {"confidence", 0.9},
      {"kb_ids", json::array()}}
      .dump();
}

}  // namespace

int serve_made_up_answers(std::chrono::milliseconds delay) {
  Reply models;
  models.body = json{{"object", "list"}, {"data", {{{"id", "made-up-1"}, {"object", "model"}}}}}.dump();
  TestHttpServer server(
      [delay](const SeenRequest& request, int) {
        const std::string answer = answer_to(request.body);
        Reply reply;
        reply.delay_ms = static_cast<int>(delay.count());
        reply.status = answer.empty() ? 400 : 200;
        reply.body = answer.empty()
                         ? R"({"error": {"message": "the sentence of the volume has an unexpected form"}})"
                         : json{{"id", "1"},
                                {"model", "made-up-1"},
                                {"choices",
                                 {{{"index", 0},
                                   {"finish_reason", "stop"},
                                   {"message", {{"role", "assistant"}, {"content", answer}}}}}},
                                {"usage", {{"prompt_tokens", 1500}, {"completion_tokens", 200}}}}
                               .dump();
        return reply;
      },
      models);
  std::printf("%s\n", server.base_url().c_str());
  std::fflush(stdout);
  while (std::getchar() != EOF) {
  }
  return 0;
}

Result<MadeUpEndpoint> MadeUpEndpoint::start() {
  int life[2], address[2];
  if (::pipe2(life, O_CLOEXEC) != 0 || ::pipe2(address, O_CLOEXEC) != 0)
    return Error{ErrorCode::Internal, "endpoint: pipe failed"};
  MadeUpEndpoint endpoint;
  endpoint.process_ = ::fork();
  if (endpoint.process_ == 0) {
    ::dup2(life[0], STDIN_FILENO);
    ::dup2(address[1], STDOUT_FILENO);
    ::execl("/proc/self/exe", "analyze_bench", kServe, nullptr);
    ::_exit(127);
  }
  ::close(life[0]);
  ::close(address[1]);
  endpoint.end_of_life_ = life[1];
  char c = 0;
  while (::read(address[0], &c, 1) == 1 && c != '\n') endpoint.base_url_ += c;
  ::close(address[0]);
  if (endpoint.process_ < 0 || c != '\n') return Error{ErrorCode::Internal, "endpoint: did not start"};
  return endpoint;
}

MadeUpEndpoint::MadeUpEndpoint(MadeUpEndpoint&& other) noexcept
    : process_(std::exchange(other.process_, -1)),
      end_of_life_(std::exchange(other.end_of_life_, -1)),
      base_url_(std::move(other.base_url_)) {}

MadeUpEndpoint::~MadeUpEndpoint() {
  if (end_of_life_ >= 0) ::close(end_of_life_);
  if (process_ > 0) ::waitpid(process_, nullptr, 0);
}

}  // namespace livegs
