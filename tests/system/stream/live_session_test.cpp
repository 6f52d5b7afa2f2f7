// SPDX-License-Identifier: Apache-2.0
// Server and client in one process over loopback, so that both ends of the same tick can be compared.
#include <gtest/gtest.h>

#include <cmath>

#include <fstream>
#include <map>
#include <thread>

#include "core/file.h"
#include "render/scene_view.h"
#include "scenes/box_scene.h"
#include "scratch_folder.h"
#include "server/session/simulation/tick_log.h"
#include "session/rpc/grpc_server.h"
#include "session/simulation/simulation_loop.h"
#include "splat/camera_file.h"
#include "viewer/runs/offscreen_run.h"
#include "wire/frame_codec.h"

namespace livegs {
namespace {

// Ticks of the received frames, in order.
class FrameTicks final : public StreamSink {
 public:
  void on_lost(const std::string&) override {}
  void on_resumed(const ResumedSession&) override {}
  void on_frame(ReceivedFrame frame) override {
    std::lock_guard lock(mutex_);
    ticks_.push_back(frame.tick);
    changed_.notify_all();
  }
  void on_object_added(StreamedObject) override {}
  void on_object_changed(StreamedObject) override {}
  void on_object_removed(uint32_t) override {}
  void on_draining(const std::string&) override {}
  // Waits for this number of frames and returns the ticks of the last ones.
  std::vector<uint64_t> wait(size_t frames) {
    std::unique_lock lock(mutex_);
    const size_t begin = ticks_.size();
    changed_.wait(lock, [&] { return ticks_.size() >= begin + frames; });
    return {ticks_.begin() + static_cast<std::ptrdiff_t>(begin), ticks_.end()};
  }

 private:
  std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  std::vector<uint64_t> ticks_;
};

class SessionPrograms : public ::testing::Test {
 protected:
  void start(double rate_hz = 90) { start(box_scene(rate_hz)); }
  // `waits`: the first tick waits for a streaming client.
  void start(Scene built, bool waits = false) {
    auto server = GrpcServer::listen("127.0.0.1:0");
    ASSERT_TRUE(server) << server.error().message;
    server_ = std::move(*server);
    loop_ = std::make_unique<SimulationLoop>(std::move(built), server_->ticks(), [this](const Scene& scene) {
      std::lock_guard lock(mutex_);
      simulated_[scene.world().tick()] = scene.world().drivers();
      newest_tick_ = scene.world().tick();
      for (const SceneObject& object : scene.objects()) {
        objects_.try_emplace({object.id, object.rest.revision}, object);
      }
      ticked_.notify_all();
    });
    server_->open(loop_->scene(), *loop_);
    if (!waits) return loop_->start();
    starter_ = std::jthread([this](const std::stop_token& over) {
      while (server_->streaming_count() == 0 && !over.stop_requested())
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      loop_->start();
    });
  }
  void TearDown() override {
    starter_ = {};
    if (server_) server_->shut_down("the test is over");
    if (loop_) loop_->stop();
  }
  OffscreenRunOptions options(const std::string& name, double seconds) {
    OffscreenRunOptions run;
    run.address = "127.0.0.1:" + std::to_string(server_->port());
    run.seconds = seconds;
    run.output = folder_ / name;
    run.size = PictureSize{160, 120};
    run.video = false;
    run.png_every = 0;
    run.cache = folder_ / "cache";
    run.connect_timeout_s = 30;
    return run;
  }
  // The server's own drivers at a tick, before quantisation.
  DriverFrame simulated(uint64_t tick) {
    std::lock_guard lock(mutex_);
    return simulated_.at(tick);
  }

  // Adds the objects of a frame with the asset revisions of that time.
  void add_objects(const DriverFrame& frame, SceneView& view) {
    std::lock_guard lock(mutex_);
    for (const ObjectDrivers& drivers : frame.objects) {
      const SceneObject& object = objects_.at({drivers.object_id, drivers.revision});
      ASSERT_TRUE(view.add(object.id, object.asset, object.rest, object.environment));
    }
  }

  // Reads the last picture of a run, and draws the same view from the server's own drivers.
  void read_last(const OffscreenRunOptions& run, Image& last, Image& own) {
    const auto bytes = read_file(run.output / "last_frame.bin");
    ASSERT_TRUE(bytes);
    const auto streamed = decode_frame(*bytes);
    ASSERT_TRUE(streamed) << streamed.error().message;
    read_last(run, streamed->tick, last, own);
  }
  void read_last(const OffscreenRunOptions& run, uint64_t tick, Image& last, Image& own) {
    const DriverFrame drivers = simulated(tick);
    const auto camera = read_camera_file(run.output / "camera.json", std::nullopt);
    ASSERT_TRUE(camera) << camera.error().message;
    SceneView view;
    add_objects(drivers, view);
    std::vector<Image> offline;
    ASSERT_TRUE(view.draw(drivers, {&*camera, 1}, offline));
    own = offline.at(0);
    const auto picture = read_png(run.output / "last.png");
    ASSERT_TRUE(picture) << picture.error().message;
    last = *picture;
  }

  ScratchFolder folder_;
  // Polls until this number of clients has joined.
  bool wait_clients(size_t count) {
    std::unique_lock lock(mutex_);
    return ticked_.wait_for(lock, kPatience, [&] { return server_->client_count() == count; });
  }

  std::mutex mutex_;  // guards the next three
  std::condition_variable ticked_;
  std::map<uint64_t, DriverFrame> simulated_;
  std::map<std::pair<uint32_t, uint32_t>, SceneObject> objects_;  // by id and revision
  uint64_t newest_tick_ = 0;
  std::unique_ptr<GrpcServer> server_;
  std::unique_ptr<SimulationLoop> loop_;
  std::jthread starter_;
  std::atomic<bool> interrupted_{false};
};

std::vector<uint64_t> ticks_of(const std::filesystem::path& csv) {
  std::ifstream file(csv);
  std::string line;
  std::getline(file, line);
  std::vector<uint64_t> ticks;
  while (std::getline(file, line)) ticks.push_back(std::stoull(line));
  return ticks;
}

TEST_F(SessionPrograms, LastPictureMatchesOfflineDraw) {
  start();
  OffscreenRunOptions run = options("view", 3.0);
  run.poke = "cube";
  const auto summary = run_offscreen(run, interrupted_);
  ASSERT_TRUE(summary) << summary.error().message;
  ASSERT_FALSE(summary->stream_error) << summary->stream_error->message;
  Image last, own;
  ASSERT_NO_FATAL_FAILURE(read_last(run, last, own));
  // Rounding to 8 bits alone gives 58.9 dB (255 sqrt(12)). 50 dB is an RMS error of 0.8 of 255.
  EXPECT_GE(psnr_db(last, own), 50.0);
  // The picture is not empty: the objects differ from the background.
  const auto [darkest, brightest] = std::minmax_element(last.pixels.begin(), last.pixels.end());
  EXPECT_GT(*brightest - *darkest, 0.3f);
}

// Frames without news take the place of keepalives; a motion is sent in every tick again.
TEST_F(SessionPrograms, SceneAtRestSendsFewFrames) {
  start();
  ConnectOptions connect;
  connect.timeout_s = connect.reconnect_s = 60;
  auto client = SessionClient::join("127.0.0.1:" + std::to_string(server_->port()), connect);
  ASSERT_TRUE(client) << client.error().message;
  FrameTicks frames;
  (*client)->start(frames);
  constexpr double kRestTicks = 13;  // kRestInterval_ns at 90 Hz
  const auto interval = [&](size_t count) {
    const std::vector<uint64_t> ticks = frames.wait(count + 1);
    return static_cast<double>(ticks.back() - ticks.front()) / static_cast<double>(ticks.size() - 1);
  };
  double rest = 0;
  for (int i = 0; i < 1000 && rest < 0.9 * kRestTicks; ++i) rest = interval(5);
  EXPECT_GE(rest, 0.9 * kRestTicks) << "the bodies sleep";
  InputSample shot;
  for (const bool shoots : {true, false}) {
    ++shot.sequence;
    shot.hands[1].active = true;
    shot.hands[1].aim.position_m = {0, 1.5, 2};
    shot.hands[1].shoot = shoots;
    (*client)->send(shot);
  }
  double motion = kRestTicks;
  for (int i = 0; i < 10 && motion > 0.25 * kRestTicks; ++i) motion = interval(10);
  EXPECT_LE(motion, 0.25 * kRestTicks) << "a machine that is busy may drop frames";
  ASSERT_TRUE((*client)->stop());
}

// All encodings give the same picture: quantised drivers, float drivers, and kernels that the server has
// posed. In the scene an object breaks and gets a new asset.
TEST_F(SessionPrograms, EncodingsShowTheSamePictureAfterABreak) {
  start(breaking_scene(90, 1, 0.3), true);
  for (const auto encoding :
       {v1::JoinRequest::KERNELS, v1::JoinRequest::DRIVERS_RAW, v1::JoinRequest::KERNELS_EXACT}) {
    OffscreenRunOptions run =
        options(v1::JoinRequest::Encoding_Name(encoding), encoding == v1::JoinRequest::KERNELS ? 5.0 : 1.5);
    run.encoding = encoding;
    const auto summary = run_offscreen(run, interrupted_);
    ASSERT_TRUE(summary) << summary.error().message;
    ASSERT_FALSE(summary->stream_error) << summary->stream_error->message;
    const std::vector<uint64_t> ticks = ticks_of(run.output / "frames.csv");
    ASSERT_GE(ticks.size(), 2u);
    ASSERT_GE(simulated(ticks.back()).objects.back().revision, 1u);
    Image last, own;
    ASSERT_NO_FATAL_FAILURE(read_last(run, ticks.back(), last, own));
    // 50 dB as above; float drivers only round to 8 bits.
    EXPECT_GE(psnr_db(last, own), encoding == v1::JoinRequest::KERNELS ? 50.0 : 57.0);
    std::printf("%s: %.1f dB, %.0f bytes a frame\n", v1::JoinRequest::Encoding_Name(encoding).c_str(),
                psnr_db(last, own), summary->received.bytes_p50);
  }
}

// The same with the Vulkan renderer, if there is a device (lavapipe in CI).
TEST_F(SessionPrograms, LastVulkanPictureMatchesReference) {
  if (const auto device = VulkanDevice::create(); !device) GTEST_SKIP() << device.error().message;
  start();
  OffscreenRunOptions run = options("view", 1.0);
  run.renderer = RendererChoice::Vulkan;
  run.video_rate_hz = 4;
  const auto summary = run_offscreen(run, interrupted_);
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(summary->renderer.rfind("vulkan: ", 0), 0u) << summary->renderer;
  Image last, own;
  ASSERT_NO_FATAL_FAILURE(read_last(run, last, own));
  EXPECT_GE(psnr_db(last, own), 50.0);
}

// Assets created during the session are compared with the reference renderer too: fragments with their cut
// faces, and balls.
TEST_F(SessionPrograms, VulkanFragmentsAndBallsMatchReference) {
  if (const auto device = VulkanDevice::create(); !device) GTEST_SKIP() << device.error().message;
  Scene scene = breaking_scene(90, 1, 0.3);
  const size_t whole_kernels = scene.find("box")->asset->size();
  start(std::move(scene), true);
  // Shots are frequent enough that a ball is in flight when the session ends.
  std::string shots;
  for (double time_s = 0.2; time_s < 4; time_s += 0.15)
    shots += (shots.empty() ? "" : ", ") +
             (R"({ "ball": { "object": "box", "time_s": )" + std::to_string(time_s)) + " } }";
  std::ofstream(folder_ / "script.json") << R"({ "actions": [ )" << shots << " ] }";
  OffscreenRunOptions run = options("view", 4.0);
  run.renderer = RendererChoice::Vulkan;
  run.video_rate_hz = 4;
  run.script_file = folder_ / "script.json";
  const auto summary = run_offscreen(run, interrupted_);
  ASSERT_TRUE(summary) << summary.error().message;
  ASSERT_FALSE(summary->stream_error) << summary->stream_error->message;
  EXPECT_EQ(summary->renderer.rfind("vulkan: ", 0), 0u) << summary->renderer;
  EXPECT_EQ(summary->notice, "");

  const auto bytes = read_file(run.output / "last_frame.bin");
  ASSERT_TRUE(bytes);
  const auto frame = decode_frame(*bytes);
  ASSERT_TRUE(frame) << frame.error().message;
  size_t balls = 0, fragments = 0;
  for (const ObjectDrivers& drivers : frame->objects) {
    std::lock_guard lock(mutex_);
    const SceneObject& object = objects_.at({drivers.object_id, drivers.revision});
    if (object.asset == Scene::ball_asset()) ++balls;
    if (object.name != "box") continue;
    fragments = drivers.poses.size();
    EXPECT_GE(drivers.revision, 1u);
    EXPECT_GT(object.asset->size(), whole_kernels);
  }
  EXPECT_GE(balls, 1u);
  EXPECT_GE(fragments, 2u);

  Image last, own;
  ASSERT_NO_FATAL_FAILURE(read_last(run, last, own));
  const auto camera = read_camera_file(run.output / "camera.json", std::nullopt);
  ASSERT_TRUE(camera);
  // The comparison detects missing objects: a missing ball, or the floor in place of the fragments.
  const auto without = [&](const auto& left_out) {
    DriverFrame drivers = simulated(frame->tick);
    std::erase_if(drivers.objects, [&](const ObjectDrivers& one) {
      std::lock_guard lock(mutex_);
      return left_out(objects_.at({one.object_id, one.revision}));
    });
    SceneView view;
    add_objects(drivers, view);
    std::vector<Image> picture;
    EXPECT_TRUE(view.draw(drivers, {&*camera, 1}, picture));
    return picture.at(0);
  };
  const double no_balls_db =
      psnr_db(without([](const SceneObject& one) { return one.asset == Scene::ball_asset(); }), own);
  const double no_fragments_db =
      psnr_db(without([](const SceneObject& one) { return one.name == "box"; }), own);
  std::printf("%s: %zu fragments and %zu balls, %.1f dB; %.1f without balls, %.1f without fragments\n",
              summary->renderer.c_str(), fragments, balls, psnr_db(last, own), no_balls_db, no_fragments_db);
  EXPECT_GE(psnr_db(last, own), 50.0);
  EXPECT_LT(no_fragments_db, 40.0);
  EXPECT_LT(no_balls_db, 40.0);
}

// A break as seen by a client that is connected, and by one that joins afterwards.
TEST_F(SessionPrograms, BreakReachesConnectedAndLaterClients) {
  start(breaking_scene(90, 1, 0.3), true);
  for (const char* name : {"there", "later"}) {
    const OffscreenRunOptions run = options(name, std::string(name) == "there" ? 5.0 : 1.0);
    const auto summary = run_offscreen(run, interrupted_);
    ASSERT_TRUE(summary) << summary.error().message;
    ASSERT_FALSE(summary->stream_error) << summary->stream_error->message;
    EXPECT_NE(summary->object_summaries.at(0).find("broken into"), std::string::npos)
        << summary->object_summaries.at(0);
    const auto bytes = read_file(run.output / "last_frame.bin");
    ASSERT_TRUE(bytes);
    const auto streamed = decode_frame(*bytes);
    ASSERT_TRUE(streamed) << streamed.error().message;
    EXPECT_GE(streamed->objects.back().revision, 1u);
    EXPECT_GE(streamed->objects.back().poses.size(), 2u);
    const auto camera = read_camera_file(run.output / "camera.json", std::nullopt);
    ASSERT_TRUE(camera) << camera.error().message;
    const DriverFrame own = simulated(streamed->tick);
    SceneView view;
    add_objects(own, view);
    std::vector<Image> offline;
    ASSERT_TRUE(view.draw(own, {&*camera, 1}, offline));
    const auto last = read_png(run.output / "last.png");
    ASSERT_TRUE(last) << last.error().message;
    EXPECT_GE(psnr_db(*last, offline.at(0)), 50.0);
  }
}

TEST_F(SessionPrograms, FramesAreOrderedAndWithinQuantisation) {
  start();
  const auto summary = run_offscreen(options("view", 3.0), interrupted_);
  ASSERT_TRUE(summary) << summary.error().message;
  const std::vector<uint64_t> ticks = ticks_of(folder_ / "view" / "frames.csv");
  ASSERT_GE(ticks.size(), 2u);
  EXPECT_EQ(std::adjacent_find(ticks.begin(), ticks.end(), std::greater_equal<>()), ticks.end());
  EXPECT_EQ(summary->received.frames, ticks.size());
  EXPECT_EQ(summary->received.missed_ticks, ticks.back() - ticks.front() + 1 - ticks.size());
  const auto bytes = read_file(folder_ / "view" / "last_frame.bin");
  ASSERT_TRUE(bytes);
  const auto streamed = decode_frame(*bytes);
  ASSERT_TRUE(streamed);
  const DriverFrame own = simulated(streamed->tick);
  ASSERT_EQ(own.objects.size(), streamed->objects.size());
  for (size_t i = 0; i < own.objects.size(); ++i) {
    ASSERT_EQ(own.objects[i].positions_m.size(), streamed->objects[i].positions_m.size());
    for (size_t n = 0; n < own.objects[i].positions_m.size(); ++n) {
      // Half a quantisation step of the stream (15/16 of 2^-14 m) plus that of the file (16 bits over a box
      // of less than 0.5 m).
      EXPECT_LT((own.objects[i].positions_m[n] - streamed->objects[i].positions_m[n]).cwiseAbs().maxCoeff(),
                0.9375f * std::exp2(-15.0f) + 0.25f / 65535);
    }
  }
}

TEST_F(SessionPrograms, PokeMovesItsObjectAndShotAddsABall) {
  start();
  const uint32_t box = loop_->scene().find("box")->id;
  std::ofstream(folder_ / "script.json") << R"({ "actions": [
    { "poke": { "object": "box", "start_s": 0.3, "pull_m": [0, 0.5, 0], "pull_s": 0.5, "hold_s": 20 } },
    { "ball": { "time_s": 0.5, "object": "cube" } } ] })";
  OffscreenRunOptions run = options("view", 3.0);
  run.script_file = folder_ / "script.json";
  const auto summary = run_offscreen(run, interrupted_);
  ASSERT_TRUE(summary) << summary.error().message;
  const auto bytes = read_file(run.output / "last_frame.bin");
  ASSERT_TRUE(bytes);
  const auto frame = decode_frame(*bytes);
  ASSERT_TRUE(frame);
  EXPECT_GT(middle_of(*frame, box).y(), 0.2);  // from 0.1 m; the ray holds the box 0.5 m higher
  EXPECT_EQ(frame->objects.size(), 4u);        // floor, box, cube and ball
  EXPECT_EQ(loop_->summary().shots, 1u);
}

// An unknown object of a grab action is reported like that of any other action.
TEST_F(SessionPrograms, ScriptGrabsAndCarriesItsObject) {
  start();
  const uint32_t box = loop_->scene().find("box")->id;
  OffscreenRunOptions run = options("view", 4.0);
  run.script_file = folder_ / "script.json";
  const auto grab =
      [&](const std::string& name) {
        std::ofstream(run.script_file)
            << R"({ "actions": [ { "grab": { "object": ")" << name
            << R"(", "start_s": 0.3, "move_m": [0, 0.5, 0], "move_s": 0.5, "hold_s": 20 } } ] })";
        return run_offscreen(run, interrupted_);
      };
  const auto unknown = grab("hat");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::NotFound);
  EXPECT_NE(unknown.error().message.find("\"hat\""), std::string::npos) << unknown.error().message;
  const auto summary = grab("box");
  ASSERT_TRUE(summary) << summary.error().message;
  const auto bytes = read_file(run.output / "last_frame.bin");
  ASSERT_TRUE(bytes);
  const auto frame = decode_frame(*bytes);
  ASSERT_TRUE(frame);
  EXPECT_GT(middle_of(*frame, box).y(), 0.4);  // from 0.1 m
}

TEST_F(SessionPrograms, TwoClientsSeeTheSameFrames) {
  start();
  Result<OffscreenRunSummary> other = Error{};
  std::thread second([&] { other = run_offscreen(options("other", 1.0), interrupted_); });
  const auto summary = run_offscreen(options("view", 1.0), interrupted_);
  second.join();
  ASSERT_TRUE(summary) << summary.error().message;
  ASSERT_TRUE(other) << other.error().message;
  EXPECT_GT(summary->received.frames, 0u);
  EXPECT_GT(other->received.frames, 0u);
  // Both clients share a cache folder, so each asset is fetched once in total.
  EXPECT_EQ(summary->assets.fetched + other->assets.fetched, summary->assets.assets);
}

TEST_F(SessionPrograms, CachedAssetIsNotFetchedAgain) {
  start();
  const auto first = run_offscreen(options("first", 0.1), interrupted_);
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_GT(first->assets.fetched_bytes, 0u);
  const auto second = run_offscreen(options("second", 0.1), interrupted_);
  ASSERT_TRUE(second) << second.error().message;
  EXPECT_EQ(second->assets.fetched_bytes, 0u);
  EXPECT_EQ(second->assets.assets, first->assets.assets);
}

TEST_F(SessionPrograms, PictureTimesAreEvenlySpaced) {
  start();
  OffscreenRunOptions run = options("view", 1.0);
  run.video_rate_hz = 30;
  run.png_every = 1;  // otherwise only the first and the last picture are drawn
  const auto summary = run_offscreen(run, interrupted_);
  ASSERT_TRUE(summary) << summary.error().message;
  std::ifstream file(run.output / "timings.csv");
  std::string line;
  std::getline(file, line);
  std::vector<double> times_s;
  while (std::getline(file, line)) times_s.push_back(std::stod(line.substr(line.find(',') + 1)));
  ASSERT_GT(times_s.size(), 3u);
  // The last picture is the last frame itself and is excluded. Times are written with microsecond resolution.
  for (size_t i = 1; i + 1 < times_s.size(); ++i) EXPECT_NEAR(times_s[i] - times_s[i - 1], 1.0 / 30, 2e-6);
}

TEST_F(SessionPrograms, ServerShutdownEndsClientWithoutError) {
  start();
  Result<OffscreenRunSummary> summary = Error{};
  std::thread client([&] { summary = run_offscreen(options("view", 0), interrupted_); });
  // The client has joined. Its stream is open by the time another client has received one second.
  EXPECT_TRUE(wait_clients(1));
  EXPECT_TRUE(run_offscreen(options("probe", 1.0), interrupted_));
  server_->shut_down("the test is over");
  client.join();
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_FALSE(summary->stream_error) << summary->stream_error->message;
}

}  // namespace
}  // namespace livegs
