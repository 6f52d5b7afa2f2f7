// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "store/secret.h"

// HTTP client over libcurl; all transfers run on one internal thread. No redirects; http and https only;
// certificates are verified; the size of a reply that is kept is bounded. Writes no log.

namespace livegs {

inline constexpr std::size_t kMaxReplyBytes = std::size_t{4} << 20;

// Keys that sign requests to an S3-compatible store (AWS signature version 4).
struct AwsKeys {
  std::string access_key, region;
  Secret secret_key, session_token;  // the token may be empty
};

// A piece of an object: its place in the whole object, whether the server answers with a range or not.
struct HttpPart {
  std::uint64_t offset = 0;
  std::optional<std::uint64_t> total_bytes;  // of the whole object, if the server gives it
  std::string_view version;                  // as HttpReply::version
  std::string_view bytes;
};

struct HttpRequest {
  std::string url;
  std::string method;  // empty: GET without a body, else POST
  std::string body;    // application/json
  bool head = false;
  const std::span<const std::byte>* put = nullptr;  // PUT of these bytes; must outlive the call
  std::uint64_t from = 0;                           // first byte that is wanted (Range); 0: the whole
  std::string if_version;  // the whole if the object has another version now (If-Range); empty: any
  bool event_stream = false;
  const Secret* bearer = nullptr;  // must outlive the call; sent as the Authorization header
  const AwsKeys* sign = nullptr;   // likewise
  double connect_timeout_s = 5, total_timeout_s = 60;    // total 0: none
  double first_byte_timeout_s = 0, stall_timeout_s = 0;  // 0: none
  std::size_t max_bytes = kMaxReplyBytes;
  // Receives each chunk of a successful reply's body, on the network thread; returning false ends the
  // transfer as complete. May be null.
  std::function<bool(std::string_view)> on_body;
  // As on_body, for objects of any size: the reply's body stays empty and is not limited. A range that the
  // server places elsewhere than asked is given where it is.
  std::function<bool(const HttpPart&)> on_part;
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
  std::optional<std::uint64_t> total_bytes;  // of the whole object, of a reply of status 200, 206 or 416
  std::string version;                       // of the object: ETag, else Last-Modified, else empty
  double sending_s = 0;                      // from the begin to the last byte of `put` that was sent
  std::optional<double> retry_after_s;       // seconds from now, from either form of Retry-After
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
