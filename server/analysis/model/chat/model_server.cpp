// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/chat/model_server.h"

#include <algorithm>

#include "analysis/model/chat/endpoint_quirks.h"
#include "analysis/model/chat/sse_parser.h"
#include "core/clock.h"
#include "core/log.h"

// Retries follow the servers' documentation. 408, 409, 429, 500, 502, 503, 504 and 529 (Anthropic's
// "overloaded", forwarded by gateways) are transient; other refusals are not retried.

namespace livegs {
namespace {

// Maximum interval between polls of a server that is loading its model.
constexpr double kMaxLoadingPollInterval_s = 2.0;
constexpr int kProbeBytes = 256 << 10;

bool passes_by_itself(int status) {
  for (const int known : {408, 409, 425, 429, 500, 502, 503, 504, 529}) {
    if (status == known) return true;
  }
  return false;
}

// A 429 that waiting does not resolve.
bool is_quota(const ServerError& error) {
  for (const std::string* text : {&error.code, &error.type}) {
    if (*text == "insufficient_quota" || *text == "credit_balance_exhausted" ||
        *text == "billing_hard_limit_reached" || text->ends_with("spend_limit_exceeded") ||
        text->ends_with("usage_limit_exceeded")) {
      return true;
    }
  }
  return false;
}

// Status of an error inside a 200; 500 if unspecified.
int status_of(const ServerError& error) {
  if (error.code.size() == 3 && error.code.find_first_not_of("0123456789") == std::string::npos) {
    return std::max(400, std::stoi(error.code));
  }
  if (error.type == "invalid_request_error" || error.type == "BadRequestError") return 400;
  if (error.type == "authentication_error" || error.code == "invalid_api_key") return 401;
  if (error.type == "rate_limit_error" || error.code == "rate_limit_exceeded" || is_quota(error)) return 429;
  return 500;
}

Error of_status(int status, const std::string& said, const EndpointSettings& settings) {
  const std::string colon = said.empty() ? "" : ": " + said;
  switch (status) {
    case 401:
    case 403:
      return {ErrorCode::PermissionDenied,
              "OPENAI_API_KEY: refused by the server" + colon + "; check the key"};
    case 404:
      return not_found(settings.base_url + ": no such address or model" + colon +
                       "; check OPENAI_BASE_URL (it usually ends in /v1) and LIVEGS_MODEL");
    case 413:
      return {ErrorCode::TooLarge,
              "request: too large for the server" + colon + "; use smaller or fewer views"};
    case 429:
      return {ErrorCode::Unavailable,
              settings.base_url + ": limits the request rate" + colon + "; try again later"};
    default:
      if (status >= 300 && status < 400) {
        return {ErrorCode::Unavailable,
                settings.base_url +
                    ": answered with a redirect, which is not followed; set OPENAI_BASE_URL to its target"};
      }
      return {status >= 500 ? ErrorCode::Unavailable : ErrorCode::InvalidArgument,
              settings.base_url + ": answered with status " + std::to_string(status) + colon};
  }
}

Error of_transport(const HttpReply& http, const EndpointSettings& settings) {
  const std::string what = settings.base_url + ": " + http.message;
  switch (http.end) {
    case HttpReply::End::NotConnected:
      return {ErrorCode::Unavailable, what + "; start the server, or correct OPENAI_BASE_URL"};
    case HttpReply::End::TooLarge:
      return {ErrorCode::TooLarge, what};
    case HttpReply::End::Deadline:
      return {ErrorCode::Unavailable, what + "; increase LIVEGS_MODEL_DEADLINE_S"};
    case HttpReply::End::BadTls:
      return {
          ErrorCode::PermissionDenied,
          what + " (its certificate is not trusted by this machine); install the certificate of its issuer"};
    case HttpReply::End::BadUrl:
      return invalid_argument(what + "; check OPENAI_BASE_URL");
    default:
      return {ErrorCode::Unavailable, what};
  }
}

}  // namespace

ModelServer::ModelServer(const EndpointSettings& settings)
    : settings_(settings),
      bucket_(std::max(settings.requests_per_s, 1e-3), std::max(settings.request_burst, 1.0)),
      breaker_(std::max(settings.breaker_failures, 1), settings.breaker_s),
      random_(settings.jitter_seed ? settings.jitter_seed : static_cast<std::uint64_t>(now_ns())) {}

ModelServer::Slot::~Slot() {
  if (!server_) return;
  std::lock_guard lock(server_->mutex_);
  --server_->in_flight_;
  server_->changed_.notify_all();
}

ModelServer::Slot ModelServer::take_slot(int max_in_flight, std::stop_token stop) {
  std::unique_lock lock(mutex_);
  if (!changed_.wait(lock, stop, [&] { return in_flight_ < max_in_flight; })) return Slot(nullptr);
  ++in_flight_;
  return Slot(this);
}

int ModelServer::in_flight() const {
  std::lock_guard lock(mutex_);
  return in_flight_;
}

bool ModelServer::breaker_open(std::string& reason) const {
  std::lock_guard lock(mutex_);
  reason = breaker_.reason();
  return breaker_.is_open();
}

bool ModelServer::wait(double seconds, std::stop_token stop) const {
  std::unique_lock lock(mutex_);
  const std::int64_t end_ns = now_ns() + static_cast<std::int64_t>(seconds * 1e9);
  while (!stop.stop_requested()) {
    const std::int64_t left_ns = end_ns - now_ns();
    if (left_ns <= 0) return true;
    changed_.wait_for(lock, stop, std::chrono::nanoseconds(left_ns), [] { return false; });
  }
  return false;
}

double ModelServer::unit_random() {
  std::lock_guard lock(mutex_);
  return static_cast<double>(random_() >> 11) * 0x1p-53;
}

std::string ModelServer::probe(std::stop_token stop, int& status) {
  HttpRequest request;
  request.url = settings_.base_url + "/models";
  request.bearer = &settings_.api_key;
  request.connect_timeout_s = request.total_timeout_s = settings_.probe_timeout_s;
  request.max_bytes = kProbeBytes;
  const HttpReply reply = client_.send(request, stop);
  status = reply.status;
  return reply.end == HttpReply::End::Complete && reply.status == 200 ? reply.body : "";
}

// Outcome of one reply.
struct ModelServer::Verdict {
  enum class Server { Up, Down, Shut };
  ServerAnswer answer;
  ServerError refusal;
  bool refused = false;     // fault of the request, or possibly so
  bool named_only = false;  // if `refused`: the message must name the part
  bool repeat = false;      // the same request may succeed later
  bool loading = false;     // the server is loading its model
  Server server = Server::Up;
  double retry_after_s = 0;

  Verdict& fail(Error error) {
    answer.kind = ServerAnswer::Kind::Failed;
    answer.error = std::move(error);
    return *this;
  }
};

ModelServer::Verdict ModelServer::judge(const HttpReply& http) const {
  Verdict verdict;
  verdict.retry_after_s = http.retry_after_s.value_or(0);
  if (http.end == HttpReply::End::Cancelled) {
    verdict.fail({ErrorCode::Unavailable, "cancelled"}).answer.kind = ServerAnswer::Kind::Cancelled;
    return verdict;
  }
  if (http.end != HttpReply::End::Complete) {
    verdict.repeat = http.end == HttpReply::End::NotConnected || http.end == HttpReply::End::Late ||
                     http.end == HttpReply::End::Stalled || http.end == HttpReply::End::Cut;
    verdict.server = http.end == HttpReply::End::TooLarge ? Verdict::Server::Up : Verdict::Server::Down;
    return verdict.fail(of_transport(http, settings_));
  }
  Result<ChatReply> decoded =
      decode_chat_reply(http.body, http.content_type.starts_with("text/event-stream"));
  int status = http.status;
  if (decoded && decoded->error) verdict.refusal = *decoded->error;
  if (!decoded && status != 200) verdict.refusal.message = brief(http.body, 120);
  ServerError& said = verdict.refusal;
  said.message = settings_.api_key.redact(said.message);
  if (status == 200 && !decoded) {
    return verdict.fail(
        invalid_data(settings_.base_url + ": answered with " +
                     (http.content_type.empty() ? "something" : brief(http.content_type, 60)) + " that is " +
                     decoded.error().message + "; check OPENAI_BASE_URL"));
  }
  if (status == 200 && !decoded->error) {
    verdict.repeat = true;
    if (!decoded->has_choice)
      return verdict.fail(invalid_data(settings_.base_url + ": sent an answer without choices"));
    const bool silent = decoded->content.empty() && decoded->refusal.empty() && decoded->tool_calls.empty();
    if (silent && decoded->finish_reason != "length" && decoded->finish_reason != "content_filter") {
      return verdict.fail(
          invalid_data(settings_.base_url + ": sent an empty answer; set another LIVEGS_MODEL"));
    }
    verdict.repeat = false;
    verdict.answer.kind = ServerAnswer::Kind::Answered;
    verdict.answer.reply = std::move(*decoded);
    return verdict;
  }
  if (status == 200) status = status_of(said);
  if (status == 429 && is_quota(said)) {
    verdict.server = Verdict::Server::Shut;
    return verdict.fail({ErrorCode::Unavailable, "account: has no more credit: " + brief(said.message) +
                                                     "; add credit, or use --offline"});
  }
  verdict.fail(of_status(status, brief(said.message, 300), settings_));
  if (status == 401 || status == 403) {
    verdict.server = Verdict::Server::Shut;
  } else if (is_context_overflow(said)) {
    verdict.fail({ErrorCode::TooLarge, "prompt: longer than the model's context: " + brief(said.message) +
                                           "; start the server with a longer one"});
  } else {
    verdict.repeat = passes_by_itself(status);
    verdict.refused = status == 400 || status == 500 || status == 501;
    verdict.named_only = status != 400;
    verdict.loading = status == 503 && (said.type == "unavailable_error" ||
                                        said.message.find("oading model") != std::string::npos);
    if (verdict.repeat && !verdict.loading) verdict.server = Verdict::Server::Down;
  }
  return verdict;
}

HttpReply ModelServer::send_chat(const std::string& body, bool event_stream, std::int64_t deadline_ns,
                                 std::stop_token stop) {
  const double left_s = std::max(seconds_from_ns(deadline_ns - now_ns()), 1e-3);
  HttpRequest request;
  request.url = settings_.base_url + "/chat/completions";
  request.body = body;
  request.event_stream = event_stream;
  request.bearer = &settings_.api_key;
  request.connect_timeout_s = std::min(settings_.connect_timeout_s, left_s);
  request.total_timeout_s = left_s;
  // Events are inspected on arrival only to detect the end and report progress.
  SseParser events;
  ChatStream stream;
  std::size_t received = 0;
  if (event_stream) {
    request.first_byte_timeout_s = settings_.first_byte_timeout_s;
    request.stall_timeout_s = settings_.stall_timeout_s;
    request.on_body = [&](std::string_view bytes) {
      received += bytes.size();
      if (settings_.progress) settings_.progress(received);
      for (const std::string& event : events.feed(bytes)) stream.add(event);
      return !stream.ended();
    };
  }
  return client_.send(request, stop);
}

void ModelServer::update_breaker(const Verdict& verdict) {
  std::lock_guard lock(mutex_);
  if (verdict.answer.kind == ServerAnswer::Kind::Cancelled) {
    breaker_.give_up_probe();
  } else if (verdict.server == Verdict::Server::Up) {
    breaker_.succeed();
  } else if (verdict.server == Verdict::Server::Down) {
    breaker_.fail(now_ns(), verdict.answer.error.message);
  } else {
    breaker_.open(now_ns(), settings_.quota_breaker_s, verdict.answer.error.message);
  }
}

ServerAnswer ModelServer::chat(const std::string& body, bool event_stream, std::int64_t deadline_ns,
                               std::stop_token stop, const DropRequestPart& drop_request_part,
                               Transcript& transcript) {
  const auto cancelled = [&] {
    std::lock_guard lock(mutex_);
    breaker_.give_up_probe();
    ServerAnswer answer;
    answer.kind = ServerAnswer::Kind::Cancelled;
    answer.error = {ErrorCode::Unavailable, "cancelled"};
    return answer;
  };
  for (int attempt = 0, looks = 0;;) {
    double pause_s = 0;
    {
      std::lock_guard lock(mutex_);
      if (!breaker_.try_pass(now_ns())) {
        char left[64];
        std::snprintf(left, sizeof left, " (no further request for %.0f s)", breaker_.seconds_left(now_ns()));
        ServerAnswer answer;
        answer.error = {ErrorCode::Unavailable, breaker_.reason() + left};
        return answer;
      }
      pause_s = seconds_from_ns(bucket_.take_in_debt(now_ns()));
    }
    if (!wait(pause_s, stop)) return cancelled();
    const HttpReply http = send_chat(body, event_stream, deadline_ns, stop);
    Verdict verdict = judge(http);
    transcript.reply(http.status, http.end == HttpReply::End::Complete ? http.body : http.message);
    if (verdict.refused && drop_request_part(verdict.refusal, verdict.named_only)) {
      verdict.server = Verdict::Server::Up;
      verdict.answer.kind = ServerAnswer::Kind::Refused;
      verdict.repeat = false;
    }
    update_breaker(verdict);
    ServerAnswer& answer = verdict.answer;
    if (!verdict.repeat || (!verdict.loading && attempt >= settings_.max_retries)) return std::move(answer);
    const double cap_s = verdict.loading ? std::min(kMaxLoadingPollInterval_s, settings_.max_backoff_s)
                                         : settings_.max_backoff_s;
    double delay_s = backoff_s(verdict.loading ? looks++ : attempt++, settings_.backoff_s, cap_s,
                               unit_random(), verdict.retry_after_s);
    if (verdict.loading) delay_s = std::max(delay_s, 0.5 * settings_.backoff_s);
    if (now_ns() + static_cast<std::int64_t>(delay_s * 1e9) >= deadline_ns) {
      answer.error.message += " (a retry would exceed the deadline)";
      return std::move(answer);
    }
    log_debug("model server: %s; retry in %.2f s", answer.error.message.c_str(), delay_s);
    if (!wait(delay_s, stop)) return cancelled();
  }
}

}  // namespace livegs
