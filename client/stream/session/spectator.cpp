// SPDX-License-Identifier: Apache-2.0
#include "stream/session/spectator.h"

#include <pthread.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>
#include <zmq.hpp>

#include "core/assert.h"
#include "core/clock.h"
#include "core/log.h"
#include "livegs/v1/session.grpc.pb.h"
#include "livegs/v1/spectate.grpc.pb.h"
#include "stream/channel/rpc_channel.h"
#include "stream/received/known_objects.h"
#include "trust/server_probe.h"
#include "wire/frame_codec.h"
#include "wire/publication.h"

namespace livegs {
namespace {

constexpr std::chrono::milliseconds kSpectatorPollInterval{50};  // check for a stop request and for silence
constexpr int64_t kSilenceTimeout_ns = 1'000'000'000;
constexpr std::chrono::seconds kSpectatorDeadline{10}, kFetchDeadline{600};
constexpr int64_t kSpectatorRetry_ns = 100'000'000;

}  // namespace

struct Spectator::Connection {
  std::string address;
  std::shared_ptr<const ServerAccess> access;
  std::unique_ptr<v1::Spectators::Stub> spectators;
  std::unique_ptr<v1::LiveGs::Stub> assets;
  JoinedScene scene;

  // Used by the thread only, once it runs.
  zmq::context_t context{1};
  zmq::socket_t frames{context, zmq::socket_type::sub};
  KnownObjects known;
  std::string server_instance;
  uint64_t event_number = 0;
  StreamSink* sink = nullptr;

  std::thread thread;
  std::atomic<bool> stopping{false};
  mutable std::mutex mutex;  // guards totals
  Totals totals;

  Result<v1::SceneDescription> describe();
  Result<KnownObjects::Difference> take(const v1::SceneDescription& described);
  // Whether the frame belongs to the known scene, after the sink was updated.
  bool follow(const Publication& publication);
  void run();
};

Result<v1::SceneDescription> Spectator::Connection::describe() {
  v1::DescribeSceneRequest request;
  request.set_protocol_version(kProtocolVersion);
  v1::SceneDescription reply;
  grpc::ClientContext call;
  call.set_deadline(std::chrono::system_clock::now() + kSpectatorDeadline);
  const grpc::Status status = spectators->DescribeScene(&call, request, &reply);
  if (!status.ok()) {
    if (access) {
      if (auto refused = access->refused(); !refused) return refused.error();
    }
    return error_from(status, address);
  }
  std::lock_guard lock(mutex);
  ++totals.described;
  return reply;
}

Result<KnownObjects::Difference> Spectator::Connection::take(const v1::SceneDescription& described) {
  std::vector<const v1::ObjectDescription*> objects;
  for (const v1::ObjectDescription& object : described.objects()) objects.push_back(&object);
  auto difference = known.replace(objects);
  if (!difference) return difference;
  server_instance = described.server_instance();
  event_number = described.event_number();
  return difference;
}

bool Spectator::Connection::follow(const Publication& publication) {
  const bool same_server = publication.server_instance == server_instance;
  if (same_server && publication.event_number <= event_number)
    return publication.event_number == event_number;
  const auto described = describe();
  if (!described) {
    log_debug("%s", described.error().message.c_str());
    return false;
  }
  auto difference = take(*described);
  if (!difference) {
    log_warn("%s: %s", address.c_str(), difference.error().message.c_str());
    return false;
  }
  if (!same_server) sink->on_resumed({false, 0});
  for (const uint32_t id : difference->removed) sink->on_object_removed(id);
  for (StreamedObject& object : difference->added) sink->on_object_added(std::move(object));
  for (StreamedObject& object : difference->changed) sink->on_object_changed(std::move(object));
  return publication.server_instance == server_instance && publication.event_number == event_number;
}

void Spectator::Connection::run() {
  int64_t last_message_ns = 0;  // 0: nothing received yet, so the stream cannot be lost
  bool lost = false;
  while (!stopping) {
    zmq::message_t message;
    try {
      if (!frames.recv(message)) {  // no message within kSpectatorPollInterval
        if (!lost && last_message_ns > 0 && now_ns() - last_message_ns > kSilenceTimeout_ns) {
          lost = true;
          sink->on_lost("nothing was published for 1 s");
        }
        continue;
      }
    } catch (const zmq::error_t& error) {
      if (error.num() != EINTR) log_warn("%s: %s", address.c_str(), error.what());
      continue;
    }
    const int64_t received_ns = now_ns();
    auto publication = decode_publication({message.data<std::byte>(), message.size()});
    if (!publication) {
      log_debug("%s: %s", address.c_str(), publication.error().message.c_str());
      continue;
    }
    const bool same_server = publication->server_instance == server_instance;
    const bool fits = follow(*publication);
    {
      std::lock_guard lock(mutex);
      ++(fits ? totals.frames : totals.left_out);
    }
    if (!fits) continue;
    if (lost && same_server) sink->on_resumed({true, seconds_from_ns(received_ns - last_message_ns)});
    lost = false;
    last_message_ns = received_ns;
    ReceivedFrame frame;
    frame.tick = publication->frame.tick;
    frame.bytes = message.size();
    frame.stepped_ns = frame.encode_begun_ns = frame.sent_ns = publication->stepped_ns;
    frame.received_ns = received_ns;
    frame.clock = ClockOffset::Estimate{};  // the server runs on this machine, so the clock is the same
    frame.run.set_simulated_s(seconds_from_ns(publication->frame.simulated_ns));
    frame.drivers = std::make_shared<const DriverFrame>(std::move(publication->frame));
    frame.decoded_ns = now_ns();
    sink->on_frame(std::move(frame));
  }
}

Spectator::Spectator(std::unique_ptr<Connection> connection) : connection_(std::move(connection)) {}
Spectator::~Spectator() { stop(); }

Result<std::unique_ptr<Spectator>> Spectator::subscribe(const std::string& server,
                                                        const std::string& published,
                                                        std::shared_ptr<const ServerAccess> access,
                                                        double timeout_s) {
  auto connection = std::make_unique<Connection>();
  connection->address = server;
  connection->access = std::move(access);
  try {
    // Set before connecting: only the newest frame is queued.
    connection->frames.set(zmq::sockopt::conflate, 1);
    connection->frames.set(zmq::sockopt::maxmsgsize, static_cast<int64_t>(kMaxFrameBytes) + 64);
    connection->frames.set(zmq::sockopt::rcvtimeo, static_cast<int>(kSpectatorPollInterval.count()));
    connection->frames.set(zmq::sockopt::linger, 0);
    connection->frames.set(zmq::sockopt::ipv6, published.find('[') != std::string::npos);
    connection->frames.set(zmq::sockopt::subscribe, "");
    connection->frames.connect(published);
  } catch (const zmq::error_t& error) {
    return invalid_argument("--subscribe " + published + ": " + error.what() + "; give tcp://127.0.0.1:PORT");
  }
  const ServerAccess* keys = connection->access.get();
  connection->spectators = v1::Spectators::NewStub(make_channel(server, keys));
  connection->assets = v1::LiveGs::NewStub(make_channel(server, keys));
  const int64_t give_up_ns = now_ns() + static_cast<int64_t>(1e9 * timeout_s);
  auto described = connection->describe();
  while (!described && described.error().code == ErrorCode::Unavailable && now_ns() < give_up_ns) {
    sleep_until_ns(now_ns() + kSpectatorRetry_ns);
    described = connection->describe();
  }
  if (!described) {
    const bool absent = described.error().code == ErrorCode::Unavailable;
    return absent && !keys && speaks_tls(server) ? requires_tls(server) : described.error();
  }
  auto all = connection->take(*described);
  if (!all) return all.error();
  connection->scene.rate_hz = described->rate_hz();
  connection->scene.objects = std::move(all->added);
  return std::unique_ptr<Spectator>(new Spectator(std::move(connection)));
}

const JoinedScene& Spectator::scene() const { return connection_->scene; }

Result<void> Spectator::fetch_asset(const std::string& hash, uint64_t, uint64_t offset,
                                    const TakeChunk& take) {
  v1::FetchAssetRequest request;
  request.set_asset_hash(hash);
  request.set_offset(offset);
  grpc::ClientContext call;
  call.set_deadline(std::chrono::system_clock::now() + kFetchDeadline);
  const auto reader = connection_->assets->FetchAsset(&call, request);
  v1::AssetChunk chunk;
  while (reader->Read(&chunk)) {
    auto taken = take(chunk.offset(), chunk.total_bytes(), std::as_bytes(std::span(chunk.data())));
    if (taken) continue;
    call.TryCancel();
    (void)reader->Finish();
    return taken;
  }
  const grpc::Status status = reader->Finish();
  if (!status.ok()) return error_from(status, connection_->address + ": asset " + hash.substr(0, 12));
  return {};
}

void Spectator::start(StreamSink& sink) {
  LIVEGS_ASSERT(connection_->sink == nullptr);
  connection_->sink = &sink;
  connection_->thread = std::thread([connection = connection_.get()] {
    pthread_setname_np(pthread_self(), "spectator");
    connection->run();
  });
}

void Spectator::stop() {
  connection_->stopping = true;
  if (connection_->thread.joinable()) connection_->thread.join();
}

Spectator::Totals Spectator::totals() const {
  std::lock_guard lock(connection_->mutex);
  return connection_->totals;
}

}  // namespace livegs
