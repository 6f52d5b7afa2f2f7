// SPDX-License-Identifier: Apache-2.0
#include "bench/support/stream_clients.h"

#include <grpcpp/create_channel.h>
#include <signal.h>
#include <time.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>
#include <optional>
#include <semaphore>

#include "core/clock.h"
#include "core/log.h"
#include "livegs/v1/session.grpc.pb.h"
#include "stream/session/session_client.h"
#include "trust/state_folder.h"
#include "wire/frame_codec.h"

namespace livegs::bench {
namespace {

constexpr const char* kWord = "stream-clients";

[[noreturn]] void give_up(const std::string& why) {
  std::fprintf(stderr, "%s\n", why.c_str());
  std::exit(1);
}

// A client of either kind that has joined.
class Client {
 public:
  virtual ~Client() = default;
  virtual void stop() = 0;
  std::vector<GotFrame> got;  // used by the reader's thread until stop() has returned
};

class WholeClient final : public Client, private StreamSink {
 public:
  WholeClient(const std::string& address, const ConnectOptions& options, uint32_t client) : client_(client) {
    auto joined = SessionClient::join(address, options);
    if (!joined) give_up(joined.error().message);
    session_ = std::move(*joined);
    session_->start(*this);
  }
  void stop() override {
    if (const auto stopped = session_->stop(); !stopped) give_up(stopped.error().message);
  }

 private:
  void on_frame(ReceivedFrame frame) override {
    got.push_back({frame.tick, frame.stepped_ns, frame.received_ns, frame.decoded_ns, client_,
                   static_cast<uint32_t>(frame.bytes)});
  }
  void on_lost(const std::string& reason) override { give_up("stream_clients: a stream broke: " + reason); }
  void on_resumed(const ResumedSession&) override {}
  void on_object_added(StreamedObject) override {}
  void on_object_changed(StreamedObject) override {}
  void on_object_removed(uint32_t) override {}
  void on_draining(const std::string&) override {}

  const uint32_t client_;
  std::unique_ptr<SessionClient> session_;
};

// Half of a headset's field of view plus a margin for head rotation, and the speed of that rotation.
constexpr float kHalfView_rad = 1.2f;
constexpr double kTurns_rad_s = 0.5;

// A cap that no client reaches.
constexpr double kWideCap_mbit_s = 1000;

// Runs on gRPC's shared threads. `turned_rad`: the initial direction of view; the client sends no view
// without it.
class LightClient final : public Client,
                          private grpc::ClientBidiReactor<v1::ClientMessage, v1::ServerMessage> {
 public:
  LightClient(const std::string& address, const ConnectOptions& options, uint32_t client,
              std::optional<double> turned_rad, bool capped)
      : client_(client), turned_rad_(turned_rad) {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
    stub_ = v1::LiveGs::NewStub(grpc::CreateCustomChannel(
        address, options.access ? options.access->credentials() : grpc::InsecureChannelCredentials(),
        arguments));
    v1::JoinRequest request;
    request.set_protocol_version(kProtocolVersion);
    if (capped) request.set_max_mbit_s(kWideCap_mbit_s);
    v1::JoinReply reply;
    grpc::ClientContext context;
    if (const grpc::Status joined = stub_->Join(&context, request, &reply); !joined.ok())
      give_up(joined.error_message());
    stub_->async()->Stream(&context_, this);
    outgoing_.set_session_id(reply.session_id());
    look();
    writing_ = true;
    StartWrite(&outgoing_);
    StartRead(&incoming_);
    StartCall();
  }
  void stop() override {
    context_.TryCancel();
    done_.acquire();
  }

 private:
  void OnReadDone(bool ok) override {
    if (!ok) return;
    const int64_t received_ns = now_ns();
    if (!incoming_.frame().empty()) {
      got.push_back({incoming_.tick(), incoming_.stepped_ns(), received_ns, received_ns, client_,
                     static_cast<uint32_t>(incoming_.frame().size())});
      std::lock_guard lock(mutex_);
      newest_ = incoming_.tick();
      write();
    }
    StartRead(&incoming_);
  }
  void OnWriteDone(bool ok) override {
    std::lock_guard lock(mutex_);
    writing_ = false;
    if (ok) write();
  }
  void OnDone(const grpc::Status&) override { done_.release(); }
  void write() {
    if (writing_ || acknowledged_ == newest_) return;
    outgoing_.Clear();
    outgoing_.set_acknowledged_tick(acknowledged_ = newest_);
    look();
    writing_ = true;
    StartWrite(&outgoing_);
  }
  void look() {
    if (!turned_rad_) return;
    const double angle_rad = *turned_rad_ + kTurns_rad_s * seconds_from_ns(now_ns() - begun_ns_);
    v1::View& view = *outgoing_.mutable_view();
    for (const double x : {std::sin(angle_rad), 0.0, -std::cos(angle_rad)}) {
      view.add_position_m(0);
      view.add_forward(static_cast<float>(x));
    }
    view.set_half_angle_rad(kHalfView_rad);
  }

  const uint32_t client_;
  const std::optional<double> turned_rad_;
  const int64_t begun_ns_ = now_ns();
  std::unique_ptr<v1::LiveGs::Stub> stub_;
  grpc::ClientContext context_;
  v1::ServerMessage incoming_;
  std::binary_semaphore done_{0};
  std::mutex mutex_;  // guards everything below
  v1::ClientMessage outgoing_;
  uint64_t newest_ = 0, acknowledged_ = 0;
  bool writing_ = false;
};

}  // namespace

StreamClients::StreamClients(const ServerToJoin& server, int count, ClientKind kind) {
  if (const auto written = write_secret_file(folder_ / "token", server.token); !written)
    give_up(written.error().message);
  process_ = std::make_unique<Program>(
      std::vector<std::string>{"/proc/self/exe", kWord, std::to_string(server.port), std::to_string(count),
                               kind_name(kind), server.fingerprint, folder_.path().string()});
  if (process_->first_line() != "streaming") give_up("stream_clients: join failed: " + process_->err());
}

int64_t StreamClients::cpu_ns() const {
  clockid_t clock;
  timespec time{};
  if (::clock_getcpuclockid(process_->process(), &clock) == 0) ::clock_gettime(clock, &time);
  return int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

void StreamClients::freeze() { process_->send(SIGSTOP); }

std::vector<GotFrame> StreamClients::stop() {
  process_->send(SIGTERM);
  if (process_->wait() != 0) give_up("stream_clients: failed: " + process_->err());
  const std::filesystem::path path = folder_ / "got";
  std::vector<GotFrame> got(std::filesystem::file_size(path) / sizeof(GotFrame));
  std::ifstream(path, std::ios::binary)
      .read(reinterpret_cast<char*>(got.data()), static_cast<std::streamsize>(got.size() * sizeof(GotFrame)));
  return got;
}

bool is_stream_clients(int argc, char** argv) { return argc == 7 && std::strcmp(argv[1], kWord) == 0; }

int run_stream_clients(char** argv) {
  sigset_t ending;
  sigemptyset(&ending);
  sigaddset(&ending, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &ending, nullptr);
  set_log_level(LogLevel::Warn);
  const std::string address = std::string("127.0.0.1:") + argv[2], fingerprint = argv[5];
  const std::filesystem::path folder = argv[6];
  const bool whole = std::strcmp(argv[4], kind_name(ClientKind::Whole)) == 0;
  const bool capped = std::strcmp(argv[4], kind_name(ClientKind::Capped)) == 0;
  const bool looking = capped || std::strcmp(argv[4], kind_name(ClientKind::Looking)) == 0;
  ConnectOptions options;
  options.timeout_s = 30;
  if (!fingerprint.empty()) {
    const auto token = read_secret_file(folder / "token");
    if (!token) give_up(token.error().message);
    options.access = std::make_shared<ServerAccess>(address, ServerAccess::Keys{fingerprint, "", *token});
  }
  std::vector<std::unique_ptr<Client>> clients;
  const auto count = static_cast<uint32_t>(std::atoi(argv[3]));
  for (uint32_t i = 0; i < count; ++i) {
    if (whole) {
      clients.push_back(std::make_unique<WholeClient>(address, options, i));
      continue;
    }
    const auto turned_rad = looking ? std::optional(2 * M_PI * i / count) : std::nullopt;
    clients.push_back(std::make_unique<LightClient>(address, options, i, turned_rad, capped));
  }
  std::printf("streaming\n");
  std::fflush(stdout);
  int signal_number = 0;
  sigwait(&ending, &signal_number);
  for (const auto& client : clients) client->stop();
  std::ofstream file(folder / "got", std::ios::binary);
  for (const auto& client : clients) {
    file.write(reinterpret_cast<const char*>(client->got.data()),
               static_cast<std::streamsize>(client->got.size() * sizeof(GotFrame)));
  }
  return file.flush() ? 0 : 1;
}

}  // namespace livegs::bench
