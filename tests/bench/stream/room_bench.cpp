// SPDX-License-Identifier: Apache-2.0
// Processor time, memory and bandwidth of one room: livegs-server with a scene, by number of clients. The
// server is a process of its own with TLS and one simulation thread, as in a fleet. Prints CSV:
//   room_bench SCENE [SECONDS] > results/<machine>/room.csv       default: 20 s
// Clients are light (bench/support/stream_clients.h), without a view: each receives every object. In the
// state `pulled` one of the clients pulls random objects with both hands all the time; in `rest` no hand
// moves. The first two seconds are not counted. ready_s: from the start of the process until clients can
// join. load_cpu_s: processor time until then. cpu_percent: processor time of the server over wall time (100:
// one core). resident_mb: memory at the end. client_mbit_s: frames as sent to one client, without the headers
// of TLS and TCP. asset_mb: assets of the scene as sent to one client, once.
#include <time.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <optional>
#include <random>
#include <thread>

#include "bench/support/arguments.h"
#include "bench/support/stream_clients.h"
#include "core/clock.h"
#include "core/log.h"
#include "session/access/server_security.h"
#include "stream/session/session_client.h"

using namespace livegs;
using namespace livegs::bench;

namespace {

constexpr double kWarmUp_s = 2;
constexpr double kInput_hz = 90;
constexpr double kPull_s = 0.8;   // a hand holds one point for this time
constexpr double kReach_m = 0.3;  // and moves it this far

[[noreturn]] void give_up(const std::string& why) {
  std::fprintf(stderr, "room_bench: %s\n", why.c_str());
  std::exit(1);
}

double cpu_s(const Program& program) {
  clockid_t clock;
  timespec time{};
  if (::clock_getcpuclockid(program.process(), &clock) == 0) ::clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double resident_mb(const Program& program) {
  std::ifstream file("/proc/" + std::to_string(program.process()) + "/statm");
  double pages = 0, resident = 0;
  file >> pages >> resident;
  return 1e-6 * resident * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

// A client that pulls with both hands: each ray starts above the objects and points at a random object, and
// moves.
class Puller final : private StreamSink {
 public:
  explicit Puller(std::unique_ptr<SessionClient> session) : session_(std::move(session)) {
    session_->start(*this);
  }
  ~Puller() {
    if (thread_.joinable()) {
      thread_.request_stop();
      thread_.join();
    }
    (void)session_->stop();
  }
  void pull() {
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }
  const JoinedScene& scene() const { return session_->scene(); }

 private:
  void run(const std::stop_token& stop) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> angle(0, 2 * M_PI);
    const Eigen::Vector3d eye(0, 1.6, 1.2);
    Eigen::Vector3d at[2], along[2];
    InputSample sample;
    const int64_t begun_ns = now_ns();
    const auto ticks_a_pull = static_cast<uint64_t>(kPull_s * kInput_hz);
    while (!stop.stop_requested()) {
      const uint64_t tick = sample.sequence++;
      sample.sampled_ns = now_ns();
      const double part = static_cast<double>(tick % ticks_a_pull) / static_cast<double>(ticks_a_pull);
      for (size_t hand = 0; hand < 2; ++hand) {
        if (tick % ticks_a_pull == 0) {
          at[hand] = place(random);
          const double turn = angle(random);
          along[hand] = {std::cos(turn), 0.5, std::sin(turn)};
        }
        HandSample& now = sample.hands[hand];
        now.active = true;
        now.aim.position_m = eye + kReach_m * part * along[hand];
        now.aim.orientation = Eigen::Quaterniond::FromTwoVectors(-Eigen::Vector3d::UnitZ(), at[hand] - eye);
        now.grip = now.aim;
        now.trigger = part > 0 ? 1.0f : 0.0f;
      }
      session_->send(sample);
      sleep_until_ns(begun_ns + static_cast<int64_t>(1e9 / kInput_hz * static_cast<double>(sample.sequence)));
    }
  }
  // A random node or body of a random object, where it is now.
  Eigen::Vector3d place(std::mt19937_64& random) {
    std::lock_guard lock(mutex_);
    if (!newest_ || newest_->objects.empty()) return Eigen::Vector3d::Zero();
    const ObjectDrivers& object = newest_->objects[random() % newest_->objects.size()];
    if (!object.positions_m.empty())
      return object.positions_m[random() % object.positions_m.size()].cast<double>();
    return object.poses.empty() ? Eigen::Vector3d::Zero()
                                : object.poses[random() % object.poses.size()].position_m;
  }
  void on_frame(ReceivedFrame frame) override {
    std::lock_guard lock(mutex_);
    newest_ = frame.drivers;
  }
  void on_lost(const std::string& reason) override { give_up("the stream broke: " + reason); }
  void on_resumed(const ResumedSession&) override {}
  void on_object_added(StreamedObject) override {}
  void on_object_changed(StreamedObject) override {}
  void on_object_removed(uint32_t) override {}
  void on_draining(const std::string&) override {}

  std::mutex mutex_;
  std::shared_ptr<const DriverFrame> newest_;  // guarded by mutex_
  std::unique_ptr<SessionClient> session_;
  std::jthread thread_;
};

// Makes a certificate and a token in the state folder. The folder is free again for the server on return.
ServerToJoin make_access(const std::string& state) {
  auto security = ServerSecurity::open(state);
  if (!security) give_up(security.error().message);
  const auto token = (*security)->tokens().add("room_bench", v1::INTERACT, 1);
  if (!token) give_up(token.error().message);
  return {0, (*security)->fingerprint(), token->secret};
}

void measure(const std::string& scene, bool pulled, int count, double seconds) {
  ScratchFolder folder;
  const ServerToJoin access = make_access(folder / "state");
  const int64_t begun_ns = now_ns();
  Program server({LIVEGS_SERVER, scene, "--listen", "127.0.0.1:0", "--print-port", "--threads", "1", "--tls",
                  "on", "--state-dir", folder / "state", "--clients", "100"});
  const std::string port = server.first_line();
  if (port.empty()) give_up("the server failed: " + server.err());
  const double ready_s = seconds_from_ns(now_ns() - begun_ns), load_cpu_s = cpu_s(server);

  const ServerToJoin to{std::atoi(port.c_str()), access.fingerprint, access.token};
  const std::string address = "127.0.0.1:" + port;
  ConnectOptions options;
  options.timeout_s = 30;
  options.access = std::make_shared<ServerAccess>(address, ServerAccess::Keys{to.fingerprint, "", to.token});
  auto joined = SessionClient::join(address, options);
  if (!joined) give_up(joined.error().message);
  Puller puller(std::move(*joined));
  if (pulled) puller.pull();
  double asset_bytes = 0;
  for (const StreamedObject& object : puller.scene().objects)
    asset_bytes += static_cast<double>(object.asset_bytes + object.broken_asset_bytes);

  // The puller is one of the clients.
  std::optional<StreamClients> clients;
  if (count > 1) clients.emplace(to, count - 1, ClientKind::Light);
  sleep_until_ns(now_ns() + static_cast<int64_t>(kWarmUp_s * 1e9));
  const double cpu_before_s = cpu_s(server);
  const int64_t from_ns = now_ns();
  sleep_until_ns(from_ns + static_cast<int64_t>(seconds * 1e9));
  const int64_t to_ns = now_ns();
  const double used_s = cpu_s(server) - cpu_before_s, wall_s = seconds_from_ns(to_ns - from_ns);
  const double end_mb = resident_mb(server);
  double frames = 0, bytes = 0;
  if (clients) {
    for (const GotFrame& frame : clients->stop()) {
      if (frame.received_ns < from_ns || frame.received_ns >= to_ns) continue;
      ++frames;
      bytes += frame.bytes;
    }
  }
  const double per_client = std::max(1, count - 1) * wall_s;
  std::printf("%s,%s,%d,%.0f,%.2f,%.2f,%.1f,%.1f,%.2f,%.3f,%.2f\n",
              std::filesystem::path(scene).stem().stem().c_str(), pulled ? "pulled" : "rest", count, wall_s,
              ready_s, load_cpu_s, 100 * used_s / wall_s, end_mb, frames / per_client,
              8e-6 * bytes / per_client, 1e-6 * asset_bytes);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (is_stream_clients(argc, argv)) return run_stream_clients(argv);
  set_log_level(LogLevel::Warn);
  std::string scene;
  double seconds = 20;
  CLI::App app("Processor time, memory and bandwidth of one room; CSV on standard output", "room_bench");
  app.add_option("SCENE", scene, "Scene file, for example of livegs sample")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("SECONDS", seconds, "Length of each measurement")
      ->check(between(1, 3600))
      ->capture_default_str();
  read_arguments(app, argc, argv);
  std::printf(
      "scene,state,clients,seconds,ready_s,load_cpu_s,cpu_percent,resident_mb,received_hz,client_mbit_s,"
      "asset_mb\n");
  for (const bool pulled : {false, true}) {
    for (const int clients : {2, 8, 16, 32, 64}) measure(scene, pulled, clients, seconds);
  }
  return 0;
}
