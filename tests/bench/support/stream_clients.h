// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "system/support/program.h"

namespace livegs::bench {

// A frame that a client received. Times are of the machine's monotonic clock, which server and clients share
// here.
struct GotFrame {
  uint64_t tick = 0;
  int64_t stepped_ns = 0, received_ns = 0,
          decoded_ns = 0;  // decoded_ns: equal to received_ns if the frame was not decoded
  uint32_t client = 0, bytes = 0;
};

struct ServerToJoin {
  int port = 0;
  std::string fingerprint;  // empty: clear text
  std::string token;
};

// Kinds of clients.
enum class ClientKind {
  Whole,  // receives, decodes and acknowledges frames, without drawing
  Light,  // acknowledges frames without decoding them, like clients on other machines from the server's view
  Looking,  // like Light, with a view: each at the origin with a different, turning direction
  Capped,  // like Looking, with a cap that is not reached: objects outside its view are dropped, so that each
           // client gets a different encoding
};

constexpr const char* kind_name(ClientKind kind) {
  return kind == ClientKind::Whole     ? "whole"
         : kind == ClientKind::Light   ? "light"
         : kind == ClientKind::Looking ? "looking"
                                       : "capped";
}

// Clients of a server in a separate process, so that the processor time of each end can be measured. They
// join in the constructor and leave in the destructor.
class StreamClients {
 public:
  StreamClients(const ServerToJoin& server, int count, ClientKind kind);

  // Processor time of the process so far.
  int64_t cpu_ns() const;
  void freeze();  // suspends the process
  // Stops the clients and returns the frames received, client by client.
  std::vector<GotFrame> stop();

 private:
  ScratchFolder folder_;
  std::unique_ptr<Program> process_;
};

// The main function of that process: main() of a bench begins with `if (is_stream_clients(argc, argv)) return
// run_stream_clients(argv);`.
bool is_stream_clients(int argc, char** argv);
int run_stream_clients(char** argv);

}  // namespace livegs::bench
