// SPDX-License-Identifier: Apache-2.0
// A person at the desktop window, on a display that nobody looks at: every click goes through X, GLFW and Dear ImGui to a
// server, and a second client sees what came of it.
#include <gtest/gtest.h>
#include <signal.h>

#include <cstdlib>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include "core/clock.h"
#include "stream/session_client.h"
#include "system/programs_fixture.h"
#include "system/screen.h"
#include "system/x_hands.h"
#include "viewer/camera_file.h"
#include "viewer/orbit_camera.h"
#include "viewer/physical_field.h"
#include "viewer/window_run.h"

namespace livegs {
namespace {

constexpr int kWidth = 1280, kHeight = 800;
constexpr double kPatience_s = 60;  // for all of it

// What the scene leaves open of the cushion a person may change.
constexpr const char* kScene = R"({
  "environment": { "colliders": [ { "plane": {} } ] },
  "objects": [
    { "name": "box", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [-0.3, 0.1, 0] },
      "physics": { "behavior": "RIGID", "mass_kg": 1 } },
    { "name": "cushion", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0.3, 0.1, 0] },
      "physics": { "behavior": "ELASTIC" } } ] })";

// What a second client knows of the scene.
class Watcher final : public StreamSink {
 public:
  struct Seen {
    std::map<std::string, StreamedObject> objects;  // by name
    std::map<std::string, Eigen::Vector3d> places;  // of rigid ones
    size_t added = 0;
    v1::RunState run;
  };
  Seen seen() {
    std::lock_guard lock(mutex_);
    return seen_;
  }
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
      if (name != names_.end() && !drivers.poses.empty()) seen_.places[name->second] = drivers.poses[0].position_m;
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

bool is_colour(const float* pixel, int r, int g, int b) {
  return std::abs(255 * pixel[0] - static_cast<float>(r)) < 2.5f && std::abs(255 * pixel[1] - static_cast<float>(g)) < 2.5f &&
         std::abs(255 * pixel[2] - static_cast<float>(b)) < 2.5f;
}

// The middles of the runs of a colour down a column, each of a widget's height.
std::vector<int> widgets(const Image& image, int x, int r, int g, int b) {
  std::vector<int> middles;
  int from = -1;
  for (int y = 0; y <= image.height; ++y) {
    const bool in = y < image.height && is_colour(image.at(x, y), r, g, b);
    if (in && from < 0) from = y;
    if (!in && from >= 0) {
      if (y - from >= 12 && y - from <= 30) middles.push_back((from + y) / 2);
      from = -1;
    }
  }
  return middles;
}
// window_style.cpp: FrameBg and Button; the panels' places: draw_panels.cpp.
std::vector<int> fields(const Image& image) { return widgets(image, kWidth - 10 - 12 - 3, 46, 51, 61); }
std::vector<int> buttons(const Image& image, int x) { return widgets(image, x, 56, 77, 99); }
constexpr int kRunPanel = 10 + 12 + 4, kObjectsPanel = kWidth - 10 - 390 + 12 + 4;  // the left ends of their first buttons
constexpr double kSliderLeft = kWidth - 10 - 390 + 0.45 * 366, kSliderRight = kSliderLeft + 0.55 * 366 - 84 - 8 + 12;

size_t force_pixels(const Image& image) {  // between the panels
  size_t count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 315; x < 875; ++x) count += is_colour(image.at(x, y), 255, 150, 30);
  }
  return count;
}

class WindowClicks : public Programs {
 protected:
  void SetUp() override {
    if (!Screen::there_is_one()) GTEST_SKIP() << "no Xvfb; install xvfb";
    screen_ = std::make_unique<Screen>();
    display_ = screen_->display;
    ASSERT_NE(display_, "") << screen_->program->err();
    ::setenv("DISPLAY", display_.c_str(), 1);
    std::vector<std::string> words = server_words();
    words.at(1) = folder_.write("cushion.scene.json", kScene);
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

  // Each step is asked once a picture, with the picture, until it says that it is done.
  using Step = std::function<bool(const Image& shown)>;
  void step(std::string name, Step done) { steps_.push_back({std::move(name), std::move(done)}); }
  // Things to do, a picture each.
  void act(std::vector<std::function<void()>> acts) {
    for (auto& one : acts) step("a hand", [one = std::move(one)](const Image&) { return one(), true; });
  }
  void click(const std::string& name, std::function<std::optional<Eigen::Vector2d>(const Image&)> where) {
    step("to find " + name, [this, where](const Image& shown) {
      const auto at = where(shown);
      if (at) hands_->move(at->x(), at->y());
      return at.has_value();
    });
    act({[] {}, [this] { hands_->press(); }, [] {}, [this] { hands_->release(); }, [] {}});
  }
  void keep(const std::string& name) {
    step(name, [this, name](const Image& shown) { return write_png(pictures_ / (name + ".png"), shown).has_value(); });
  }

  void run_steps() {
    WindowRunOptions options;
    options.address = address_;
    options.cache = folder_ / "window_cache";
    options.renderer = RendererChoice::Cpu;
    options.size = PictureSize{kWidth, kHeight};
    options.camera_file = camera_file();
    std::atomic<bool> interrupted{false};
    size_t now = 0;
    const int64_t begun_ns = now_ns();
    options.on_picture = [&](const Image& shown) {
      if (!hands_) hands_ = XHands::at_window(display_, "LiveGS " + address_);
      ASSERT_TRUE(hands_);
      if (now < steps_.size() && steps_[now].done(shown)) ++now;
      if (seconds_from_ns(now_ns() - begun_ns) < kPatience_s) return;
      (void)write_png(pictures_ / (std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) + "_in_vain.png"), shown);
      interrupted = true;
    };
    const auto done = run_window(options, interrupted);
    EXPECT_TRUE(done) << done.error().message;
    EXPECT_EQ(now, steps_.size()) << "it waited in vain: " << (now < steps_.size() ? steps_[now].name : "");
  }

  std::filesystem::path camera_file() {
    return folder_.write("camera.json", R"({ "position_m": [-0.05, 0.5, 2.2], "look_at_m": [-0.05, 0.25, 0], "vertical_fov_deg": 40 })");
  }
  Eigen::Vector2d pixel(const Eigen::Vector3d& point_m) {
    const auto camera = read_camera_file(camera_file(), PictureSize{kWidth, kHeight});
    return pixel_of(*camera, point_m).value();
  }
  double modulus_pa() { return shown_value(PhysicalField::YoungsModulus, watcher_.seen().objects["cushion"].physics).best(); }
  // The row of Pause, Step and Reset; one that the pointer is on has another colour.
  std::optional<int> run_row(const Image& shown) {
    const auto rows = buttons(shown, kRunPanel);
    if (!run_row_ && !rows.empty()) run_row_ = rows.front();
    return run_row_;
  }

  // Where LIVEGS_TEST_PICTURES says, to be looked at.
  std::filesystem::path pictures_ = std::getenv("LIVEGS_TEST_PICTURES") ? std::getenv("LIVEGS_TEST_PICTURES") : folder_ / "";
  std::unique_ptr<Screen> screen_;
  std::unique_ptr<Program> server_;
  std::string display_, address_;
  Watcher watcher_;
  std::unique_ptr<SessionClient> watching_;
  std::unique_ptr<XHands> hands_;
  std::optional<int> run_row_;
  struct NamedStep {
    std::string name;
    Step done;
  };
  std::vector<NamedStep> steps_;
};

TEST_F(WindowClicks, SelectEditResetUndo) {
  const double before_pa = modulus_pa();
  ASSERT_GT(before_pa, 0);
  double changed_pa = 0;
  size_t added = 0;
  click("the cushion", [&](const Image&) { return std::optional(pixel({0.3, 0.1, 0.1})); });
  step("the panel of an elastic thing", [&](const Image& shown) { return fields(shown).size() >= 5; });
  keep("selected");
  // Its second slider is Young's modulus; 1e2 to 1e11 Pa over its length.
  int y = 0;
  step("to find the slider", [&](const Image& shown) { return y = fields(shown).at(1), true; });
  const auto along = [&](double share) { hands_->move(kSliderLeft + share * (kSliderRight - kSliderLeft), y); };
  act({[&] { along(0.2); }, [] {}, [&] { hands_->press(); }, [] {}, [&] { along(0.35); }, [&] { along(0.45); }, [] {}});
  keep("slider");
  act({[&] { hands_->release(); }});
  step("the new modulus", [&](const Image&) { return changed_pa = modulus_pa(), changed_pa > 3 * before_pa; });
  // A scene that is loaded anew keeps what a person decided.
  step("before the reset", [&](const Image&) { return added = watcher_.seen().added, true; });
  click("Reset", [&](const Image& shown) -> std::optional<Eigen::Vector2d> {
    const auto row = run_row(shown);
    return row ? std::optional(Eigen::Vector2d(10 + 300 - 12 - 20, *row)) : std::nullopt;
  });
  step("the scene anew", [&](const Image&) { return watcher_.seen().run.resets() == 1 && watcher_.seen().added > added; });
  step("the modulus after the reset", [&](const Image&) { return modulus_pa() == changed_pa; });
  step("the panel after the reset", [&](const Image& shown) { return fields(shown).size() >= 5; });
  keep("reset");
  click("Undo", [&](const Image& shown) -> std::optional<Eigen::Vector2d> {
    const auto rows = buttons(shown, kObjectsPanel);
    return rows.empty() ? std::nullopt : std::optional(Eigen::Vector2d(kObjectsPanel, rows.back()));
  });
  step("the modulus of before", [&](const Image&) { return modulus_pa() == before_pa; });
  keep("undone");
  act({[&] { hands_->close(); }});
  run_steps();
  EXPECT_NEAR(std::log10(changed_pa), 2 + 9 * 0.45, 0.4);  // where the slider was let go
}

TEST_F(WindowClicks, PauseStepShootPull) {
  double stopped_s = 0;
  size_t added = 0;
  const auto run = [&] { return watcher_.seen().run; };
  const auto run_button = [&](int third) {
    return [this, third](const Image& shown) -> std::optional<Eigen::Vector2d> {
      const auto row = run_row(shown);
      return row ? std::optional(Eigen::Vector2d(10 + 12 + 276 * (2 * third + 1) / 6.0, *row)) : std::nullopt;
    };
  };
  click("Pause", run_button(0));
  step("a halt", [&](const Image&) { return stopped_s = run().simulated_s(), run().paused(); });
  for (int i = 0; i < 5; ++i) step("stillness", [&](const Image&) { return run().simulated_s() == stopped_s; });
  keep("paused");
  click("Step", run_button(1));
  step("a step", [&](const Image&) { return run().simulated_s() > stopped_s; });
  step("one tick and no more", [&](const Image&) { return std::abs(run().simulated_s() - stopped_s - 1.0 / 90) < 1e-6; });
  click("Go on", run_button(0));
  step("it going on", [&](const Image&) { return !run().paused() && run().simulated_s() > stopped_s + 0.1; });

  // A drag on the box pulls it: up, with an arrow.
  const Eigen::Vector2d box = pixel({-0.3, 0.1, 0.1});
  act({[&, box] { hands_->move(box.x(), box.y()); }, [] {}, [] {}});
  keep("before");
  act({[&] { hands_->press(); }, [] {}});
  for (int i = 1; i <= 8; ++i) act({[&, box, i] { hands_->move(box.x(), box.y() - 15 * i); }});
  step("a box that is drawn up", [&](const Image&) { return watcher_.seen().places["box"].y() > 0.16; });
  step("an arrow", [&](const Image& shown) { return force_pixels(shown) > 100; });
  keep("pulled");
  act({[&] { hands_->release(); }});
  step("no arrow", [&](const Image& shown) { return force_pixels(shown) == 0; });
  step("the box on the floor", [&](const Image&) { return watcher_.seen().places["box"].y() < 0.105; });
  act({[] {}, [] {}, [] {}});
  keep("after");

  step("before the ball", [&](const Image&) { return added = watcher_.seen().added, true; });
  act({[&] { hands_->move(640, 300); }, [] {}, [&] { hands_->key("space", true); }, [] {}, [&] { hands_->key("space", false); }});
  step("a ball", [&](const Image&) { return watcher_.seen().added > added; });
  act({[] {}, [] {}});
  keep("ball");
  act({[&] { hands_->close(); }});
  run_steps();
}

}  // namespace
}  // namespace livegs
