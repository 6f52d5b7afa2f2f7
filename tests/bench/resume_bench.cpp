// SPDX-License-Identifier: Apache-2.0
// How long until frames come again: after a network of so many seconds of cut heals, and after a server is back. CSV on
// standard output, a row a trial.
//   resume_bench [TRIALS]      10 of each when left out
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "client/stream/sink_log.h"
#include "core/log.h"
#include "stream/session_client.h"
#include "system/fault_proxy.h"
#include "system/served_scene.h"

using namespace livegs;

namespace {

constexpr int kNobody = 1;  // a port on which connections are refused at once

void trial(int number, bool restart, double outage_s) {
  auto served = std::make_unique<ServedScene>(box_scene());
  FaultProxy proxy(served->port());
  ConnectOptions options;
  options.timeout_s = options.reconnect_s = 60;
  auto client = SessionClient::join("127.0.0.1:" + std::to_string(proxy.port()), options);
  if (!client) {
    std::fprintf(stderr, "%s\n", client.error().message.c_str());
    std::exit(1);
  }
  SinkLog sink;
  (*client)->start(sink);
  (void)sink.wait_frames(20);
  const int64_t begun_ns = now_ns();
  if (restart) {
    proxy.set_server(kNobody);
    proxy.reset();
  } else {
    proxy.cut();
  }
  sleep_until_ns(begun_ns + static_cast<int64_t>(outage_s * 1e9));
  if (restart) {
    served = std::make_unique<ServedScene>(box_scene());  // takes a while to build, and longer to end the old one
    proxy.set_server(served->port());
  } else {
    proxy.heal();
  }
  const int64_t back_ns = now_ns();
  (void)sink.wait_resumed(1);
  (void)(*client)->stop();
  const SinkLog::State state = sink.state();
  for (const ReceivedFrame& frame : state.frames) {
    if (frame.received_ns <= back_ns) continue;
    std::printf("%s,%d,%.1f,%.0f,%zu\n", restart ? "restart" : "cut", number, outage_s,
                milliseconds_from_ns(frame.received_ns - back_ns),
                state.added.size() + state.changed.size() + state.removed.size());
    std::fflush(stdout);
    break;
  }
}

}  // namespace

int main(int argc, char** argv) {
  set_log_level(LogLevel::Error);
  const int trials = argc > 1 ? std::atoi(argv[1]) : 10;
  std::printf("fault,trial,outage_s,frames_again_ms,objects_told\n");
  for (int i = 1; i <= trials; ++i) {
    trial(i, false, 5.0);
    trial(i, true, 2.0);
  }
  return 0;
}
