// SPDX-License-Identifier: Apache-2.0
#include "stream/session/session_client.h"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <functional>
#include <future>
#include <limits>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "core/assert.h"
#include "core/clock.h"
#include "core/log.h"
#include "core/text/format_text.h"
#include "livegs/v1/session.grpc.pb.h"
#include "store/object_store.h"
#include "stream/channel/retry_schedule.h"
#include "stream/channel/rpc_channel.h"
#include "stream/session/session_stream.h"
#include "trust/host_port.h"
#include "trust/server_probe.h"
#include "wire/call_metadata.h"
#include "wire/frame_codec.h"

namespace livegs {
namespace {

using Clock = std::chrono::system_clock;  // gRPC's deadlines

constexpr std::chrono::seconds kCallDeadline{10};
// Deadline for resuming a session; short, so that a lost reply is retried soon.
constexpr std::chrono::seconds kRejoinDeadline{2};
// A store that fails for longer is left for the server.
constexpr StoreTimes kStoreTimes{.patience_s = 5, .stall_s = 3};
constexpr int64_t kRetryInterval_ns = 100'000'000;  // while the server builds its scene
// A call for an asset that takes longer is repeated from the last byte if data of any asset arrived.
// Otherwise the fetch fails and the received data is kept for the next attempt.
constexpr std::chrono::seconds kFetchTimeout{10};
constexpr uint64_t kMinFetchRate_bytes_s = 1 << 20;
// Time without a connection before the first probe for TLS, so that a server that answers is not probed; and
// the pause between probes.
constexpr int64_t kTlsSearchDelay_ns = 200'000'000, kTlsSearchInterval_ns = 1'000'000'000;
// Consecutive streams of kernels without a frame before the session fails; the timeout doubles each time.
constexpr int kMaxSilentStreams = 3;
// Upper bound of the pause between streams that deliver no frame.
constexpr int64_t kMaxRetryPause_ns = 2'000'000'000;

int64_t after(int64_t moment_ns, double duration_s) {
  const double most_s = seconds_from_ns(std::numeric_limits<int64_t>::max() - moment_ns);
  if (!(duration_s < most_s / 2)) return std::numeric_limits<int64_t>::max();
  return moment_ns + static_cast<int64_t>(duration_s * 1e9);
}

bool connection_broke(const grpc::Status& status) {
  switch (status.error_code()) {
    case grpc::StatusCode::UNAVAILABLE:
    case grpc::StatusCode::CANCELLED:
    case grpc::StatusCode::INTERNAL:
    case grpc::StatusCode::UNKNOWN:
      return true;
    default:
      return false;
  }
}

// Finds out, while a client without TLS finds no server, whether one answers there with TLS.
class TlsSearch {
 public:
  explicit TlsSearch(std::string address) : address_(std::move(address)) {}
  bool found() {
    if (!found_ && probe_.valid() && probe_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
      found_ = probe_.get();
      next_ns_ = now_ns() + kTlsSearchInterval_ns;
    }
    if (!found_ && !probe_.valid() && now_ns() >= next_ns_)
      probe_ = std::async(std::launch::async, [this] { return speaks_tls(address_); });
    return found_;
  }

 private:
  const std::string address_;
  int64_t next_ns_ = now_ns() + kTlsSearchDelay_ns;
  bool found_ = false;
  std::future<bool> probe_;  // last: it uses the address
};

}  // namespace

struct SessionClient::Connection {
  std::shared_ptr<ServerPlace> place;
  ConnectOptions options;
  JoinedScene scene;
  KnownObjects objects;  // accessed only by the session thread once it runs, like the next four
  ClockOffset clock;
  std::string session_id, server_instance;
  double rate_hz = 0;
  v1::JoinRequest::Encoding encoding = v1::JoinRequest::DRIVERS;
  int silent_streams = 0;  // consecutive, without a frame
  StreamSink* sink = nullptr;
  std::thread thread;
  std::atomic<bool> ended{false};
  std::atomic<int64_t> fetched_ns{0};  // when the last byte of any asset arrived
  bool joined_thread = false;          // accessed by the caller of stop() only

  std::mutex mutex;  // guards everything below
  std::condition_variable changed;
  std::shared_ptr<v1::LiveGs::Stub> stub, asset_stub;
  std::string asset_session_id;           // of the asset_stub; the session whose bandwidth cap fetches share
  std::shared_ptr<SessionStream> stream;  // null while disconnected; shared with threads that send
  std::optional<ViewCone> view;           // the last view set
  std::shared_ptr<ObjectStore> store;     // null: none, or it failed
  std::set<std::string, std::less<>> stored;  // hashes of the assets in it
  std::stop_source fetches_end;
  bool stopping = false, given_up = false;
  std::set<grpc::ClientContext*> calls;  // cancelled on give-up
  Result<void> outcome;

  class Call;
  bool wait(int64_t duration_ns);
  void give_up();
  std::shared_ptr<v1::LiveGs::Stub> stub_now() {
    std::lock_guard lock(mutex);
    return stub;
  }

  void take_store(const v1::JoinReply& reply);
  void run();
  Result<v1::JoinReply> join(int64_t give_up_ns);
  Result<void> move_to(const v1::NextServer& next);
  Result<void> resume(const SessionStream::Outcome& lost);
  int64_t first_silence_ns() const;
  SessionStream::Outcome stream_once();

  // Last, so that it is destroyed before the members it uses.
  std::optional<std::stop_callback<std::function<void()>>> on_stop;
};

// The context of a call, cancelled when the connection is given up.
class SessionClient::Connection::Call {
 public:
  explicit Call(Connection& connection) : connection_(connection) {
    std::lock_guard lock(connection_.mutex);
    connection_.calls.insert(&context);
    if (connection_.given_up) context.TryCancel();
  }
  ~Call() {
    std::lock_guard lock(connection_.mutex);
    connection_.calls.erase(&context);
  }
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;
  grpc::ClientContext context;

 private:
  Connection& connection_;
};

void SessionClient::Connection::give_up() {
  {
    std::lock_guard lock(mutex);
    stopping = given_up = true;
    fetches_end.request_stop();
    if (stream) stream->stop();
    for (grpc::ClientContext* call : calls) call->TryCancel();
  }
  changed.notify_all();
}

// Returns whether the session must end.
bool SessionClient::Connection::wait(int64_t duration_ns) {
  std::unique_lock lock(mutex);
  return changed.wait_for(lock, std::chrono::nanoseconds(duration_ns), [&] { return stopping; });
}

// Precondition: the mutex is held.
void SessionClient::Connection::take_store(const v1::JoinReply& reply) {
  store.reset();
  stored.clear();
  for (const v1::StoredAsset& asset : reply.stored_assets()) stored.insert(asset.hash());
  const std::string& url = reply.asset_store();
  if (!url.starts_with("http://") && !url.starts_with("https://")) return;
  auto opened = ObjectStore::open(url, kStoreTimes);
  if (opened)
    store = *std::move(opened);
  else
    log_warn("assets: fetching them from the server (%s)", opened.error().message.c_str());
}

// Connects and joins, with the session's id if there is one. Unavailable without a message if no server
// answered.
Result<v1::JoinReply> SessionClient::Connection::join(int64_t give_up_ns) {
  v1::JoinRequest request;
  request.set_protocol_version(kProtocolVersion);
  request.set_client_name(options.client_name);
  request.set_resumed_session_id(session_id);
  request.set_max_mbit_s(options.max_mbit_s);
  request.set_rate_hz(options.rate_hz);
  request.set_position_bits(options.position_bits);
  request.set_encoding(options.encoding);
  request.set_starts_run(options.starts_run);
  const auto [address, access, moves] = place->now();
  grpc::Status status;
  std::chrono::seconds deadline = session_id.empty() ? kCallDeadline : kRejoinDeadline;
  for (;;) {
    TlsSearch tls(address);
    const bool searches = session_id.empty() && !access;
    const auto channel = connect_channel(address, access.get(), give_up_ns, [&](int64_t duration_ns) {
      return wait(duration_ns) || (searches && tls.found());
    });
    if (!channel) {
      if (searches && tls.found()) return requires_tls(address);
      if (access) {
        if (auto refused = access->refused(); !refused) return refused.error();
      }
      return Error{ErrorCode::Unavailable, ""};
    }
    auto connected = std::shared_ptr<v1::LiveGs::Stub>(v1::LiveGs::NewStub(channel));
    v1::JoinReply reply;
    do {
      Call call(*this);
      call.context.set_deadline(Clock::now() + deadline);
      status = connected->Join(&call.context, request, &reply);
      if (status.ok()) {
        std::lock_guard lock(mutex);
        stub = std::move(connected);
        asset_stub = v1::LiveGs::NewStub(make_channel(address, access.get()));
        asset_session_id = reply.session_id();
        take_store(reply);
        return reply;
      }
      const bool full = status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED;
      if (!may_pass(status) || (full && session_id.empty())) return error_from(status, address);
      if (now_ns() + kRetryInterval_ns > give_up_ns || wait(kRetryInterval_ns))
        return error_from(status, address);
      // The server runs but its scene is not ready.
    } while (status.error_code() == grpc::StatusCode::UNAVAILABLE &&
             channel->GetState(false) == GRPC_CHANNEL_READY);
    deadline = std::min(2 * deadline, kCallDeadline);
  }
}

SessionClient::SessionClient(std::unique_ptr<Connection> connection) : connection_(std::move(connection)) {}

SessionClient::~SessionClient() { (void)stop(); }

Result<std::unique_ptr<SessionClient>> SessionClient::join(const std::string& address,
                                                           const ConnectOptions& options) {
  auto connection = std::make_unique<Connection>();
  connection->place = std::make_shared<ServerPlace>(address, options.access);
  connection->options = options;
  connection->on_stop.emplace(options.stop, [&joining = *connection] { joining.give_up(); });
  const auto reply = connection->join(after(now_ns(), options.timeout_s));
  if (!reply) {
    if (!reply.error().message.empty()) return reply.error();
    return Error{
        ErrorCode::Unavailable,
        address + ": no server answers" + (options.access ? " over TLS (paired)" : "") +
            format_text(" within %.1f s; start one with livegs-server SCENE, or %s", options.timeout_s,
                        options.access ? "remove the pairing with --unpair if it no longer uses TLS"
                                       : "pair first with --pair CODE if it requires TLS")};
  }
  if (options.access) {
    if (auto remembered = options.access->remember(); !remembered) return remembered.error();
  }
  if (reply->view_only())
    log_warn(
        "%s: the token has scope view, so input is ignored; give one of scope interact with --token-file",
        address.c_str());
  connection->session_id = connection->scene.session_id = reply->session_id();
  connection->server_instance = reply->server_instance();
  connection->scene.rate_hz = connection->rate_hz = reply->rate_hz();
  connection->encoding = reply->encoding();
  connection->scene.stream_rate_hz = reply->stream_rate_hz();
  connection->scene.tick = reply->tick();
  connection->scene.ball_speed_m_s = reply->ball_speed_m_s();
  for (const v1::ObjectDescription& description : reply->objects()) {
    auto object = connection->objects.take(description);
    if (!object) return Error{object.error().code, address + ": " + object.error().message};
    connection->scene.objects.push_back(std::move(*object));
  }
  return std::unique_ptr<SessionClient>(new SessionClient(std::move(connection)));
}

const JoinedScene& SessionClient::scene() const { return connection_->scene; }
std::shared_ptr<const ServerPlace> SessionClient::place() const { return connection_->place; }

Result<void> SessionClient::fetch_asset(const std::string& hash, uint64_t asset_bytes, uint64_t offset,
                                        const TakeChunk& take, const std::string& base_hash) {
  Connection& connection = *connection_;
  const std::string name = "asset " + hash.substr(0, 12);
  const int64_t begun_ns = now_ns();
  for (;;) {
    const int64_t called_ns = now_ns();
    std::shared_ptr<v1::LiveGs::Stub> stub;
    std::string session_id;
    {
      std::lock_guard lock(connection.mutex);
      stub = connection.asset_stub;
      session_id = connection.asset_session_id;
    }
    v1::FetchAssetRequest request;
    request.set_asset_hash(hash);
    request.set_offset(offset);
    request.set_base_hash(base_hash);
    Connection::Call call(connection);
    call.context.AddMetadata(kSessionMetadata, session_id);
    call.context.set_deadline(
        Clock::now() + kFetchTimeout +
        std::chrono::seconds((asset_bytes - std::min(offset, asset_bytes)) / kMinFetchRate_bytes_s));
    const auto reader = stub->FetchAsset(&call.context, request);
    v1::AssetChunk chunk;
    while (reader->Read(&chunk)) {
      if (auto taken = take(chunk.offset(), chunk.total_bytes(), std::as_bytes(std::span(chunk.data())));
          !taken) {
        call.context.TryCancel();
        (void)reader->Finish();
        return taken;
      }
      offset = chunk.offset() + chunk.data().size();
      connection.fetched_ns = now_ns();
    }
    const grpc::Status status = reader->Finish();
    if (status.ok()) return {};
    // Fetches of a client wait for each other on a slow link, so a byte of any of them is progress.
    const int64_t progress_ns = std::max(begun_ns, connection.fetched_ns.load());
    const bool over = now_ns() >= after(progress_ns, connection.options.reconnect_s);
    const bool slow =
        status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED && connection.fetched_ns > called_ns;
    if ((!connection_broke(status) && !slow) || over || connection.wait(kRetryPause_ns))
      return error_from(status, connection.place->now().address + ": " + name);
    log_debug("%s: %s; resuming at byte %llu", name.c_str(), status.error_message().c_str(),
              static_cast<unsigned long long>(offset));
    std::lock_guard lock(connection.mutex);
    if (connection.asset_stub != stub) continue;
    const auto place = connection.place->now();
    connection.asset_stub = v1::LiveGs::NewStub(make_channel(place.address, place.access.get()));
  }
}

AssetCache::Fetch SessionClient::stored_asset(const std::string& hash, uint64_t asset_bytes) {
  Connection& connection = *connection_;
  std::shared_ptr<ObjectStore> store;
  std::stop_token end;
  {
    std::lock_guard lock(connection.mutex);
    if (!connection.stored.contains(hash)) return nullptr;
    store = connection.store;
    end = connection.fetches_end.get_token();
  }
  if (!store) return nullptr;
  return [&connection, store, end, hash, asset_bytes](uint64_t from, const TakeChunk& take) -> Result<void> {
    auto done = store->read(
        hash, from,
        [&](uint64_t offset, std::span<const std::byte> bytes) { return take(offset, asset_bytes, bytes); },
        end);
    const bool failed = !done && (done.error().code == ErrorCode::Unavailable ||
                                  done.error().code == ErrorCode::PermissionDenied);
    if (failed) {  // for the other assets too
      std::lock_guard lock(connection.mutex);
      if (connection.store == store) connection.store.reset();
    }
    return done;
  };
}

Result<v1::AnalyzeObjectReply> SessionClient::analyze(const std::string& object) {
  v1::AnalyzeObjectRequest request;
  request.set_object(object);
  v1::AnalyzeObjectReply reply;
  grpc::ClientContext context;
  context.set_deadline(Clock::now() + kCallDeadline);
  const grpc::Status status = connection_->stub_now()->AnalyzeObject(&context, request, &reply);
  if (!status.ok()) return error_from(status, connection_->place->now().address);
  return reply;
}

void SessionClient::start(StreamSink& sink) {
  Connection& connection = *connection_;
  LIVEGS_ASSERT(connection.sink == nullptr);
  connection.sink = &sink;
  connection.thread = std::thread([&connection] {
    pthread_setname_np(pthread_self(), "session");
    connection.run();
  });
}

void SessionClient::send(const InputSample& sample) {
  std::shared_ptr<SessionStream> stream;
  {
    std::lock_guard lock(connection_->mutex);
    stream = connection_->stream;
  }
  if (stream) stream->send(sample);
}

void SessionClient::set_view(const ViewCone& view) {
  std::shared_ptr<SessionStream> stream;
  {
    std::lock_guard lock(connection_->mutex);
    connection_->view = view;
    stream = connection_->stream;
  }
  if (stream) stream->set_view(view);
}

int64_t SessionClient::Connection::first_silence_ns() const {
  const bool kernels = FrameReader::is_kernel_encoding(encoding);
  const double first_s = std::ldexp(kernels ? options.first_kernels_s : seconds_from_ns(kServerTimeout_ns),
                                    std::min(silent_streams, 8));
  return std::min(after(0, first_s), kMaxSilence_ns);
}

SessionStream::Outcome SessionClient::Connection::stream_once() {
  const auto used = stub_now();
  const auto opened = std::make_shared<SessionStream>(
      *used, session_id, rate_hz, encoding, first_silence_ns(), SessionStream::Ends{*sink, clock, objects});
  {
    std::lock_guard lock(mutex);
    if (stopping) opened->stop();
    if (view) opened->set_view(*view);
    stream = opened;
  }
  SessionStream::Outcome done = opened->run();
  std::lock_guard lock(mutex);
  stream.reset();
  return done;
}

void SessionClient::Connection::run() {
  const auto end = [&](Result<void> result) {
    std::lock_guard lock(mutex);
    outcome = std::move(result);
    ended = true;
  };
  int64_t fruitless_pause_ns = 0;
  for (;;) {
    const SessionStream::Outcome done = stream_once();
    const std::string address = place->now().address;
    if (done.error) return end(Error{done.error->code, address + ": " + done.error->message});
    if (wait(0) || (done.drained && !options.reconnect_after_drain)) return end({});
    silent_streams = done.silent && done.frames == 0 ? silent_streams + 1 : 0;
    const bool kernels = FrameReader::is_kernel_encoding(encoding);
    if (kernels && silent_streams >= kMaxSilentStreams) {
      return end(
          Error{ErrorCode::Unavailable,
                address + format_text(": no complete frame of kernels in %d attempts, the link is too slow; "
                                      "use --encoding drivers",
                                      silent_streams)});
    }
    if (!may_pass(done.status)) return end(error_from(done.status, address));
    if (done.next_server) {
      if (auto moved = move_to(*done.next_server); !moved) return end(std::move(moved));
      log_warn("%s: %s; continuing at %s", address.c_str(), done.reason.c_str(),
               done.next_server->address().c_str());
    } else {
      log_warn("%s: %s; reconnecting", address.c_str(), done.reason.c_str());
    }
    sink->on_lost(done.reason);
    fruitless_pause_ns =
        done.frames > 0 ? 0 : std::clamp(2 * fruitless_pause_ns, kRetryPause_ns, kMaxRetryPause_ns);
    if (fruitless_pause_ns > 0 && wait(fruitless_pause_ns)) return end({});
    if (auto resumed = resume(done); !resumed) return wait(0) ? end({}) : end(std::move(resumed));
  }
}

// The token is sent only to a server with the certificate of this one, or on this machine.
Result<void> SessionClient::Connection::move_to(const v1::NextServer& next) {
  const ServerPlace::Place from = place->now();
  const auto parsed = parse_host_port(next.address());
  if (!parsed) return invalid_data("server " + from.address + ": next server " + parsed.error().message);
  if (!from.access && !parsed->loopback)
    return invalid_data("server " + from.address + ": next server " + next.address() +
                        " needs TLS, which this session does not use; pair with that server by --pair CODE");
  place->move_to(next.address(), from.access ? from.access->at(next.address(), next.token()) : nullptr);
  session_id.clear();  // known to the server before only
  return {};
}

Result<void> SessionClient::Connection::resume(const SessionStream::Outcome& lost) {
  const std::string address = place->now().address;
  const auto reply = join(after(lost.last_message_ns, options.reconnect_s));
  if (!reply) {
    if (!reply.error().message.empty() && reply.error().code != ErrorCode::Unavailable) return reply.error();
    return Error{
        ErrorCode::Unavailable,
        "server " + address + ": connection lost: " + lost.reason +
            format_text(
                " and not restored within %.1f s; check the server, or wait longer with --reconnect SECONDS",
                options.reconnect_s)};
  }
  ResumedSession resumed;
  resumed.same_server = reply->server_instance() == server_instance;
  resumed.outage_s = seconds_from_ns(now_ns() - lost.last_message_ns);
  session_id = reply->session_id();
  server_instance = reply->server_instance();
  rate_hz = reply->rate_hz();
  encoding = reply->encoding();
  if (!resumed.same_server) clock = ClockOffset();
  std::vector<const v1::ObjectDescription*> descriptions;
  for (const v1::ObjectDescription& description : reply->objects()) descriptions.push_back(&description);
  auto difference = objects.replace(descriptions);
  if (!difference) return Error{difference.error().code, address + ": " + difference.error().message};
  log_info("%s: reconnected after %.1f s to %s; %zu objects added, %zu changed, %zu removed", address.c_str(),
           resumed.outage_s, resumed.same_server ? "the same server" : "a new server",
           difference->added.size(), difference->changed.size(), difference->removed.size());
  sink->on_resumed(resumed);
  for (const uint32_t id : difference->removed) sink->on_object_removed(id);
  for (StreamedObject& object : difference->added) sink->on_object_added(std::move(object));
  for (StreamedObject& object : difference->changed) {
    // Revisions count the fractures of one simulation only.
    resumed.same_server ? sink->on_object_changed(std::move(object))
                        : sink->on_object_added(std::move(object));
  }
  return {};
}

Result<void> SessionClient::stop() {
  Connection& connection = *connection_;
  if (connection.joined_thread || !connection.thread.joinable()) return connection.outcome;
  {
    std::lock_guard lock(connection.mutex);
    connection.stopping = true;
    if (connection.stream) connection.stream->stop();
  }
  connection.changed.notify_all();
  connection.thread.join();
  connection.joined_thread = true;
  return connection.outcome;
}

bool SessionClient::ended() const { return connection_->ended; }

}  // namespace livegs
