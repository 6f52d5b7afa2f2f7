// SPDX-License-Identifier: Apache-2.0
#include "stream/session_client.h"

#include <grpc/support/log.h>
#include <grpcpp/create_channel.h>
#include <pthread.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include "core/assert.h"
#include "core/clock.h"
#include "core/log.h"
#include "livegs/v1/session.grpc.pb.h"
#include "stream/input_message.h"
#include "stream/object_description.h"
#include "wire/frame_codec.h"
#include "wire/frame_stream.h"

namespace livegs {
namespace {

using Clock = std::chrono::system_clock;  // gRPC's deadlines

constexpr std::chrono::milliseconds kSignOfLife{50};
constexpr std::chrono::seconds kCallDeadline{10};
constexpr std::chrono::milliseconds kRetryAfter{100};
// A server that trickles an asset slower than this is given up; what has arrived is kept for the next
// attempt.
constexpr std::chrono::seconds kFetchPatience{10};
constexpr uint64_t kSlowestFetch_bytes_s = 1 << 20;
constexpr size_t kSamplesPerMessage = 3;
// A scene's rest bodies come in one message; frames are smaller.
constexpr int kMaxReplyBytes = 512 << 20;

void quieten_grpc() {
  static std::once_flag once;
  std::call_once(once, [] {
    gpr_set_log_function([](gpr_log_func_args* line) { log_debug("grpc: %s", line->message); });
  });
}

std::shared_ptr<grpc::Channel> make_channel(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMaxReplyBytes);
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);  // each channel is a connection of its own
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);          // a headset's server is on the same network
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 500);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 1000);  // the server permits 500
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 3000);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

Error from_status(const grpc::Status& status, const std::string& prefix) {
  const auto code = [&] {
    switch (status.error_code()) {
      case grpc::StatusCode::NOT_FOUND:
        return ErrorCode::NotFound;
      case grpc::StatusCode::FAILED_PRECONDITION:
      case grpc::StatusCode::UNIMPLEMENTED:
        return ErrorCode::Unsupported;
      case grpc::StatusCode::INVALID_ARGUMENT:
      case grpc::StatusCode::OUT_OF_RANGE:
        return ErrorCode::InvalidArgument;
      case grpc::StatusCode::RESOURCE_EXHAUSTED:
        return ErrorCode::TooLarge;
      case grpc::StatusCode::UNAVAILABLE:
      case grpc::StatusCode::CANCELLED:
      case grpc::StatusCode::DEADLINE_EXCEEDED:
        return ErrorCode::Unavailable;
      default:
        return ErrorCode::Internal;
    }
  }();
  return {code, prefix + ": " + status.error_message()};
}

Eigen::Vector3f vector_of(const google::protobuf::RepeatedField<float>& numbers) {
  return numbers.size() == 3 ? Eigen::Vector3f(numbers[0], numbers[1], numbers[2]) : Eigen::Vector3f::Zero();
}

}  // namespace

struct SessionClient::Connection {
  std::string address;
  ConnectOptions options;
  JoinedScene scene;
  std::shared_ptr<grpc::Channel> channel, asset_channel;
  std::unique_ptr<v1::LiveGs::Stub> stub, asset_stub;

  grpc::ClientContext context;  // of the stream
  std::unique_ptr<grpc::ClientReaderWriter<v1::ClientMessage, v1::ServerMessage>> stream;
  StreamSink* sink = nullptr;
  std::thread reader, writer;
  std::atomic<bool> ended{false};
  std::atomic<bool> drained{false};
  StreamReader frames;  // the reader's thread only

  std::mutex mutex;  // guards everything below
  std::condition_variable changed;
  std::deque<InputSample> samples;  // the last three
  bool samples_new = false;
  uint64_t acknowledged_tick = 0;
  bool acknowledgement_new = false;
  bool key_frame_wanted = false;
  bool stopping = false;
  bool stopped = false;
  Result<void> outcome;

  void read();
  void write();
  Result<void> take(v1::ServerMessage& message, int64_t received_ns);
};

SessionClient::SessionClient(std::unique_ptr<Connection> connection) : connection_(std::move(connection)) {}

SessionClient::~SessionClient() { (void)stop(); }

Result<std::unique_ptr<SessionClient>> SessionClient::join(const std::string& address,
                                                           const ConnectOptions& options) {
  quieten_grpc();
  auto connection = std::make_unique<Connection>();
  connection->address = address;
  connection->options = options;
  connection->channel = make_channel(address);
  connection->asset_channel = make_channel(address);
  connection->stub = v1::LiveGs::NewStub(connection->channel);
  connection->asset_stub = v1::LiveGs::NewStub(connection->asset_channel);

  const Clock::time_point give_up =
      Clock::now() + std::chrono::microseconds(static_cast<int64_t>(options.timeout_s * 1e6));
  if (!connection->channel->WaitForConnected(give_up)) {
    char text[64];
    std::snprintf(text, sizeof text, " within %.1f s; start one with livegs-server SCENE", options.timeout_s);
    return Error{ErrorCode::Unavailable, "no server answers at " + address + text};
  }
  v1::JoinRequest request;
  request.set_protocol_version(kProtocolVersion);
  request.set_client_name(options.client_name);
  v1::JoinReply reply;
  for (;;) {
    grpc::ClientContext context;
    context.set_deadline(std::min(Clock::now() + kCallDeadline, give_up + kCallDeadline));
    const grpc::Status status = connection->stub->Join(&context, request, &reply);
    if (status.ok()) break;
    // The server is there but its scene is not, yet.
    if (status.error_code() != grpc::StatusCode::UNAVAILABLE || Clock::now() + kRetryAfter > give_up) {
      return from_status(status, address);
    }
    std::this_thread::sleep_for(kRetryAfter);
  }
  connection->scene.session_id = reply.session_id();
  connection->scene.rate_hz = reply.rate_hz();
  connection->scene.tick = reply.tick();
  connection->scene.ball_speed_m_s = reply.ball_speed_m_s();
  for (const v1::ObjectDescription& description : reply.objects()) {
    auto object = read_description(description);
    if (!object) return Error{object.error().code, address + ": " + object.error().message};
    connection->scene.objects.push_back(std::move(*object));
  }
  return std::unique_ptr<SessionClient>(new SessionClient(std::move(connection)));
}

const JoinedScene& SessionClient::scene() const { return connection_->scene; }

Result<void> SessionClient::fetch_asset(const std::string& hash, uint64_t asset_bytes, uint64_t offset,
                                        const TakeChunk& take) {
  v1::FetchAssetRequest request;
  request.set_asset_hash(hash);
  request.set_offset(offset);
  grpc::ClientContext context;
  context.set_deadline(Clock::now() + kFetchPatience +
                       std::chrono::seconds(asset_bytes / kSlowestFetch_bytes_s));
  const auto reader = connection_->asset_stub->FetchAsset(&context, request);
  v1::AssetChunk chunk;
  while (reader->Read(&chunk)) {
    if (auto taken = take(chunk.offset(), chunk.total_bytes(), std::as_bytes(std::span(chunk.data())));
        !taken) {
      context.TryCancel();
      (void)reader->Finish();
      return taken;
    }
  }
  const grpc::Status status = reader->Finish();
  if (!status.ok()) return from_status(status, connection_->address + ": asset " + hash.substr(0, 12));
  return {};
}

Result<v1::AnalyzeObjectReply> SessionClient::analyze(const std::string& object) {
  v1::AnalyzeObjectRequest request;
  request.set_object(object);
  v1::AnalyzeObjectReply reply;
  grpc::ClientContext context;
  context.set_deadline(Clock::now() + kCallDeadline);
  const grpc::Status status = connection_->stub->AnalyzeObject(&context, request, &reply);
  if (!status.ok()) return from_status(status, connection_->address);
  return reply;
}

void SessionClient::start(StreamSink& sink) {
  Connection& connection = *connection_;
  LIVEGS_ASSERT(connection.sink == nullptr);
  connection.sink = &sink;
  connection.stream = connection.stub->Stream(&connection.context);
  connection.writer = std::thread([&connection] {
    pthread_setname_np(pthread_self(), "stream writer");
    connection.write();
  });
  connection.reader = std::thread([&connection] {
    pthread_setname_np(pthread_self(), "stream reader");
    connection.read();
  });
}

void SessionClient::send(const InputSample& sample) {
  {
    std::lock_guard lock(connection_->mutex);
    connection_->samples.push_back(sample);
    if (connection_->samples.size() > kSamplesPerMessage) connection_->samples.pop_front();
    connection_->samples_new = true;
  }
  connection_->changed.notify_one();
}

void SessionClient::Connection::write() {
  v1::ClientMessage message;
  message.set_session_id(scene.session_id);  // in the first message only
  for (bool first = true;; first = false) {
    {
      std::unique_lock lock(mutex);
      if (!first)
        changed.wait_for(lock, kSignOfLife, [&] { return stopping || samples_new || acknowledgement_new; });
      if (stopping) break;
      samples_new = acknowledgement_new = false;
      message.set_acknowledged_tick(acknowledged_tick);
      message.set_key_frame_wanted(std::exchange(key_frame_wanted, false));
      for (const InputSample& sample : samples) write_input(sample, *message.add_inputs());
    }
    message.set_sent_ns(now_ns());
    if (!stream->Write(message)) break;
    message.Clear();
  }
  stream->WritesDone();
}

void SessionClient::Connection::read() {
  v1::ServerMessage message;
  Result<void> result;
  while (stream->Read(&message)) {
    result = take(message, now_ns());
    if (!result) {
      context.TryCancel();
      break;
    }
  }
  const grpc::Status status = stream->Finish();
  std::lock_guard lock(mutex);
  if (!result)
    outcome = result.error();
  else if (!status.ok() && !stopping && !drained)
    outcome = from_status(status, "the server at " + address + " went away");
  stopping = true;
  ended = true;
  changed.notify_all();
}

Result<void> SessionClient::Connection::take(v1::ServerMessage& message, int64_t received_ns) {
  for (const v1::SessionEvent& event : message.events()) {
    switch (event.kind_case()) {
      case v1::SessionEvent::kObjectAdded: {
        auto object = read_description(event.object_added());
        if (!object) return Error{object.error().code, address + ": " + object.error().message};
        sink->on_object_added(std::move(*object));
        break;
      }
      case v1::SessionEvent::kObjectChanged: {
        auto object = read_description(event.object_changed());
        if (!object) return Error{object.error().code, address + ": " + object.error().message};
        sink->on_object_changed(std::move(*object));
        break;
      }
      case v1::SessionEvent::kObjectRemoved:
        sink->on_object_removed(event.object_removed().object_id());
        break;
      case v1::SessionEvent::kDraining:
        drained = true;
        sink->on_draining(event.draining());
        break;
      case v1::SessionEvent::KIND_NOT_SET:
        break;  // an event of a later version, which this one can do without
    }
  }
  if (message.frame().empty()) return {};
  ReceivedFrame frame;
  frame.tick = message.tick();
  frame.received_ns = received_ns;
  frame.stepped_ns = message.stepped_ns();
  frame.sent_ns = message.sent_ns();
  frame.echoed_ns = message.echoed_ns();
  frame.step_ms = message.step_ms();
  frame.input_sequence = message.input_sequence();
  for (const v1::HandState& hand : message.hands()) {
    frame.hands.push_back(
        {hand.hand(), hand.object_id(), vector_of(hand.point_m()), vector_of(hand.force_n()), hand.grabbed(),
         hand.contact_impulse_n_s()});
  }
  const uint64_t tick = frame.tick;
  const bool waits = frames.needs_key_frame();
  auto drivers = frames.read(std::as_bytes(std::span(message.frame())));
  if (drivers) {
    frame.bytes = message.frame().size();
    frame.drivers = std::make_shared<const DriverFrame>(std::move(*drivers));
    sink->on_frame(std::move(frame));
  } else {
    log_debug("frame %llu: %s", static_cast<unsigned long long>(tick), drivers.error().message.c_str());
  }
  {
    std::lock_guard lock(mutex);
    key_frame_wanted = key_frame_wanted || (!drivers && !waits);
    acknowledged_tick = tick;
    acknowledgement_new = true;
  }
  changed.notify_one();
  return {};
}

Result<void> SessionClient::stop() {
  Connection& connection = *connection_;
  if (connection.sink == nullptr || connection.stopped) return connection.outcome;
  {
    std::unique_lock lock(connection.mutex);
    connection.stopping = true;
    connection.changed.notify_all();
    // The server answers a half close by ending the stream; one that does not is left.
    if (!connection.changed.wait_for(lock, std::chrono::seconds(1),
                                     [&] { return connection.ended.load(); })) {
      connection.context.TryCancel();
    }
  }
  connection.writer.join();
  connection.reader.join();
  connection.stopped = true;
  return connection.outcome;
}

bool SessionClient::ended() const { return connection_->ended; }

}  // namespace livegs
