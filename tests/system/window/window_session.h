// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <signal.h>

#include <map>
#include <mutex>

#include "splat/camera_file.h"
#include "stream/session/session_client.h"
#include "system/window/window_hands.h"
#include "viewer/camera/orbit_camera.h"
#include "viewer/runs/window_run.h"

namespace livegs {

// Records the scene as a second client receives it.
class Watcher final : public StreamSink {
 public:
  struct Seen {
    std::map<std::string, StreamedObject> objects;  // by name
    std::map<std::string, Eigen::Vector3d> places;  // of rigid objects
    size_t added = 0;
    v1::RunState run;
  };
  Seen seen() {
    std::lock_guard lock(mutex_);
    return seen_;
  }
  StreamedObject object(const std::string& name) { return seen().objects[name]; }
  void know(const StreamedObject& object) {
    std::lock_guard lock(mutex_);
    names_[object.id] = object.name;
    seen_.objects[object.name] = object;
  }

  void on_lost(const std::string&) override {}
  void on_resumed(const ResumedSession&) override {}
  void on_frame(ReceivedFrame frame) override {
    std::lock_guard lock(mutex_);
    seen_.run = frame.run;
    for (const ObjectDrivers& drivers : frame.drivers->objects) {
      const auto name = names_.find(drivers.object_id);
      if (name != names_.end() && !drivers.poses.empty())
        seen_.places[name->second] = drivers.poses[0].position_m;
    }
  }
  void on_object_added(StreamedObject object) override {
    know(object);
    std::lock_guard lock(mutex_);
    ++seen_.added;
  }
  void on_object_changed(StreamedObject object) override { know(object); }
  void on_object_removed(uint32_t) override {}
  void on_draining(const std::string&) override {}

 private:
  std::mutex mutex_;  // guards the rest
  Seen seen_;
  std::map<uint32_t, std::string> names_;
};

// A box of 1 kg and a soft cushion. The user may change the cushion's unspecified values.
inline constexpr const char* kCushionScene = R"({
  "environment": { "colliders": [ { "plane": {} } ] },
  "objects": [
    { "name": "box", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [-0.3, 0.1, 0] },
      "physics": { "behavior": "RIGID", "mass_kg": 1 } },
    { "name": "cushion", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0.3, 0.1, 0] },
      "physics": { "behavior": "ELASTIC" } } ] })";

// The desktop window with scripted input, a server, and a second client that records the effects.
class WindowClicks : public WindowHands {
 protected:
  void SetUp() override {
    WindowHands::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    const std::filesystem::path scene = folder_.write("clicks.scene.json", scene_text());
    prepare(scene);
    std::vector<std::string> words = server_words();
    words.at(1) = scene;
    server_ = std::make_unique<Program>(words);
    const std::string port = server_->first_line();
    ASSERT_NE(port, "") << server_->err();
    address_ = "127.0.0.1:" + port;
    ConnectOptions connect;
    connect.timeout_s = connect.reconnect_s = 60;
    auto joined = SessionClient::join(address_, connect);
    ASSERT_TRUE(joined) << joined.error().message;
    watching_ = std::move(*joined);
    for (const StreamedObject& object : watching_->scene().objects) watcher_.know(object);
    watching_->start(watcher_);
  }
  void TearDown() override {
    if (watching_) (void)watching_->stop();
    if (server_) server_->send(SIGTERM);
  }
  virtual std::string scene_text() const { return kCushionScene; }
  // Called before the server starts.
  virtual void prepare(const std::filesystem::path& /*scene*/) {}
  virtual std::string camera_text() const {
    return R"({ "position_m": [-0.05, 0.5, 2.2], "look_at_m": [-0.05, 0.25, 0], "vertical_fov_deg": 40 })";
  }

  void run_steps() {
    WindowRunOptions options;
    options.address = address_;
    options.cache = folder_ / "window_cache";
    options.renderer = RendererChoice::Cpu;
    options.size = PictureSize{kWidth, kHeight};
    options.full_size = !reduced_;
    options.camera_file = camera_file();
    std::atomic<bool> interrupted{false};
    options.on_picture = [&](const Image& shown, const RunPanel& run) {
      run_ = run;
      see(shown, "LiveGS " + address_, interrupted);
    };
    const auto done = run_window(options, interrupted);
    EXPECT_TRUE(done) << done.error().message;
    expect_all_done();
  }

  // Path of the camera file; empty if camera_text() is empty.
  std::filesystem::path camera_file() {
    return camera_text().empty() ? std::filesystem::path() : folder_.write("camera.json", camera_text());
  }
  Eigen::Vector2d pixel(const Eigen::Vector3d& point_m) {
    const auto camera = read_camera_file(camera_file(), PictureSize{kWidth, kHeight});
    return pixel_of(*camera, point_m).value();
  }
  void click_thing(const std::string& name, const Eigen::Vector3d& point_m) {
    click(name, [this, point_m](const Image&) { return std::optional(pixel(point_m)); });
  }

  // Positions of widgets; the colours are FrameBg and Button of window_style.cpp, the panels' places are in
  // draw_panels.cpp.
  static constexpr int kRunPanel = 10 + 12 + 4,
                       kObjectsPanel = kWidth - 10 - 390 + 12 + 4;  // left ends of the first buttons
  static constexpr double kSliderLeft = kWidth - 10 - 390 + 0.45 * 366,
                          kSliderRight = kSliderLeft + 0.55 * 366 - 84 - 8 + 12;
  static std::vector<int> fields(const Image& image) {
    return widgets(image, kWidth - 10 - 12 - 3, 46, 51, 61);
  }
  static std::vector<int> buttons(const Image& image, int x) { return widgets(image, x, 56, 77, 99); }
  // Vertical position of the row of Pause, Step and Reset. A button under the pointer has a different colour.
  std::optional<int> run_row(const Image& shown) {
    const auto rows = buttons(shown, kRunPanel);
    if (!run_row_ && !rows.empty()) run_row_ = rows.front();
    return run_row_;
  }

  bool reduced_ = false;  // pictures that are late are drawn at a reduced size
  RunPanel run_;          // state in the picture that a step receives
  std::unique_ptr<Program> server_;
  std::string address_;
  Watcher watcher_;
  std::unique_ptr<SessionClient> watching_;

 private:
  std::optional<int> run_row_;
};

}  // namespace livegs
