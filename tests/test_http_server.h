// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace livegs {

// A request as received.
struct SeenRequest {
  std::string method, path, head, body;
};

// Response of the test server to one request.
struct Reply {
  int status = 200;
  std::string body;
  std::string content_type = "application/json";
  std::vector<std::string> headers;           // additional ones, "Retry-After: 1"
  int delay_ms = 0;                           // before the first byte
  std::size_t piece_bytes = 0;                // the body in pieces of this size; 0: whole
  int piece_delay_ms = 0;                     // before each but the first
  std::size_t cut_after = std::string::npos;  // the connection ends after this many bytes of the body
  bool keep_alive = false;                    // allows another request on the same connection
  bool hang = false;                          // sends nothing after the first `cut_after` bytes
  std::string raw;                            // sent verbatim in place of everything else
};

inline Reply not_found_reply() {
  Reply reply;
  reply.status = 404;
  reply.body = "{}";
  return reply;
}

// HTTP server on 127.0.0.1 with one thread per connection, for scripted responses. A reply ends its
// connection unless keep_alive is set.
class TestHttpServer {
 public:
  // Called for every POST with the number of earlier POSTs; calls are serialised.
  using Handler = std::function<Reply(const SeenRequest& request, int index)>;
  explicit TestHttpServer(Handler handler, Reply models = not_found_reply());
  // Any other service: the handler is called for every request, whatever its method, with the number of
  // earlier ones. `port`: 0 lets the system choose.
  TestHttpServer(Handler handler, int port);
  // `others`: called for every other request, concurrently.
  using OtherHandler = std::function<Reply(const SeenRequest& request)>;
  explicit TestHttpServer(OtherHandler others);
  ~TestHttpServer();

  std::string base_url() const;  // with /v1
  std::string origin() const;    // "http://127.0.0.1:PORT"
  int port() const;
  std::vector<SeenRequest> posts() const;
  void wait_for_posts(std::size_t count) const;  // blocks until `count` POSTs have arrived
  bool wait_for_posts(std::size_t count,
                      double seconds) const;  // false on a timeout; also callable from the handler
  int connections() const;                    // so far
  int most_at_once() const;                   // POSTs in progress
  // Before the first request: waits this long before each piece of a request, of at most 64 KiB, and keeps
  // little of what is not yet read.
  void receive_slowly(int pause_ms);

 private:
  void start(int port);
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace livegs
