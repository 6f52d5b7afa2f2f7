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

// How a network between a client and a server is.
struct Link {
  double delay_ms = 0;   // each way
  double jitter_ms = 0;  // more than that, evenly distributed; bytes of one connection keep their order
  double mbit_s = 0;     // each way, of all connections together; 0: no limit
};

// A network that can be made to fail: takes TCP connections on a port of its own and passes their bytes on to
// a server's, both ways, late, slowly, not at all. What the jitter draws comes from the seed. One thread; the
// functions may be called from any other and return at once.
class FaultProxy {
 public:
  explicit FaultProxy(int server_port, uint64_t seed = 1);
  ~FaultProxy();
  FaultProxy(const FaultProxy&) = delete;
  FaultProxy& operator=(const FaultProxy&) = delete;

  int port() const { return port_; }
  // Of connections to come: a server that was started anew may have another.
  void set_server(int server_port);
  void set_link(const Link& link);
  // Nothing gets through until it is over; then all of it does. 0 ends a stall.
  void stall(double seconds);
  // As if a cable were pulled: nothing gets through, nobody is told, and what was sent is lost. Connections
  // that are open or are being made then stay dead after heal(): their ends may wait for ever.
  void cut();
  void heal();
  // Ends every connection at both ends with RST.
  void reset();
  // The next connections that have brought so many bytes from the server are ended with RST, each once; so
  // many of them.
  void reset_after(uint64_t bytes, int connections);

  uint64_t connections() const { return connections_; }              // taken so far
  uint64_t bytes_from_server() const { return bytes_from_server_; }  // passed on so far

 private:
  struct Piece {
    int64_t due_ns = 0;
    std::vector<char> bytes;
    size_t written = 0;
  };
  // One way of a connection.
  struct Way {
    std::deque<Piece> pieces;
    size_t waiting_bytes = 0;
    int64_t last_due_ns = 0;
    bool ended = false;  // nothing more will come; passed on once the pieces are
    bool told = false;
  };
  struct Connection {
    int client = -1, server = -1;
    Way up, down;
    bool dead = false;  // by a cut: nobody reads from either end any more
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

  std::mutex mutex_;  // guards everything below, which the thread holds but while it waits
  int server_port_;
  Link link_;
  int64_t stalled_until_ns_ = 0;
  int64_t free_ns_[2] = {0, 0};  // when the pipe up and the pipe down have sent what they were given
  bool cut_ = false;
  uint64_t reset_after_bytes_ = 0;
  int resets_left_ = 0;
  std::mt19937_64 random_;
  std::list<Connection> open_;

  std::thread thread_;
};

}  // namespace livegs
