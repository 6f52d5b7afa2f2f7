// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/job/job_metrics.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <charconv>

#include "core/log.h"

namespace livegs {
namespace {

constexpr int kStopPoll_ms = 50;
constexpr timeval kRequestTimeout{1, 0};  // of a peer that neither sends nor reads

Error bad_address(const std::string& address, const char* problem) {
  return invalid_argument("--metrics " + address + ": " + problem + "; give [HOST:]PORT of a free port");
}

}  // namespace

Result<std::unique_ptr<JobMetrics>> JobMetrics::serve(const std::string& address, std::string command) {
  const size_t colon = address.rfind(':');
  const std::string host = colon == std::string::npos ? "127.0.0.1" : address.substr(0, colon);
  const std::string digits = colon == std::string::npos ? address : address.substr(colon + 1);
  uint16_t port = 0;
  const auto parsed = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(port);
  if (digits.empty() || parsed.ec != std::errc() || parsed.ptr != digits.data() + digits.size() ||
      ::inet_pton(AF_INET, host.c_str(), &at.sin_addr) != 1)
    return bad_address(address, "is not an address");
  std::unique_ptr<JobMetrics> metrics(new JobMetrics);
  metrics->command_ = std::move(command);
  metrics->listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int reuse = 1;
  ::setsockopt(metrics->listener_, SOL_SOCKET, SO_REUSEADDR, &reuse, sizeof reuse);
  socklen_t size = sizeof at;
  if (::bind(metrics->listener_, reinterpret_cast<sockaddr*>(&at), size) != 0 ||
      ::listen(metrics->listener_, 8) != 0 ||
      ::getsockname(metrics->listener_, reinterpret_cast<sockaddr*>(&at), &size) != 0)
    return Error{errno == EADDRINUSE ? ErrorCode::Unavailable : ErrorCode::InvalidArgument,
                 "--metrics " + address + ": cannot listen there: " + std::strerror(errno) +
                     "; give a free port of this machine"};
  log_info("metrics: http://%s:%d/metrics", host.c_str(), ntohs(at.sin_port));
  metrics->thread_ =
      std::jthread([serving = metrics.get()](const std::stop_token& stop) { serving->run(stop); });
  return metrics;
}

JobMetrics::~JobMetrics() {
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
  }
  if (listener_ >= 0) ::close(listener_);
}

std::string JobMetrics::text() const {
  std::string all;
  const auto add = [&](const char* name, const char* help, size_t value) {
    all += std::string("# HELP ") + name + " " + help + "\n# TYPE " + name + " gauge\n" + name +
           "{command=\"" + command_ + "\"} " + std::to_string(value) + "\n";
  };
  add("livegs_job_steps_done", "Steps done, also by earlier runs of the job", steps_done);
  add("livegs_job_steps", "Steps of the whole job; 0: unknown", steps);
  add("livegs_job_checkpoint_step", "Step of the last checkpoint", checkpoint_step);
  return all;
}

void JobMetrics::run(const std::stop_token& stop) const {
  while (!stop.stop_requested()) {
    pollfd waiting{listener_, POLLIN, 0};
    if (::poll(&waiting, 1, kStopPoll_ms) <= 0) continue;
    const int peer = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (peer < 0) continue;
    ::setsockopt(peer, SOL_SOCKET, SO_RCVTIMEO, &kRequestTimeout, sizeof kRequestTimeout);
    ::setsockopt(peer, SOL_SOCKET, SO_SNDTIMEO, &kRequestTimeout, sizeof kRequestTimeout);
    char request[4096];
    const ssize_t got = ::recv(peer, request, sizeof request, 0);
    const bool good =
        std::string_view(request, got > 0 ? static_cast<size_t>(got) : 0).starts_with("GET /metrics");
    const std::string body = good ? text() : "";
    const std::string reply =
        std::string("HTTP/1.1 ") + (good ? "200 OK" : "404 Not Found") +
        "\r\nContent-Type: text/plain; version=0.0.4\r\nConnection: close\r\nContent-Length: " +
        std::to_string(body.size()) + "\r\n\r\n" + body;
    (void)::send(peer, reply.data(), reply.size(), MSG_NOSIGNAL);
    ::shutdown(peer, SHUT_WR);
    ::close(peer);
  }
}

}  // namespace livegs
