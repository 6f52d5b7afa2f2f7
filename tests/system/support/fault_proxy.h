// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <list>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

namespace livegs {

// Properties of the network between client and server.
struct Link {
  double delay_ms = 0;   // in each direction
  double jitter_ms = 0;  // additional delay, uniformly distributed; bytes of one connection keep their order
  double mbit_s = 0;     // in each direction, shared by all connections; 0: no limit
};

// A TCP proxy with faults. Accepts connections on its own port and forwards their bytes in both directions,
// with delay, limited bandwidth, or not at all. The seed determines the jitter. Uses one thread; its
// functions are non-blocking and may be called from any thread.
class FaultProxy {
 public:
  explicit FaultProxy(int server_port, uint64_t seed = 1);
  ~FaultProxy();
  FaultProxy(const FaultProxy&) = delete;
  FaultProxy& operator=(const FaultProxy&) = delete;

  int port() const { return port_; }
  // Port for new connections; a restarted server may have a different one.
  void set_server(int server_port);
  void set_link(const Link& link);
  // Holds all bytes for this time, then forwards them. 0 ends a stall.
  void stall(double seconds);
  // Disconnects the network without notice: nothing is forwarded, and bytes in flight are lost. Connections
  // that are open or being opened stay dead after heal(); their ends get no error.
  void cut();
  void heal();
  // Ends every connection at both ends with RST.
  void reset();
  // Resets the next `connections` connections, each once it has received this number of bytes from the
  // server.
  void reset_after(uint64_t bytes, int connections);

  uint64_t connections() const { return connections_; }              // accepted so far
  uint64_t bytes_from_server() const { return bytes_from_server_; }  // forwarded so far

 private:
  struct Piece {
    int64_t due_ns = 0;
    std::vector<char> bytes;
    size_t written = 0;
  };
  // One direction of a connection.
  struct Way {
    std::deque<Piece> pieces;
    size_t waiting_bytes = 0;
    int64_t last_due_ns = 0;
    bool ended = false;  // the sender has closed; forwarded after the remaining pieces
    bool end_forwarded = false;
  };
  struct Connection {
    int client = -1, server = -1;
    Way up, down;
    bool dead = false;  // by a cut: neither end is read any more
    uint64_t brought = 0;
    bool gone = false;
  };

  void run();
  void take_connection();
  void read(Connection& connection, bool from_client);
  void write(Connection& connection, bool to_client, int64_t now);
  static void end(Connection& connection, bool with_reset);
  void wake();

  int listener_ = -1, wake_ = -1;
  int port_ = 0;
  std::atomic<uint64_t> connections_{0}, bytes_from_server_{0};
  std::atomic<bool> stopping_{false};

  std::mutex mutex_;  // guards everything below; the thread releases it only while it waits
  int server_port_;
  Link link_;
  int64_t stalled_until_ns_ = 0;
  int64_t free_ns_[2] = {0, 0};  // times when upstream and downstream have sent their queued bytes
  bool cut_ = false;
  uint64_t reset_after_bytes_ = 0;
  int resets_left_ = 0;
  std::mt19937_64 random_;
  std::list<Connection> open_;

  std::thread thread_;
};

}  // namespace livegs
