// SPDX-License-Identifier: Apache-2.0
// A scene that is built in the window: files dropped in, named, moved by gizmo and by numbers, scaled,
// deleted, undone, edited, saved, and opened again.
#include <google/protobuf/util/message_differencer.h>

#include <future>

#include "stream/session/scene_control.h"
#include "system/window/window_session.h"
#include "viewer/author/gizmo.h"

namespace livegs {
namespace {

class WindowAuthor : public WindowHands {
 protected:
  void SetUp() override {
    WindowHands::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    Program sample({LIVEGS_TOOL, "sample", folder_ / "sample"});
    ASSERT_EQ(sample.wait(), 0) << sample.err();
    std::filesystem::create_directories(folder_ / "made");
    serve(true);
  }
  void TearDown() override {
    if (server_) server_->send(SIGTERM);
  }
  void serve(bool fresh) {
    std::vector<std::string> words = {LIVEGS_SERVER,  folder_ / "made/room.scene.json",
                                      "--listen",     "127.0.0.1:0",
                                      "--print-port", "--offline"};
    if (fresh) words.push_back("--new");
    server_ = std::make_unique<Program>(words);
    const std::string port = server_->first_line();
    ASSERT_NE(port, "") << server_->err();
    address_ = "127.0.0.1:" + port;
    control_ = std::make_unique<SceneControl>(address_);
  }
  void run_steps() {
    WindowRunOptions options;
    options.address = address_;
    options.cache = folder_ / "window_cache";
    options.renderer = RendererChoice::Cpu;
    options.size = PictureSize{kWidth, kWindowHeight};
    options.camera_file = camera_file();
    std::atomic<bool> interrupted{false};
    options.on_picture = [&](const Image& shown, const RunPanel&) {
      see(shown, "LiveGS " + address_, interrupted);
    };
    const auto done = run_window(options, interrupted);
    EXPECT_TRUE(done) << done.error().message;
    expect_all_done();
  }
  std::filesystem::path camera_file() {
    return folder_.write("camera.json", R"({ "position_m": [0.4, 0.9, 3.0], "look_at_m": [0.4, 0.2, 0],
                                             "vertical_fov_deg": 40 })");
  }
  Camera camera() { return *read_camera_file(camera_file(), PictureSize{kWidth, kWindowHeight}); }

  // State of the server, asked for in each picture.
  v1::Scene scene() {
    const auto document = control_->scene();
    return document ? document->scene() : v1::Scene();
  }
  const v1::Object* object(const std::string& name) {
    seen_ = scene();
    for (const v1::Object& one : seen_.objects()) {
      if (one.name() == name) return &one;
    }
    return nullptr;
  }
  double along(const std::string& name, int axis) {
    const v1::Object* one = object(name);
    return one && one->pose().position_m_size() == 3 ? one->pose().position_m(axis) : NAN;
  }
  void drop(const std::string& file, double x) {
    auto dropped = std::make_shared<std::future<bool>>();
    const Eigen::Vector2d at = pixel_of(camera(), {x, 0, 0.3}).value();
    act({[this, at] { hands_->move(at.x(), at.y()); }, [] {},
         [this, dropped, at, file] {
           *dropped = std::async(std::launch::async, [this, file, at] {
             return hands_->drop_files({(folder_ / "sample" / file).string()}, at.x(), at.y());
           });
         }});
    step("the drop of " + file, [dropped](const Image&) {
      return dropped->wait_for(std::chrono::seconds(0)) == std::future_status::ready && dropped->get();
    });
  }
  // Text fields of the Scene panel from below: 0 group, 1 turn, 2 position, 3 size, 4 name.
  void click_field(const std::string& name, size_t from_below, double x) {
    auto before = std::make_shared<std::vector<int>>();
    click(name, [from_below, x, before](const Image& shown) -> std::optional<Eigen::Vector2d> {
      const std::vector<int> rows = widgets(shown, kFieldsEnd, 46, 51, 61);
      const bool moves = std::exchange(*before, rows) != rows;  // a panel takes its size one picture later
      if (moves || rows.size() != kTextRows) return std::nullopt;
      return Eigen::Vector2d(x, rows[rows.size() - 1 - from_below]);
    });
  }
  void chord(const std::string& key) {
    act({[this] { hands_->key("Control_L", true); }, [] {}, [this, key] { hands_->key(key, true); }, [] {},
         [this, key] { hands_->key(key, false); }, [this] { hands_->key("Control_L", false); }, [] {}});
  }
  void type(const std::vector<std::string>& keys) {
    chord("a");
    for (const std::string& key : keys) press_key(key);
    press_key("Return");
  }

  static constexpr int kWindowHeight = 1000;
  static constexpr size_t kTextRows = 6;                     // with the search above the list
  static constexpr int kFields = 10 + 84, kFieldsEnd = 283;  // ends of the Scene panel's fields
  std::unique_ptr<Program> server_;
  std::unique_ptr<SceneControl> control_;
  std::string address_;
  v1::Scene seen_;
};

TEST_F(WindowAuthor, BuildsAScene) {
  const std::vector<std::pair<std::string, double>> files = {
      {"cup.ply", 0.0}, {"stool.ply", 0.6}, {"duck.ply", 1.0}, {"hat.ply", -0.4}};
  for (const auto& [file, x] : files) {
    drop(file, x);
    const std::string name = file.substr(0, file.find('.'));
    step(name + " in the scene", [this, name](const Image&) { return object(name) != nullptr; });
  }
  pictures(3);
  keep("author_1_dropped");

  // The hat was added last and is selected: named in its field.
  click_field("the name", 4, kFields + 40);
  type({"f", "e", "z"});
  step("the new name", [this](const Image&) { return object("fez") != nullptr; });
  keep("author_2_named");

  // Moved by the gizmo along x.
  double before = 0;
  press_key("2");
  step("before the drag", [&](const Image&) { return before = along("fez", 0), std::isfinite(before); });
  pictures(4);
  keep("author_3_gizmo");
  auto from = std::make_shared<Eigen::Vector2d>();
  step("the arrow", [this, from](const Image& shown) {
    // The red arrow of x: the middle of its pixels.
    Eigen::Vector2d sum(0, 0);
    int count = 0;
    for (int y = 0; y < shown.height; ++y) {
      for (int x = kLeft; x < kRight; ++x) {
        if (!is_colour(shown.at(x, y), 230, 80, 80)) continue;
        sum += Eigen::Vector2d(x, y);
        ++count;
      }
    }
    if (count < 50) return false;
    *from = sum / count;
    hands_->move(from->x(), from->y());
    return true;
  });
  act({[] {}, [] {}, [this] { hands_->press(); }, [] {}});
  for (int i = 1; i <= 5; ++i) act({[this, from, i] { hands_->move(from->x() + 12 * i, from->y()); }});
  pictures(2);
  keep("author_4_dragged");
  act({[this] { hands_->release(); }, [] {}});
  step("the moved hat", [&](const Image&) { return along("fez", 0) > before + 0.05; });
  press_key("1");

  // Moved by numbers.
  click_field("the position", 2, kFields + 20);
  type({"1", "period", "5"});
  step("the number", [this](const Image&) { return along("fez", 0) == 1.5; });
  chord("z");
  step("the move undone", [this](const Image&) { return along("fez", 0) < 1.4; });
  chord("y");
  step("and redone", [this](const Image&) { return along("fez", 0) == 1.5; });

  // Scaled by its size.
  click_field("the size", 3, kFields + 40);
  type({"0", "period", "5"});
  step("the scale", [this](const Image&) {
    const v1::Object* fez = object("fez");
    return fez && fez->has_scale();
  });
  keep("author_5_scaled");

  // Deleted and brought back.
  act({[this] { hands_->move(600, 900); }, [] {}});
  press_key("Delete");
  step("the hat deleted",
       [this](const Image&) { return object("fez") == nullptr && seen_.objects_size() == 3; });
  chord("z");
  step("the hat back", [this](const Image&) { return object("fez") != nullptr; });
  pictures(3);
  keep("author_6_undone");

  // Saved.
  chord("s");
  step("the file",
       [this](const Image&) { return std::filesystem::exists(folder_ / "made/room.scene.json"); });
  step("no unsaved change", [this](const Image&) {
    const auto document = control_->scene();
    return document && !document->unsaved();
  });
  pictures(2);
  keep("author_7_saved");
  close();
  run_steps();

  const v1::Scene saved = scene();
  server_->send(SIGTERM);
  EXPECT_EQ(server_->wait(), 0);
  serve(false);
  EXPECT_EQ(saved.objects_size(), 4);
  EXPECT_TRUE(google::protobuf::util::MessageDifferencer::Equals(scene(), saved)) << "the same to the bit";
}

}  // namespace
}  // namespace livegs
