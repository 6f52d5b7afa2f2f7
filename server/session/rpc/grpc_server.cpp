// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/rpc/grpc_server.h"

#include <grpc/support/log.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <chrono>
#include <mutex>

#include "core/clock.h"
#include "core/log.h"
#include "scene/build/fragile_object.h"
#include "session/access/browser_link.h"
#include "session/access/call_authoriser.h"
#include "session/access/connection_limiter.h"
#include "session/access/server_security.h"
#include "session/assets/describe_object.h"
#include "session/recording/session_recorder.h"
#include "session/rpc/admin_service.h"
#include "session/rpc/grpc_service.h"
#include "session/rpc/spectator_service.h"
#include "session/rpc/web_calls.h"
#include "trust/host_port.h"
#include "web/web_server.h"

namespace livegs {
namespace {

constexpr const char* kServiceName = "livegs.v1.LiveGs";

// Client messages are small; a part of an uploaded file is the largest.
constexpr int kMaxRequestBytes = 64 << 10;
// Between two lines about assets that are encoded at the start.
constexpr int64_t kProgressEvery_ns = 1'000'000'000;
constexpr int kMaxStreamsPerConnection = 16;
static_assert(3 * kMaxSessions < kMaxConnections,
              "a client has three connections; the rest is for unary calls");
// Time for clients on a busy machine to receive the reason. Only a client that does not read uses all of it.
constexpr std::chrono::seconds kShutdownTimeout{3};

// Enables health checks and reflection for the process, before the first server is built. Redirects gRPC's
// own log to the debug log.
void set_up_process() {
  static std::once_flag once;
  std::call_once(once, [] {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    gpr_set_log_function([](gpr_log_func_args* line) { log_debug("grpc: %s", line->message); });
  });
}

void limit(grpc::ServerBuilder& builder) {
  builder.SetMaxReceiveMessageSize(kMaxRequestBytes);
  builder.SetMaxSendMessageSize(-1);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxStreamsPerConnection);
  // Closes connections without a handshake after 3 s, and idle ones after 180 s. The latter exceeds the two
  // minutes that a client may take from Join to Stream (kJoinTimeout_ns).
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, 3000);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, 180'000);
  // Detects a lost peer within four seconds. Sessions have their own, shorter timeouts.
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 1000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 3000);
  // Pings only during calls: a client that loads assets between Join and Stream does not answer pings.
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 0);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 500);
}

// Without TLS no authoriser is installed: gRPC 1.51 aborts if insecure credentials have one.
std::shared_ptr<grpc::ServerCredentials> credentials(ServerSecurity* security) {
  if (!security) return grpc::InsecureServerCredentials();
  grpc::SslServerCredentialsOptions options(GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE);
  options.pem_key_cert_pairs.push_back({security->key_pem(), security->certificate_pem()});
  auto made = grpc::SslServerCredentials(options);
  made->SetAuthMetadataProcessor(std::make_shared<CallAuthoriser>(security->tokens()));
  return made;
}

}  // namespace

Result<void> check_listen_address(const std::string& address, bool secure) {
  const auto parsed = parse_host_port(address);
  if (!parsed) return invalid_argument("--listen " + parsed.error().message);
  if (parsed->loopback || secure) return {};
  return invalid_argument(
      "--listen " + address +
      ": needs TLS and tokens, since it is not a local address; remove --tls off, or listen on "
      "127.0.0.1, localhost or [::1]");
}

struct GrpcServer::Parts {
  explicit Parts(ServerSecurity* given)
      : security(given),
        service(table, assets, security ? &security->tokens() : nullptr),
        admin(table, security, recorder) {
    proposals->table = &table;
    if (security)
      table.check_authorizations_with(
          [given](const Authorization& authorization) { return given->tokens().check_still(authorization); });
    publisher = std::make_unique<FramePublisher>(table, assets);  // starts a thread that uses the table
  }
  ServerSecurity* const security;
  std::string host;  // of the address
  SessionTable table;
  AssetStore assets;
  SessionRecorder recorder{assets};
  GrpcService service;
  SpectatorService spectators{table};
  AdminService admin;
  std::unique_ptr<grpc::Server> server;
  std::unique_ptr<WebCalls> web_calls;
  std::unique_ptr<WebServer> web;
  std::unique_ptr<ConnectionLimiter> door;
  std::unique_ptr<ZmqPublisher> zmq_publisher;
  std::unique_ptr<FramePublisher> publisher;
  // Target of the proposals of an analysis. Shared, since either side may end first.
  struct Proposals {
    std::mutex mutex;  // guards table
    SessionTable* table = nullptr;
  };
  std::shared_ptr<Proposals> proposals = std::make_shared<Proposals>();
  bool shut_down = false;
};

GrpcServer::GrpcServer(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Result<std::unique_ptr<GrpcServer>> GrpcServer::listen(const std::string& address, ServerSecurity* security) {
  if (auto checked = check_listen_address(address, security != nullptr); !checked) return checked.error();
  set_up_process();
  auto parts = std::make_unique<Parts>(security);
  grpc::ServerBuilder builder;
  const auto where = parse_host_port(address);
  auto door = ConnectionLimiter::listen(where->host, where->port);
  if (!door) return door.error();
  auto acceptor = builder.experimental().AddExternalConnectionAcceptor(
      grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD, credentials(security));
  builder.RegisterService(&parts->service);
  builder.RegisterService(&parts->spectators);
  builder.RegisterService(&parts->admin);
  limit(builder);
  parts->server = builder.BuildAndStart();
  if (!parts->server) return Error{ErrorCode::Internal, "gRPC: could not create a server for " + address};
  parts->server->GetHealthCheckService()->SetServingStatus(false);
  parts->server->GetHealthCheckService()->SetServingStatus(kServiceName, false);
  parts->door = std::move(*door);
  parts->host = where->host;
  parts->web_calls =
      std::make_unique<WebCalls>(*parts->server, parts->table, parts->assets, parts->service, security);
  auto web = WebServer::start(*parts->web_calls, security ? security->certificate_pem() : "",
                              security ? security->key_pem() : "");
  if (!web) return web.error();
  parts->web = std::move(*web);
  parts->door->open(std::move(acceptor),
                    [web = parts->web.get()](int socket, bool tls) { web->take(socket, tls); });
  if (security) security->set_port(parts->door->port());
  std::unique_ptr<GrpcServer> server(new GrpcServer(std::move(parts)));
  server->parts_->admin.set_linker([made = server.get()] { return made->new_browser_link(); });
  return server;
}

GrpcServer::~GrpcServer() { shut_down("the server is closing"); }

void GrpcServer::allow_origins(std::vector<std::string> origins) {
  parts_->web->allow_origins(std::move(origins));
}

void GrpcServer::allow_store(const std::string& url) {
  parts_->web->connect_to(url.substr(0, url.find('/', url.find("://") + 3)));
}

void GrpcServer::use_store(ClientStore store) { parts_->service.set_store(std::move(store)); }

uint64_t GrpcServer::asset_bytes_sent() const { return parts_->assets.sent_bytes(); }

int GrpcServer::port() const { return parts_->door->port(); }

v1::BrowserLink GrpcServer::new_browser_link() {
  v1::BrowserLink link;
  link.set_code(parts_->web_calls->new_one_time_code());
  if (!link.code().empty()) link.set_valid_s(seconds_from_ns(kOneTimeCodeLifetime_ns));
  if (parts_->security) link.set_fingerprint(parts_->security->fingerprint());
  for (std::string& url : browser_links(parts_->host, port(), parts_->security != nullptr, link.code()))
    link.add_urls(std::move(url));
  return link;
}

TickSink& GrpcServer::ticks() { return *parts_->publisher; }

void GrpcServer::open(const std::string& scene_name, double rate_hz,
                      std::span<const SceneObject* const> objects, InputSink& inputs) {
  std::vector<SessionTable::Object> described;
  int64_t logged_ns = now_ns();
  for (const SceneObject* object : objects) {
    if (now_ns() - logged_ns > kProgressEvery_ns) {
      logged_ns = now_ns();
      log_info("assets: %zu of %zu objects encoded", described.size(), objects.size());
    }
    if (object->broken) (void)parts_->assets.add(object->broken->asset, object->asset);
    described.push_back(
        std::make_shared<const v1::ObjectDescription>(describe_object(*object, parts_->assets)));
  }
  parts_->publisher->begin_with(objects);
  parts_->table.open(scene_name, rate_hz, std::move(described), inputs);
  parts_->server->GetHealthCheckService()->SetServingStatus(true);
  parts_->server->GetHealthCheckService()->SetServingStatus(kServiceName, true);
}

void GrpcServer::open(const Scene& scene, InputSink& inputs) {
  // Otherwise the first ball would be visible only after its asset is encoded.
  (void)parts_->assets.add(Scene::ball_asset());
  std::vector<const SceneObject*> objects;
  for (const SceneObject& object : scene.objects()) objects.push_back(&object);
  open(scene.name(), scene.world().settings().rate_hz, objects, inputs);
}

void GrpcServer::admit(size_t clients) { parts_->table.set_max_sessions(clients); }

void GrpcServer::cap_clients(double mbit_s) { parts_->service.set_cap(mbit_s * 1e6 / 8); }

Result<std::string> GrpcServer::publish(const std::string& address) {
  auto bound = ZmqPublisher::bind(address);
  if (!bound) return bound.error();
  parts_->zmq_publisher = std::move(*bound);
  parts_->publisher->publish_to(*parts_->zmq_publisher);
  return parts_->zmq_publisher->address();
}

SessionRecorder& GrpcServer::recorder() { return parts_->recorder; }

void GrpcServer::open_drain(std::function<void(const std::string&)> drain) {
  parts_->admin.set_drain(std::move(drain));
}

void GrpcServer::open_run(RunControl& run) { parts_->service.set_run(&run); }

void GrpcServer::open_author(AuthorControl& author) { parts_->service.set_author(&author); }

bool GrpcServer::starter_joined() const { return parts_->service.starter_joined(); }

void GrpcServer::encode_ahead(const Scene& scene) {
  for (const SceneObject& object : scene.objects()) {
    (void)parts_->assets.add(object.asset, parts_->assets.described(object.name));
    if (object.broken) (void)parts_->assets.add(object.broken->asset, object.asset);
  }
}

void GrpcServer::open_analysis(AnalysisControl& analysis) {
  analysis.watch_proposals(
      [proposals = parts_->proposals](const std::string& object, const v1::PhysicsFile* proposal) {
        std::lock_guard lock(proposals->mutex);
        if (proposals->table) proposals->table->propose(object, proposal);
      });
  parts_->service.set_analysis(&analysis);
}

void GrpcServer::shut_down(const std::string& reason, const Successor& successor) {
  if (parts_->shut_down) return;
  parts_->shut_down = true;
  parts_->server->GetHealthCheckService()->SetServingStatus(false);
  parts_->server->GetHealthCheckService()->SetServingStatus(kServiceName, false);
  const auto end = std::chrono::steady_clock::now() + kShutdownTimeout;
  SessionTable::NextServerFor next;
  if (!successor.address.empty()) {
    next = [this, successor](const Authorization& authorization) {
      v1::NextServer server;
      server.set_address(successor.address);
      if (parts_->security && !successor.name.empty()) {
        if (auto token = parts_->security->tokens().fleet_token_for(successor.name, authorization); token)
          server.set_token(std::move(*token));
      }
      return server;
    };
  }
  parts_->table.close(reason, next);
  // Clients that are reconnecting receive the address of the next server too.
  if (next) parts_->table.wait_until_empty(end);
  parts_->door->close();
  parts_->server->Shutdown(std::chrono::system_clock::now() + (end - std::chrono::steady_clock::now()));
  parts_->server->Wait();
  parts_->web->close();
  std::lock_guard lock(parts_->proposals->mutex);
  parts_->proposals->table = nullptr;
}

const SessionTable& GrpcServer::session_table() const { return parts_->table; }
SessionTable::Totals GrpcServer::sessions() const { return parts_->table.totals(); }
size_t GrpcServer::client_count() const { return parts_->table.status().clients; }
size_t GrpcServer::streaming_count() const { return parts_->table.status().streaming; }
PublisherSummary GrpcServer::published() const { return parts_->publisher->summary(); }

}  // namespace livegs
