// SPDX-License-Identifier: Apache-2.0
// Time until frames and pictures return: after a network outage of a given duration, after a restart of the
// server in this process, and after a server process was killed. Prints CSV, one row per trial:
//   resume_bench [TRIALS] > results/<machine>/resume.csv       default: 10 of each kind
// back_ms: from the start of the new process until it accepts clients. Other times start there.
// frames_again_ms: until the first frame. picture_ms: until it is drawn, 320 x 240 on the CPU; `none` after
// one minute. goal_picture_ms: bound of picture_ms. objects_told: number of objects reported as changed.
// assets_fetched: number of assets fetched again. longest_gap_ms: maximum time between frames within three
// seconds of the first, for a killed server whose scene has a break in its first second.
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "bench/support/arguments.h"
#include "client/stream/session/sink_log.h"
#include "core/log.h"
#include "render/choose_camera.h"
#include "scenes/served_scene.h"
#include "system/programs/programs_fixture.h"
#include "system/support/fault_proxy.h"
#include "viewer/live/scene_loader.h"

using namespace livegs;

namespace {

constexpr int kNobody = 1;  // a port that refuses connections

[[noreturn]] void give_up(const std::string& why) {
  std::fprintf(stderr, "resume_bench: %s\n", why.c_str());
  std::exit(1);
}

int goal_ms(std::string_view fault) { return fault == "cut" ? 300 : 500; }

// A client that draws frames on request.
class Watcher {
 public:
  explicit Watcher(int port) {
    JoinOptions options;
    options.address = "127.0.0.1:" + std::to_string(port);
    options.cache = folder_ / "cache";
    options.connect_timeout_s = 60;
    SceneLoader loading(options,
                        [] { return Result<std::unique_ptr<SplatRenderer>>(create_cpu_renderer()); });
    auto joined = loading.take();
    if (!joined) give_up(joined.error().message);
    live_ = std::move(*joined);
    live_->client->start(sink_);
    if (!sink_.wait_frames(20)) give_up("no frames came to begin with");
    const auto drivers = sink_.state().frames.back().drivers;
    if (auto posed = live_->view.pose(*drivers); !posed) give_up(posed.error().message);
    camera_ = choose_camera(live_->view, 320, 240);
    draw(*drivers);
    fetched_ = live_->assets.totals().fetched;
  }
  ~Watcher() { (void)live_->client->stop(); }

  void draw(const DriverFrame& drivers) {
    std::vector<Image> images;
    if (auto drawn = live_->view.draw(drivers, {&*camera_, 1}, images); !drawn)
      give_up(drawn.error().message);
  }

  // Waits for the first frame after the outage, draws it and prints a row.
  void report(const char* fault, int trial, double outage_s, std::optional<double> start_ms, int64_t back_ns,
              bool gaps = false) {
    std::printf("%s,%d,%.1f,%s,", fault, trial, outage_s,
                start_ms ? std::to_string(std::lround(*start_ms)).c_str() : "");
    if (!sink_.wait_resumed(1)) {
      std::printf("none,none,%d,,,\n", goal_ms(fault));
    } else {
      const SinkLog::State state = sink_.state();
      const ReceivedFrame& frame = state.frames.at(state.resumed_at.front());
      draw(*frame.drivers);
      const double picture_ms = milliseconds_from_ns(now_ns() - back_ns);
      std::printf("%.0f,%.0f,%d,%zu,%zu,%s\n", milliseconds_from_ns(frame.received_ns - back_ns), picture_ms,
                  goal_ms(fault), state.added.size() + state.changed.size() + state.removed.size(),
                  live_->assets.totals().fetched - fetched_,
                  gaps ? std::to_string(std::lround(longest_gap_ms(state.resumed_at.front()))).c_str() : "");
    }
    std::fflush(stdout);
  }

 private:
  // Longest gap between frames in the three seconds after frame `from`, ms. The last frame ends a gap too.
  double longest_gap_ms(size_t from) {
    const int64_t end_ns = now_ns() + 3'000'000'000;
    sleep_until_ns(end_ns);
    const SinkLog::State state = sink_.state();
    int64_t longest_ns = end_ns - state.frames.back().received_ns;
    for (size_t i = from + 1; i < state.frames.size(); ++i)
      longest_ns = std::max(longest_ns, state.frames[i].received_ns - state.frames[i - 1].received_ns);
    if (state.changed.empty()) give_up("nothing broke");
    return milliseconds_from_ns(longest_ns);
  }

  ScratchFolder folder_;
  SinkLog sink_;
  std::unique_ptr<ConnectedScene> live_;
  std::optional<Camera> camera_;
  size_t fetched_ = 0;
};

void cut(int trial, double outage_s) {
  ServedScene served(box_scene());
  FaultProxy proxy(served.port());
  Watcher watcher(proxy.port());
  proxy.cut();
  sleep_until_ns(now_ns() + static_cast<int64_t>(outage_s * 1e9));
  proxy.heal();
  watcher.report("cut", trial, outage_s, std::nullopt, now_ns());
}

void restart(int trial, double outage_s) {
  auto served = std::make_unique<ServedScene>(box_scene());
  FaultProxy proxy(served->port());
  Watcher watcher(proxy.port());
  const int64_t begun_ns = now_ns();
  proxy.set_server(kNobody);
  proxy.reset();
  sleep_until_ns(begun_ns + static_cast<int64_t>(outage_s * 1e9));
  served = std::make_unique<ServedScene>(box_scene());  // takes time to build, and more to end the old server
  proxy.set_server(served->port());
  watcher.report("restart", trial, outage_s, std::nullopt, now_ns());
}

// A box that falls for 0.25 s and breaks, next to a soft cube.
constexpr const char* kFragileScene = R"({
  "environment": { "colliders": [ { "plane": {} } ] },
  "objects": [
    { "name": "box", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [-0.3, 0.4, 0] },
      "physics": { "behavior": "RIGID", "mass_kg": 1, "fragile": true, "break_impulse_n_s": 0.5 } },
    { "name": "cube", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0.3, 0.1, 0] },
      "physics": { "behavior": "ELASTIC", "density_kg_m3": 300, "youngs_modulus_pa": 2e4 } } ] })";

void kill_server(int trial, double outage_s, bool fragile) {
  const ScratchFolder folder;
  const std::string scene = folder.write("boxes.scene.json", fragile ? kFragileScene : kBoxesScene);
  const auto words = [&](const std::string& port) {
    return std::vector<std::string>{LIVEGS_SERVER, scene, "--listen", "127.0.0.1:" + port, "--print-port"};
  };
  auto server = std::make_unique<Program>(words("0"));
  const std::string port = server->first_line();
  if (port.empty()) give_up(server->err());
  Watcher watcher(std::atoi(port.c_str()));
  const int64_t begun_ns = now_ns();
  server->send(SIGKILL);
  server->wait();
  sleep_until_ns(begun_ns + static_cast<int64_t>(outage_s * 1e9));
  const int64_t started_ns = now_ns();
  server = std::make_unique<Program>(words(port));
  if (server->first_line() != port) give_up(server->err());
  const int64_t back_ns = now_ns();
  watcher.report(fragile ? "server killed; something breaks" : "server killed", trial, outage_s,
                 milliseconds_from_ns(back_ns - started_ns), back_ns, fragile);
}

}  // namespace

int main(int argc, char** argv) {
  set_log_level(LogLevel::Error);
  int trials = 10;
  CLI::App app("Time from the end of an outage to frames and pictures; CSV on standard output",
               "resume_bench");
  app.add_option("TRIALS", trials, "Number of trials per kind of outage")
      ->check(bench::between(1, 1000))
      ->capture_default_str();
  bench::read_arguments(app, argc, argv);
  std::printf(
      "fault,trial,outage_s,back_ms,frames_again_ms,picture_ms,goal_picture_ms,objects_told,assets_fetched,"
      "longest_gap_ms\n");
  for (int trial = 1; trial <= trials; ++trial) {
    cut(trial, 5.0);
    restart(trial, 2.0);
    kill_server(trial, 2.0, false);
    kill_server(trial, 2.0, true);
  }
  return 0;
}
