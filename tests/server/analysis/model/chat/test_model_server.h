// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace livegs {

// What a client sent.
struct SeenRequest {
  std::string method, path, head, body;
};

// What the test endpoint does with one request.
struct Reply {
  int status = 200;
  std::string body;
  std::string content_type = "application/json";
  std::vector<std::string> headers;           // more of them, "Retry-After: 1"
  int delay_ms = 0;                           // before the first byte
  std::size_t piece_bytes = 0;                // the body in pieces of this size; 0: whole
  int piece_delay_ms = 0;                     // before each but the first
  std::size_t cut_after = std::string::npos;  // the connection ends after so many bytes of the body
  bool keep_alive = false;                    // the next request may come on the same connection
  bool hang = false;                          // nothing more is sent after what `cut_after` lets through
  std::string raw;                            // sent as it is, in place of everything else
};

inline Reply not_found_reply() {
  Reply reply;
  reply.status = 404;
  reply.body = "{}";
  return reply;
}

// An HTTP server on 127.0.0.1 with a thread a connection, which does what it is told. Every reply ends its
// connection unless it keeps it alive.
class TestModelServer {
 public:
  // Called for every POST, with the number of POSTs before it; one at a time.
  using Handler = std::function<Reply(const SeenRequest& request, int index)>;
  explicit TestModelServer(Handler handler, Reply models = not_found_reply());
  ~TestModelServer();

  std::string base_url() const;  // with /v1
  std::vector<SeenRequest> posts() const;
  void wait_for_posts(std::size_t count) const;  // blocks until so many have come
  bool wait_for_posts(std::size_t count,
                      double seconds) const;  // false when they did not; also from the handler
  int connections() const;                    // so far
  int most_at_once() const;                   // POSTs being answered

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace livegs
