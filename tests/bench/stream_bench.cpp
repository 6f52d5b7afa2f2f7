// SPDX-License-Identifier: Apache-2.0
// A server and clients in one process over loopback: does the scene's rate hold, and how old is a frame when
// it comes? Prints CSV: `stream_bench [SECONDS [SCENE...]] > results/<machine>/stream.csv`. A scene is a file
// or a folder of assets; with none, a rigid box and a soft cube. Clients take frames and acknowledge them;
// they do not draw, so that the stream is measured and not the renderer. The first second does not count.
#include <cstdio>
#include <cstdlib>

#include "core/clock.h"
#include "core/log.h"
#include "server/session/box_scene.h"
#include "session/live_server.h"
#include "session/simulation_loop.h"
#include "stream/session_client.h"
#include "viewer/frame_log.h"

using namespace livegs;

namespace {

class Receiver final : public StreamSink {
 public:
  void on_frame(ReceivedFrame frame) override {
    if (first_ns_ == 0) first_ns_ = frame.received_ns;
    if (frame.received_ns - first_ns_ < 1'000'000'000) return;
    if (ages_ms.empty()) first_tick = frame.tick, begun_ns = frame.received_ns;
    last_tick = frame.tick;
    ended_ns = frame.received_ns;
    ages_ms.push_back(milliseconds_from_ns(frame.received_ns - frame.stepped_ns));
    bytes.push_back(static_cast<double>(frame.bytes));
    steps_ms.push_back(frame.step_ms);
  }
  void on_lost(const std::string&) override {}
  void on_resumed(const ResumedSession&) override {}
  void on_object_added(StreamedObject) override {}
  void on_object_changed(StreamedObject) override {}
  void on_object_removed(uint32_t) override {}
  void on_draining(const std::string&) override {}

  std::vector<double> ages_ms, bytes, steps_ms;
  uint64_t first_tick = 0, last_tick = 0;
  int64_t begun_ns = 0, ended_ns = 0;

 private:
  int64_t first_ns_ = 0;
};

void run(Scene scene, int clients, double seconds) {
  auto server = LiveServer::listen("127.0.0.1:0");
  if (!server) {
    std::fprintf(stderr, "%s\n", server.error().message.c_str());
    std::exit(1);
  }
  const std::string name = scene.name();
  SimulationLoop loop(std::move(scene), (*server)->ticks());
  (*server)->open(loop.scene(), loop);
  loop.start();
  const double rate_hz = loop.scene().world().settings().rate_hz;
  std::vector<Receiver> receivers(static_cast<size_t>(clients));
  std::vector<std::unique_ptr<SessionClient>> joined;
  for (Receiver& receiver : receivers) {
    auto client = SessionClient::join("127.0.0.1:" + std::to_string((*server)->port()), {});
    if (!client) {
      std::fprintf(stderr, "%s\n", client.error().message.c_str());
      std::exit(1);
    }
    joined.push_back(std::move(*client));
    joined.back()->start(receiver);
  }
  sleep_until_ns(now_ns() + static_cast<int64_t>((seconds + 1) * 1e9));
  for (auto& client : joined) (void)client->stop();
  (*server)->shut_down("done");
  loop.stop();

  const SimulationSummary simulated = loop.summary();
  const PublisherSummary published = (*server)->published();
  std::vector<double> ages_ms;
  for (const Receiver& receiver : receivers)
    ages_ms.insert(ages_ms.end(), receiver.ages_ms.begin(), receiver.ages_ms.end());
  const Receiver& first = receivers.front();
  std::printf(
      "%s,%d,%.0f,%.1f,%.2f,%.2f,%llu,%llu,%llu,%.0f,%.3f,%.3f,%.3f,%.3f,%.3f\n", name.c_str(), clients,
      seconds, rate_hz, static_cast<double>(simulated.ticks) / simulated.run_s,
      static_cast<double>(first.ages_ms.size() - 1) / seconds_from_ns(first.ended_ns - first.begun_ns),
      static_cast<unsigned long long>(first.last_tick - first.first_tick + 1 - first.ages_ms.size()),
      static_cast<unsigned long long>(simulated.late_ticks), static_cast<unsigned long long>(simulated.slips),
      percentile(first.bytes, 0.5), percentile(ages_ms, 0.50), percentile(ages_ms, 0.99),
      published.encode_ms_p50, simulated.step_ms_p50, simulated.step_ms_p99);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  set_log_level(LogLevel::Warn);
  const double seconds = argc > 1 ? std::atof(argv[1]) : 60.0;
  std::printf(
      "scene,clients,seconds,scene_hz,simulated_hz,received_hz,missed_ticks,late_ticks,slips,frame_bytes_p50,"
      "staleness_ms_p50,staleness_ms_p99,encode_ms_p50,step_ms_p50,step_ms_p99\n");
  if (argc <= 2) {
    for (int clients : {1, 8}) run(box_scene(), clients, seconds);
  }
  for (int i = 2; i < argc; ++i) {
    auto scene = Scene::load(argv[i], {});
    if (!scene) {
      std::fprintf(stderr, "%s\n", scene.error().message.c_str());
      return 2;
    }
    run(std::move(*scene), 1, seconds);
  }
  return 0;
}
