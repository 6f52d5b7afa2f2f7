// SPDX-License-Identifier: Apache-2.0
// Age of frames when a client has received and decoded them, by number of clients: measured from the end of
// the tick's step, over loopback, at 90 Hz. The server is this process and the clients are another one on the
// same machine. 64 decoding clients would run on 64 machines in production, so there are also light clients
// (bench/support/stream_clients.h). Prints CSV:
//   stream_bench [SECONDS [SCENE...]] > results/<machine>/stream.csv       default: 20 s
// Frames of incompressible noise are sent:
// - to one client, in clear text and over TLS in alternation;
// - to 1 to 64 clients, and to more light clients until p99 exceeds 5 ms;
// - with the same bytes in 64 objects, in alternation to 64 clients without a view, to 64 with different
//   views, and to 64 with different views and a cap;
// - to 63 clients with and without a frozen client, in alternation;
// - through narrow, long and stalling links (system/support/fault_proxy.h), for three times as long.
// With scenes (files or folders of assets), each is sent to 1 and 8 clients instead. --links, --views, --tls
// and --clients N... select a part. The first second is not counted. The two halves of a measurement show
// whether ages grow.
// goal_ms_p99 is the bound of decoded_ms_p99: 5 for 64 clients, 3 for one over TLS at 32 kB, 60 at 8 Mbit/s.
// goal_of_note is the bound of the values in the note. others_cpu_percent is the load of other programs (100:
// one core); the proxy of a link counts as part of the server.
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numeric>

#include "bench/support/arguments.h"
#include "bench/support/stream_clients.h"
#include "core/log.h"
#include "core/percentile.h"
#include "scenes/served_scene.h"
#include "session/access/server_security.h"
#include "session/sessions/session_table.h"
#include "system/stream/noise_server.h"
#include "system/support/fault_proxy.h"

using namespace livegs;
using namespace livegs::bench;

namespace {

constexpr int64_t kSecond_ns = 1'000'000'000;
constexpr double kBar_ms = 5;  // p99 at 64 clients; Measured::goal() has the others

int64_t own_cpu_ns() {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  return (used.ru_utime.tv_sec + used.ru_stime.tv_sec) * kSecond_ns +
         (used.ru_utime.tv_usec + used.ru_stime.tv_usec) * 1000;
}

// Processor time of all cores and all programs.
int64_t machine_cpu_ns() {
  std::ifstream file("/proc/stat");
  std::string name;
  int64_t user = 0, nice = 0, system = 0, idle = 0, waiting = 0, hard = 0, soft = 0, stolen = 0;
  file >> name >> user >> nice >> system >> idle >> waiting >> hard >> soft >> stolen;
  return (user + nice + system + hard + soft + stolen) * (kSecond_ns / ::sysconf(_SC_CLK_TCK));
}

double resident_mb() {
  std::ifstream file("/proc/self/statm");
  size_t pages = 0, resident = 0;
  file >> pages >> resident;
  return 1e-6 * static_cast<double>(resident) * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

// A time interval with the processor time of both ends.
struct Window {
  int64_t begin_ns = 0, end_ns = 0;
  int64_t server_cpu_ns = 0, clients_cpu_ns = 0, machine_cpu_ns = 0;
  uint64_t frames = 0, encoded = 0;
};

Window watch(const GrpcServer& server, const StreamClients& clients, const std::function<void()>& wait) {
  const PublisherSummary before = server.published();
  Window window{now_ns(), 0, -own_cpu_ns(), -clients.cpu_ns(), -machine_cpu_ns(), 0, 0};
  wait();
  const PublisherSummary after = server.published();
  window.frames = after.frames - before.frames;
  window.encoded = after.encoded - before.encoded;
  window.end_ns = now_ns();
  window.server_cpu_ns += own_cpu_ns();
  window.clients_cpu_ns += clients.cpu_ns();
  window.machine_cpu_ns += machine_cpu_ns();
  return window;
}

Window watch_for(const GrpcServer& server, const StreamClients& clients, double duration_s) {
  return watch(server, clients, [&] { sleep_until_ns(now_ns() + static_cast<int64_t>(duration_s * 1e9)); });
}

// Totals of all windows of one measurement.
struct Measured {
  Measured(std::string what_is_sent, std::string over, int to, ClientKind of)
      : what(std::move(what_is_sent)), transport(std::move(over)), clients(to), kind(of) {}

  std::string what, transport;
  int clients = 0;
  ClientKind kind;
  std::vector<double> received_ms, decoded_ms, bytes;
  std::vector<double> half_ms[2];  // decoded_ms of frames from the first and second half of a window
  uint64_t missed = 0, frames = 0, encoded = 0;
  double seconds = 0;
  int64_t server_cpu_ns = 0, clients_cpu_ns = 0, machine_cpu_ns = 0;
  std::string note;

  void add(const Window& window, const std::vector<GotFrame>& got) {
    uint64_t first = 0, last = 0, count = 0;
    for (const GotFrame& frame : got) {
      if (frame.stepped_ns < window.begin_ns || frame.stepped_ns >= window.end_ns) continue;
      received_ms.push_back(milliseconds_from_ns(frame.received_ns - frame.stepped_ns));
      decoded_ms.push_back(milliseconds_from_ns(frame.decoded_ns - frame.stepped_ns));
      half_ms[frame.stepped_ns - window.begin_ns < window.end_ns - frame.stepped_ns ? 0 : 1].push_back(
          decoded_ms.back());
      bytes.push_back(frame.bytes);
      first = count == 0 ? frame.tick : std::min(first, frame.tick);
      last = std::max(last, frame.tick);
      ++count;
    }
    // Frames missing between the first and the last received one.
    if (count > 0) missed += (last - first + 1) * static_cast<uint64_t>(clients) - count;
    frames += window.frames;
    encoded += window.encoded;
    seconds += seconds_from_ns(window.end_ns - window.begin_ns);
    server_cpu_ns += window.server_cpu_ns;
    clients_cpu_ns += window.clients_cpu_ns;
    machine_cpu_ns += window.machine_cpu_ns;
  }
  // Bound of decoded_ms_p99; empty if there is none.
  std::string goal() {
    if (what == "noise over 8 Mbit/s") return "60";
    if (what.starts_with("noise") && clients == 64) return "5";
    return what == "noise" && transport == "tls" && clients == 1 && percentile(bytes, 0.5) > 20'000 ? "3"
                                                                                                    : "";
  }
  // Bound of the values in the note.
  const char* goal_of_note() const {
    if (what == "noise and a frozen client")
      return "p99 1.10 of that without; dropped after 2.5 s; server grows by 5 MB";
    return what.ends_with("stall") || what.ends_with("stalls") ? "2 old frames after each stall" : "";
  }
  double decoded_p99_ms() { return percentile(decoded_ms, 0.99); }

  static void print_head() {
    std::printf(
        "what,transport,clients,client,seconds,frame_bytes_p50,received_hz,missed_frames,encoded_per_frame,"
        "received_ms_p50,received_ms_p99,decoded_ms_p50,"
        "decoded_ms_p95,decoded_ms_p99,goal_ms_p99,decoded_ms_p999,first_half_ms_p99,second_half_ms_p99,"
        "server_cpu_percent,clients_cpu_percent,others_cpu_percent,goal_of_note,note\n");
  }
  void print() {
    const auto percent = [&](int64_t cpu_ns) { return 100 * seconds_from_ns(cpu_ns) / seconds; };
    std::printf(
        "%s,%s,%d,%s,%.0f,%.0f,%.2f,%llu,%.2f,%.3f,%.3f,%.3f,%.3f,%.3f,%s,%.3f,%.3f,%.3f,%.1f,%.1f,%.1f,%s,%"
        "s\n",
        what.c_str(), transport.c_str(), clients, kind_name(kind), seconds, percentile(bytes, 0.5),
        static_cast<double>(decoded_ms.size()) / seconds / static_cast<double>(clients),
        static_cast<unsigned long long>(missed), static_cast<double>(encoded) / static_cast<double>(frames),
        percentile(received_ms, 0.5), percentile(received_ms, 0.99), percentile(decoded_ms, 0.5),
        percentile(decoded_ms, 0.95), decoded_p99_ms(), goal().c_str(), percentile(decoded_ms, 0.999),
        percentile(half_ms[0], 0.99), percentile(half_ms[1], 0.99), percent(server_cpu_ns),
        percent(clients_cpu_ns), percent(machine_cpu_ns - server_cpu_ns - clients_cpu_ns), goal_of_note(),
        note.c_str());
    std::fflush(stdout);
  }
};

// A server certificate and a token for its clients in a temporary folder.
struct Secured {
  ScratchFolder folder;
  std::unique_ptr<ServerSecurity> security;
  std::string token;

  Secured() {
    auto opened = ServerSecurity::open(folder / "state");
    if (!opened) {
      std::fprintf(stderr, "%s\n", opened.error().message.c_str());
      std::exit(1);
    }
    security = std::move(*opened);
    token = security->tokens().add("the bench's", v1::INTERACT, 1)->secret;
  }
};

// Adds a measurement with `nodes` nodes of noise per frame for `clients` clients. `boxes`: number of objects.
void noise(Measured& measured, size_t nodes, Secured* secured, double seconds, size_t boxes = 0) {
  NoiseServer server(nodes, secured ? secured->security.get() : nullptr, kMaxSessions, boxes);
  StreamClients clients(
      {server.port(), secured ? secured->security->fingerprint() : "", secured ? secured->token : ""},
      measured.clients, measured.kind);
  sleep_until_ns(now_ns() + kSecond_ns);
  const Window window = watch_for(*server.server, clients, seconds);
  measured.add(window, clients.stop());
}

// Two measurements in alternation, so that other load affects both equally.
void plain_and_tls(size_t nodes, double seconds) {
  constexpr int kTurns = 4;
  Secured secured;
  Measured plain("noise", "plain", 1, ClientKind::Whole), tls("noise", "tls", 1, ClientKind::Whole);
  for (int turn = 0; turn < kTurns; ++turn) {
    noise(plain, nodes, nullptr, seconds / kTurns);
    noise(tls, nodes, &secured, seconds / kTurns);
  }
  plain.print();
  tls.print();
}

// Clients with different views, and clients without a view.
void looking_around(size_t nodes, double seconds) {
  constexpr int kTurns = 4;
  std::vector<Measured> all;
  for (const ClientKind kind : {ClientKind::Light, ClientKind::Looking, ClientKind::Capped})
    all.emplace_back("noise in 64 objects", "plain", 64, kind);
  for (int turn = 0; turn < kTurns; ++turn) {
    for (Measured& measured : all) noise(measured, nodes, nullptr, seconds / kTurns, 64);
  }
  for (Measured& measured : all) measured.print();
}

// 63 clients, in alternation without and with a frozen one, until the server drops it.
void frozen_among_63(size_t nodes, double seconds) {
  NoiseServer server(nodes);
  Measured alone("noise", "plain", 63, ClientKind::Light),
      with_frozen("noise and a frozen client", "plain", 63, ClientKind::Light);
  StreamClients clients({server.port(), "", ""}, 63, ClientKind::Light);
  std::vector<Window> windows[2];
  double longest_s = 0, most_grown_mb = 0;
  for (double measured_s = 0; measured_s < seconds;) {
    StreamClients one({server.port(), "", ""}, 1, ClientKind::Whole);
    sleep_until_ns(now_ns() + kSecond_ns);
    const double before_mb = resident_mb();
    double most_mb = before_mb;
    one.freeze();
    windows[1].push_back(watch(*server.server, clients, [&] {
      while (server.server->streaming_count() > 63) {
        sleep_until_ns(now_ns() + 5'000'000);
        most_mb = std::max(most_mb, resident_mb());
      }
    }));
    const double frozen_s = seconds_from_ns(windows[1].back().end_ns - windows[1].back().begin_ns);
    longest_s = std::max(longest_s, frozen_s);
    most_grown_mb = std::max(most_grown_mb, most_mb - before_mb);
    sleep_until_ns(now_ns() + kSecond_ns / 2);
    windows[0].push_back(watch_for(*server.server, clients, frozen_s));
    measured_s += frozen_s;
  }
  const std::vector<GotFrame> got = clients.stop();
  for (const Window& window : windows[0]) alone.add(window, got);
  for (const Window& window : windows[1]) with_frozen.add(window, got);
  char note[160];
  std::snprintf(note, sizeof note,
                "p99 %.2f of that without; dropped after %.2f s at most; server grew by %.1f MB at most",
                with_frozen.decoded_p99_ms() / alone.decoded_p99_ms(), longest_s, most_grown_mb);
  with_frozen.note = note;
  alone.print();
  with_frozen.print();
}

// One client behind a link, with or without stalls of 300 ms every two seconds.
void through(const char* what, const Link& link, bool stalls, size_t nodes, double seconds) {
  constexpr double kStall_s = 0.3;
  constexpr int64_t kStallEvery_ns = 2 * kSecond_ns, kOld_ns = 50'000'000;
  NoiseServer server(nodes);
  FaultProxy proxy(server.port());
  proxy.set_link(link);
  Measured measured(what, "plain", 1, ClientKind::Whole);
  StreamClients clients({proxy.port(), "", ""}, 1, ClientKind::Whole);
  sleep_until_ns(now_ns() + kSecond_ns);
  std::vector<int64_t> healed_ns;
  size_t window_frames[5] = {};
  const Window window = watch(*server.server, clients, [&] {
    const int64_t begun_ns = now_ns(), end_ns = begun_ns + static_cast<int64_t>(seconds * 1e9);
    int64_t stall_ns = begun_ns + kStallEvery_ns / 2;
    while (now_ns() < end_ns) {
      if (stalls && now_ns() >= stall_ns) {
        proxy.stall(kStall_s);
        healed_ns.push_back(now_ns() + static_cast<int64_t>(1e9 * kStall_s));
        stall_ns += kStallEvery_ns;
      }
      for (const auto& session : server.server->session_table().sessions_now())
        ++window_frames[session->window()];
      sleep_until_ns(now_ns() + 10'000'000);
    }
  });
  const std::vector<GotFrame> got = clients.stop();
  measured.add(window, got);
  // Frames received within a second after a stall that were made well before its end.
  size_t most_old = 0;
  for (const int64_t healed : healed_ns) {
    size_t old = 0;
    for (const GotFrame& frame : got) {
      const bool after = frame.received_ns > healed - 5'000'000 && frame.received_ns < healed + kSecond_ns;
      old += after && frame.stepped_ns < healed - kOld_ns ? 1 : 0;
    }
    most_old = std::max(most_old, old);
  }
  const size_t usual =
      static_cast<size_t>(std::max_element(window_frames, window_frames + 5) - window_frames);
  measured.note = "window " + std::to_string(usual) + " most of the time";
  if (stalls)
    measured.note += "; " + std::to_string(healed_ns.size()) + " stalls; at most " +
                     std::to_string(most_old) + " old frames after each";
  measured.print();
}

void links(size_t nodes, double seconds) {
  through("noise over 8 Mbit/s", {.delay_ms = 1, .mbit_s = 8}, false, nodes, seconds);
  through("noise over 8 Mbit/s that stall", {.delay_ms = 1, .mbit_s = 8}, true, nodes, seconds);
  through("noise over a link that stalls", {.delay_ms = 1}, true, nodes, seconds);
  through("noise over 40 ms there and back", {.delay_ms = 20}, false, nodes, seconds);
}

void scene(const char* path, int count, double seconds) {
  auto loaded = Scene::load(path, {});
  if (!loaded) {
    std::fprintf(stderr, "%s\n", loaded.error().message.c_str());
    std::exit(2);
  }
  Measured measured(loaded->name(), "plain", count, ClientKind::Whole);
  ServedScene served(std::move(*loaded));
  StreamClients clients({served.port(), "", ""}, count, ClientKind::Whole);
  sleep_until_ns(now_ns() + kSecond_ns);
  const SimulationSummary before = served.loop->summary();
  const Window window = watch_for(*served.server, clients, seconds);
  const SimulationSummary after = served.loop->summary();
  measured.add(window, clients.stop());
  char note[160];
  std::snprintf(note, sizeof note, "%.2f ticks a second; step p50 %.3f and p99 %.3f ms; encoding p50 %.3f ms",
                static_cast<double>(after.ticks - before.ticks) / measured.seconds, after.step_ms_p50,
                after.step_ms_p99, served.server->published().encode_ms_p50);
  measured.note = note;
  measured.print();
}

}  // namespace

int main(int argc, char** argv) {
  if (is_stream_clients(argc, argv)) return run_stream_clients(argv);
  set_log_level(LogLevel::Warn);
  double seconds = 20;
  std::vector<std::string> scenes;
  std::vector<int> counts;
  bool links_only = false, views_only = false, tls_only = false;
  CLI::App app("Age of frames on arrival, by number of clients; CSV on standard output", "stream_bench");
  app.add_option("SECONDS", seconds, "Length of each measurement")
      ->check(between(1, 3600))
      ->capture_default_str();
  auto* of_scenes =
      app.add_option("SCENE", scenes,
                     "Scene files or folders of assets, each sent to 1 and 8 clients instead of noise")
          ->check(CLI::ExistingPath);
  auto* of_clients =
      app.add_option("--clients", counts, "Only noise to these numbers of clients, light and whole")
          ->check(between(1, static_cast<double>(kMaxSessions)))
          ->excludes(of_scenes);
  app.add_flag("--links", links_only, "Only noise through narrow, long and stalling links")
      ->excludes(of_scenes)
      ->excludes(of_clients);
  app.add_flag("--views", views_only,
               "Only noise in 64 objects to 64 clients, with and without different views")
      ->excludes(of_scenes)
      ->excludes(of_clients);
  app.add_flag("--tls", tls_only, "Only 32 kB of noise to one client, in clear text and over TLS")
      ->excludes(of_scenes)
      ->excludes(of_clients);
  read_arguments(app, argc, argv);
  Measured::print_head();
  // A node of noise takes 5.98 bytes. These are frames of 16 384 and 32 768 bytes.
  constexpr size_t k16kB = 2738, k32kB = 5480;
  const auto noise_to = [&](int clients, ClientKind kind, Secured* secured) {
    Measured measured("noise", secured ? "tls" : "plain", clients, kind);
    noise(measured, k16kB, secured, seconds);
    measured.print();
    return measured.decoded_p99_ms();
  };
  if (links_only) links(k16kB, seconds);
  if (views_only) looking_around(k16kB, seconds);
  if (tls_only) plain_and_tls(k32kB, seconds);
  if (links_only || views_only || tls_only) return 0;
  for (const int clients : counts) {
    for (const ClientKind kind : {ClientKind::Light, ClientKind::Whole}) noise_to(clients, kind, nullptr);
  }
  for (const std::string& path : scenes) {
    for (const int clients : {1, 8}) scene(path.c_str(), clients, seconds);
  }
  if (!counts.empty() || !scenes.empty()) return 0;
  plain_and_tls(k32kB, seconds);
  for (const ClientKind kind : {ClientKind::Light, ClientKind::Whole}) {
    for (const int clients : {1, 8, 16, 32, 64}) noise_to(clients, kind, nullptr);
  }
  for (const int clients : {96, 128, 192, 256, 320}) {  // up to the capacity of the machine
    if (noise_to(clients, ClientKind::Light, nullptr) > kBar_ms) break;
  }
  looking_around(k16kB, seconds);
  Secured secured;
  noise_to(64, ClientKind::Light, &secured);
  frozen_among_63(k16kB, seconds);
  links(k16kB, 3 * seconds);
  return 0;
}
