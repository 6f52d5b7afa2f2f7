// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "system/support/program.h"

namespace livegs::bench {

// A frame that a client got. Moments of the machine's monotonic clock, which server and clients share here.
struct GotFrame {
  uint64_t tick = 0;
  int64_t stepped_ns = 0, received_ns = 0, decoded_ns = 0;  // decoded_ns: as received_ns where it was not
  uint32_t client = 0, bytes = 0;
};

struct ServerToJoin {
  int port = 0;
  std::string fingerprint;  // empty: in the clear
  std::string token;
};

// How the clients of a server are made.
enum class ClientKind {
  Whole,  // as the product's: takes frames, decodes and acknowledges them. It draws nothing
  Light,  // acknowledges frames and does not decode them: what a server sees of clients on machines of their
          // own
  Looking,  // as Light, and says what it looks at: stands at the origin, each turned otherwise, and turns
  Capped,   // as Looking, with a cap that it does not reach: what it does not see is left out, so that each
            // has bytes of its own
};

constexpr const char* kind_name(ClientKind kind) {
  return kind == ClientKind::Whole     ? "whole"
         : kind == ClientKind::Light   ? "light"
         : kind == ClientKind::Looking ? "looking"
                                       : "capped";
}

// Clients of a server, in a process of their own, so that what each end costs can be told apart. From having
// joined to destruction.
class StreamClients {
 public:
  StreamClients(const ServerToJoin& server, int count, ClientKind kind);

  // Processor time of the process so far.
  int64_t cpu_ns() const;
  void freeze();  // it runs no more, and is told nothing
  // Ends them in order. What they got, client by client.
  std::vector<GotFrame> stop();

 private:
  ScratchFolder folder_;
  std::unique_ptr<Program> process_;
};

// What that process does: main() of a bench begins with `if (is_stream_clients(argc, argv)) return
// run_stream_clients(argv);`.
bool is_stream_clients(int argc, char** argv);
int run_stream_clients(char** argv);

}  // namespace livegs::bench
