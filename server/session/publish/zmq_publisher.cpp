// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/publish/zmq_publisher.h"

#include <zmq.hpp>

#include "trust/host_port.h"

namespace livegs {
namespace {

constexpr std::string_view kTcp = "tcp://";
// Send queue, in frames. A subscriber with ZMQ_CONFLATE needs only the newest frame.
constexpr int kMaxQueuedFrames = 2;

}  // namespace

// An XPUB socket is PUB plus subscription messages: the first byte is 1 for the first subscriber, 0 after the
// last unsubscribes.
struct ZmqPublisher::Socket {
  zmq::context_t context{1};
  zmq::socket_t frames{context, zmq::socket_type::xpub};
  std::string address;
  bool has_subscribers = false;
};

ZmqPublisher::ZmqPublisher(std::unique_ptr<Socket> socket) : socket_(std::move(socket)) {}
ZmqPublisher::~ZmqPublisher() = default;

Result<std::unique_ptr<ZmqPublisher>> ZmqPublisher::bind(const std::string& address) {
  const auto where = address.starts_with(kTcp)
                         ? parse_host_port(address.substr(kTcp.size()))
                         : Result<HostPort>(invalid_argument("does not begin with tcp://"));
  if (!where)
    return invalid_argument("--publish " + address + ": is not tcp://HOST:PORT; use tcp://127.0.0.1:PORT");
  if (!where->loopback) {
    return invalid_argument("--publish " + address +
                            ": is not local, and frames are published without tokens or encryption; use "
                            "tcp://127.0.0.1:PORT, and livegs-client HOST:PORT on other machines");
  }
  auto socket = std::make_unique<Socket>();
  try {
    socket->frames.set(zmq::sockopt::sndhwm, kMaxQueuedFrames);
    socket->frames.set(zmq::sockopt::linger, 0);
    socket->frames.set(zmq::sockopt::ipv6, where->host.front() == '[');
    const std::string host = where->host == "localhost" ? "127.0.0.1" : where->host;
    socket->frames.bind(std::string(kTcp) + host + ":" +
                        (where->port == 0 ? "*" : std::to_string(where->port)));
    socket->address = socket->frames.get(zmq::sockopt::last_endpoint);
  } catch (const zmq::error_t& error) {
    return Error{ErrorCode::Unavailable, "--publish " + address + ": " + error.what() +
                                             "; give another port, or 0 to let the system choose"};
  }
  return std::unique_ptr<ZmqPublisher>(new ZmqPublisher(std::move(socket)));
}

const std::string& ZmqPublisher::address() const { return socket_->address; }

bool ZmqPublisher::has_subscribers() {
  zmq::message_t said;
  try {
    while (socket_->frames.recv(said, zmq::recv_flags::dontwait)) {
      if (said.size() > 0) socket_->has_subscribers = *said.data<uint8_t>() == 1;
    }
  } catch (const zmq::error_t&) {
    // Ignored: the state is read again at the next call.
  }
  return socket_->has_subscribers;
}

void ZmqPublisher::publish(const Publication& publication) {
  const std::vector<std::byte> bytes = encode_publication(publication);
  try {
    if (socket_->frames.send(zmq::buffer(bytes.data(), bytes.size()), zmq::send_flags::dontwait))
      ++published_;
  } catch (const zmq::error_t&) {
    // Ignored: the next frame follows.
  }
}

}  // namespace livegs
