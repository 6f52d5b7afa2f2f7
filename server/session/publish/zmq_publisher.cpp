// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/publish/zmq_publisher.h"

#include <zmq.hpp>

#include "trust/host_port.h"

namespace livegs {
namespace {

constexpr std::string_view kTcp = "tcp://";
// For a subscriber that conflates, what waits on this side is one frame too old already.
constexpr int kMaxQueuedFrames = 2;

}  // namespace

// XPUB is PUB that also tells of subscriptions: the first byte of what it receives is 1 when the first
// subscriber comes, and 0 when the last has gone.
struct ZmqPublisher::Socket {
  zmq::context_t context{1};
  zmq::socket_t frames{context, zmq::socket_type::xpub};
  std::string address;
  bool has_subscribers = false;
};

ZmqPublisher::ZmqPublisher(std::unique_ptr<Socket> socket) : socket_(std::move(socket)) {}
ZmqPublisher::~ZmqPublisher() = default;

Result<std::unique_ptr<ZmqPublisher>> ZmqPublisher::bind(const std::string& address) {
  const auto where = address.starts_with(kTcp) ? parse_host_port(address.substr(kTcp.size()))
                                               : Result<HostPort>(invalid_argument("begins not with tcp://"));
  if (!where)
    return invalid_argument("--publish " + address + ": give tcp://127.0.0.1:PORT; " + where.error().message);
  if (!where->loopback) {
    return invalid_argument(
        "--publish " + address +
        ": frames are published without tokens or encryption, so on this machine only; give "
        "tcp://127.0.0.1:PORT, and let other machines join with livegs-client HOST:PORT");
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
    return Error{ErrorCode::Unavailable, "--publish " + address + ": " + error.what()};
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
    // Nobody is told apart by it; the next look tells.
  }
  return socket_->has_subscribers;
}

void ZmqPublisher::publish(const Publication& publication) {
  const std::vector<std::byte> bytes = encode_publication(publication);
  try {
    if (socket_->frames.send(zmq::buffer(bytes.data(), bytes.size()), zmq::send_flags::dontwait))
      ++published_;
  } catch (const zmq::error_t&) {
    // A frame that nobody gets is followed by the next.
  }
}

}  // namespace livegs
