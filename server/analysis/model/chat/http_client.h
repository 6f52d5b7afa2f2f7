// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/model/secret.h"

// HTTP client over libcurl; all transfers run on one internal thread. No redirects; http and https only;
// certificates are verified; reply size is bounded. Writes no log.

namespace livegs {

inline constexpr std::size_t kMaxReplyBytes = std::size_t{4} << 20;

struct HttpRequest {
  std::string url;
  std::string method;  // empty: GET without a body, else POST
  std::string body;    // application/json
  bool event_stream = false;
  const Secret* bearer = nullptr;  // must outlive the call; sent as the Authorization header
  double connect_timeout_s = 5, total_timeout_s = 60;
  double first_byte_timeout_s = 0, stall_timeout_s = 0;  // 0: none
  std::size_t max_bytes = kMaxReplyBytes;
  // Receives each chunk of a successful reply's body, on the network thread; returning false ends the
  // transfer as complete. May be null.
  std::function<bool(std::string_view)> on_body;
};

struct HttpReply {
  enum class End {
    Complete,
    Cancelled,
    Deadline,      // total_timeout_s
    NotConnected,  // unresolved, refused, or connect_timeout_s
    Late,          // first_byte_timeout_s
    Stalled,       // stall_timeout_s
    Cut,           // the connection ended within the reply, or the reply is not HTTP
    TooLarge,
    BadTls,
    BadUrl,
  };
  End end = End::Complete;
  std::string message;  // cause, if end is not Complete
  int status = 0;       // 0 without a reply
  std::string content_type, body;
  std::optional<double> retry_after_s;  // seconds from now, from either form of Retry-After
};

class HttpClient {
 public:
  HttpClient();
  ~HttpClient();  // ends running transfers as Cancelled
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  // Blocks until the reply, a timeout or a requested stop. Any number of threads may call it concurrently.
  HttpReply send(const HttpRequest& request, std::stop_token stop);

 private:
  struct Worker;
  std::unique_ptr<Worker> worker_;
};

// True for loopback addresses ("127.0.0.1", "localhost", "::1").
bool is_loopback_url(std::string_view url);

}  // namespace livegs
