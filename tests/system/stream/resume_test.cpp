// SPDX-License-Identifier: Apache-2.0
// A client whose network or server fails, through a proxy that makes it fail.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <thread>

#include "client/stream/session/sink_log.h"
#include "core/clock.h"
#include "scratch_folder.h"
#include "stream/channel/retry_schedule.h"
#include "stream/session/session_client.h"
#include "system/support/fault_proxy.h"
#include "system/join_server.h"
#include "system/support/lateness.h"
#include "scenes/served_scene.h"
#include "viewer/runs/offscreen_run.h"

namespace livegs {
namespace {

constexpr int kNobody = 1;  // a port on which connections are refused at once

// The goals. `resume_bench` measured at most 135 and 136 ms of ten each (resume.csv, frames_again_ms; to the picture, picture_ms, 144
// and 145). Each time has to be within the goal, but that beside other work each of the waits on the way may be late, by two ticks at
// most: the pause, the connection's handshake, Join and its reply, the stream, its first message, the tick, the frame, and what hands
// them over on both sides.
constexpr double kAfterCut_ms = 300, kAfterRestart_ms = 500;
constexpr int kWaits = 10;
constexpr double kRetryPause_ms = 150;
constexpr size_t kTimes = 3;
constexpr int64_t kCut_ns = 5'000'000'000;

// How long after `moment_ns` the first frame came that came after it.
double first_frame_after_ms(const SinkLog::State& state, int64_t moment_ns) {
  for (const ReceivedFrame& frame : state.frames) {
    if (frame.received_ns > moment_ns) return milliseconds_from_ns(frame.received_ns - moment_ns);
  }
  return 1e9;
}

class Resume : public ::testing::Test {
 protected:
  void start(Scene scene, const ConnectOptions& options) {
    served_ = std::make_unique<ServedScene>(std::move(scene));
    proxy_ = std::make_unique<FaultProxy>(served_->port());
    client_ = join(proxy_->port(), options);
    ASSERT_TRUE(client_);
    client_->start(sink_);
    ASSERT_TRUE(sink_.wait_frames(5));
  }
  void start() { start(box_scene(), patient()); }
  // Also when an assertion left early: the sink goes last.
  ~Resume() override { client_.reset(); }

  std::unique_ptr<ServedScene> served_;
  std::unique_ptr<FaultProxy> proxy_;
  SinkLog sink_;
  std::unique_ptr<SessionClient> client_;
};

TEST_F(Resume, AResetConnectionLosesNeitherSessionNorScene) {
  start();
  proxy_->reset();
  ASSERT_TRUE(sink_.wait_resumed(1));
  ASSERT_TRUE(sink_.wait_frames(5));
  EXPECT_TRUE(client_->stop());
  const SinkLog::State state = sink_.state();
  EXPECT_EQ(state.lost.size(), 1u);
  EXPECT_TRUE(state.resumed.front().same_server);
  EXPECT_TRUE(state.added.empty() && state.changed.empty() && state.removed.empty());
  for (size_t i = 1; i < state.frames.size(); ++i) EXPECT_GT(state.frames[i].tick, state.frames[i - 1].tick);
  EXPECT_EQ(served_->server->sessions().sessions, 1u);  // it went on with the one it had
}

// Nobody is told of the cut: the client notices by the silence, the server too, and gives up the stream. It follows from a
// fresh connection every 150 ms, and that the first that can brings the frames.
TEST_F(Resume, AfterACutTheFirstConnectionBringsTheFrames) {
  start();
  const uint64_t before = proxy_->connections();
  proxy_->cut();
  const int64_t cut_ns = now_ns();
  ASSERT_TRUE(sink_.wait([](const SinkLog::State& state) { return !state.lost.empty(); }));
  EXPECT_GE(seconds_from_ns(now_ns() - cut_ns), 0.9);
  sleep_until_ns(cut_ns + kCut_ns);
  EXPECT_EQ(served_->server->streaming_count(), 0u);  // given up after two seconds and a sweep
  const uint64_t tried = proxy_->connections();
  EXPECT_GE(tried - before, 10u);
  Lateness lateness;
  proxy_->heal();
  const int64_t healed_ns = now_ns();
  ASSERT_TRUE(sink_.wait_resumed(1));
  const uint64_t needed = proxy_->connections() - tried;
  ASSERT_TRUE(sink_.wait_frames(20));
  const double late_ms = lateness.allowance_ms(kWaits), ms = first_frame_after_ms(sink_.state(), healed_ns);
  std::printf("moving %.0f ms after a cut of %.0f s healed (goal %.0f); the machine may be late by %.1f ms\n", ms, seconds_from_ns(kCut_ns),
              kAfterCut_ms, late_ms);
  EXPECT_LE(ms, kAfterCut_ms + late_ms);
  // The one that was being made, the first that can, and those for which there was time beyond the goal.
  EXPECT_LE(static_cast<double>(needed), 2 + std::ceil(std::max(0.0, ms - kAfterCut_ms) / kRetryPause_ms));
  const SinkLog::State state = sink_.state();
  EXPECT_TRUE(state.resumed.front().same_server);
  EXPECT_TRUE(state.added.empty() && state.changed.empty() && state.removed.empty());
  EXPECT_TRUE(client_->stop());
  EXPECT_EQ(served_->server->sessions().sessions, 1u);
}

// A second is what a silent server gets; a frame on its way takes longer.
TEST(NarrowLink, FramesOfKernelsThatTakeSecondsAreShown) {
  ServedScene served(box_scene());
  FaultProxy proxy(served.port());
  ConnectOptions options = patient();
  options.encoding = v1::JoinRequest::KERNELS;
  const auto join = [&] { return SessionClient::join("127.0.0.1:" + std::to_string(proxy.port()), options); };
  size_t bytes = 0;
  {
    SinkLog sink;
    auto client = join();
    ASSERT_TRUE(client) << client.error().message;
    (*client)->start(sink);
    ASSERT_TRUE(sink.wait_frames(1));
    EXPECT_TRUE((*client)->stop());
    bytes = sink.state().frames.front().bytes;
  }
  SinkLog sink;
  auto client = join();
  ASSERT_TRUE(client) << client.error().message;
  proxy.set_link({.mbit_s = 8e-6 * static_cast<double>(bytes) / 2.5});
  const int64_t begun_ns = now_ns();
  (*client)->start(sink);
  EXPECT_TRUE(sink.wait_frames(3));
  EXPECT_TRUE((*client)->stop());
  const SinkLog::State state = sink.state();
  EXPECT_TRUE(state.lost.empty()) << state.lost.front();
  ASSERT_FALSE(state.frames.empty());
  EXPECT_GT(seconds_from_ns(state.frames.front().received_ns - begun_ns), 1.5);
}

TEST(RetrySchedule, LeavesNoPauseLongerThanTheBarsAllow) {
  for (int64_t outage_s = 0; outage_s < 3600; ++outage_s) {
    int64_t least_ns = kLongRetryPause_ns, most_ns = 0;
    for (uint32_t random = 0; random < 4096; ++random) {
      const int64_t pause_ns = retry_pause_ns(outage_s * 1'000'000'000, random * 2654435761u);
      least_ns = std::min(least_ns, pause_ns);
      most_ns = std::max(most_ns, pause_ns);
    }
    // Half of the 300 ms for a cut, most of the 500 ms for a server that comes back.
    EXPECT_LE(most_ns, outage_s < 60 ? 150'000'000 : 400'000'000);
    EXPECT_LT(least_ns, most_ns * 0.81);  // clients do not come in step
    EXPECT_GE(least_ns, most_ns * 0.79);
  }
}

// The server's end, as a client sees it: its connections are reset and its port answers no more.
TEST_F(Resume, AServerThatIsStartedAnewHasTheSameScene) {
  start();
  for (size_t ends = 1; ends <= kTimes; ++ends) {
    proxy_->set_server(kNobody);
    proxy_->reset();
    ASSERT_TRUE(sink_.wait([&](const SinkLog::State& state) { return state.lost.size() >= ends; }));
    served_ = std::make_unique<ServedScene>(box_scene());
    Lateness lateness;
    proxy_->set_server(served_->port());
    const int64_t back_ns = now_ns();
    ASSERT_TRUE(sink_.wait_resumed(ends));
    ASSERT_TRUE(sink_.wait_frames(20));
    const double late_ms = lateness.allowance_ms(kWaits), ms = first_frame_after_ms(sink_.state(), back_ns);
    std::printf("moving %.0f ms after the server was back (goal %.0f); the machine may be late by %.1f ms\n", ms, kAfterRestart_ms, late_ms);
    EXPECT_LE(ms, kAfterRestart_ms + late_ms);
  }
  EXPECT_TRUE(client_->stop());
  const SinkLog::State state = sink_.state();
  EXPECT_FALSE(state.resumed.back().same_server);
  EXPECT_TRUE(state.added.empty() && state.changed.empty() && state.removed.empty());
  const ReceivedFrame &before = state.frames.front(), &after = state.frames.back();
  ASSERT_EQ(before.drivers->objects.size(), after.drivers->objects.size());
  for (size_t i = 0; i < before.drivers->objects.size(); ++i) {
    EXPECT_EQ(before.drivers->objects[i].object_id, after.drivers->objects[i].object_id);
  }
}

TEST_F(Resume, WhatChangedWhileItWasGoneIsToldBeforeTheNextFrame) {
  start(breaking_scene(), patient());
  proxy_->cut();
  ASSERT_TRUE(sink_.wait([](const SinkLog::State& state) { return !state.lost.empty(); }));
  while (served_->tick < 120) std::this_thread::sleep_for(std::chrono::milliseconds(10));  // it broke at 90
  proxy_->heal();
  ASSERT_TRUE(sink_.wait_resumed(1));
  ASSERT_TRUE(sink_.wait([](const SinkLog::State& state) {
    return !state.changed.empty() && state.frames.back().drivers->objects.back().revision > 0;
  }));
  EXPECT_TRUE(client_->stop());
  const SinkLog::State state = sink_.state();
  EXPECT_TRUE(state.added.empty() && state.removed.empty());
  const uint32_t revision = state.frames.back().drivers->objects.back().revision;
  EXPECT_TRUE(std::any_of(state.changed.begin(), state.changed.end(),
                          [&](const StreamedObject& object) { return object.rest.revision == revision; }));
}

TEST_F(Resume, AServerThatStaysAwayEndsTheSessionInTime) {
  ConnectOptions options = patient();
  options.reconnect_s = 0.5;
  start(box_scene(), options);
  proxy_->set_server(kNobody);
  proxy_->reset();
  const int64_t reset_ns = now_ns();
  while (!client_->ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_GE(seconds_from_ns(now_ns() - reset_ns), 0.4);
  const auto stopped = client_->stop();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::Unavailable);
  EXPECT_NE(stopped.error().message.find("went away"), std::string::npos) << stopped.error().message;
}

TEST_F(Resume, AGoodbyeEndsTheSessionUnlessItIsToBeOutlived) {
  start();
  served_->server->shut_down("maintenance");
  while (!client_->ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_TRUE(client_->stop());
  EXPECT_EQ(sink_.state().draining, "maintenance");
  EXPECT_TRUE(sink_.state().lost.empty());
}

TEST_F(Resume, AGoodbyeIsOutlived) {
  ConnectOptions options = patient();
  options.outlive_draining = true;
  start(box_scene(), options);
  served_->server->shut_down("maintenance");
  served_ = std::make_unique<ServedScene>(box_scene());
  proxy_->set_server(served_->port());
  ASSERT_TRUE(sink_.wait_resumed(1));
  EXPECT_TRUE(client_->stop());
  EXPECT_EQ(sink_.state().draining, "maintenance");
}

// The offscreen client through a restart in which things became others: the last picture stays until the new server's
// first frame, its objects are fetched and drawn, and the video's time goes on.
TEST(OffscreenRun, GoesOnWithAServerThatWasStartedAnew) {
  auto served = std::make_unique<ServedScene>(box_scene());
  FaultProxy proxy(served->port());
  const ScratchFolder folder;
  OffscreenRunOptions run;
  run.address = "127.0.0.1:" + std::to_string(proxy.port());
  run.seconds = 0;
  run.output = folder / "view";
  run.cache = folder / "cache";
  run.size = PictureSize{64, 48};
  run.video = false;
  run.png_every = 0;
  run.renderer = RendererChoice::Cpu;
  run.connect_timeout_s = run.reconnect_s = 60;
  std::atomic<bool> interrupted{false};
  Result<OffscreenRunSummary> summary = Error{};
  std::thread client([&] { summary = run_offscreen(run, interrupted); });
  const auto pause = [] { std::this_thread::sleep_for(std::chrono::milliseconds(300)); };
  while (served->server->streaming_count() == 0) pause();
  pause();
  proxy.set_server(kNobody);
  proxy.reset();
  pause();
  served = std::make_unique<ServedScene>(box_scene(90, 0.25));
  proxy.set_server(served->port());
  while (served->server->streaming_count() == 0) pause();
  pause();
  interrupted = true;
  client.join();
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_FALSE(summary->stream_error) << summary->stream_error->message;
  EXPECT_EQ(summary->outages.count, 1u);
  EXPECT_EQ(summary->outages.resumed, 1u);
  EXPECT_EQ(summary->outages.restarted, 1u);
  EXPECT_GT(summary->outages.seconds, 0.3);
  EXPECT_EQ(summary->assets.assets, 5u);  // the first three, and another box and floor; the cube is what it was
  EXPECT_NE(summary_text(*summary).find("came back 1 times"), std::string::npos) << summary_text(*summary);
  std::ifstream file(run.output / "timings.csv");
  std::string line;
  std::getline(file, line);
  size_t pictures = 0;
  while (std::getline(file, line)) ++pictures;
  // 30 a second of all the time there was, the outage included: three pauses of 0.3 s at the least.
  EXPECT_GE(pictures, 27u);
}

}  // namespace
}  // namespace livegs
