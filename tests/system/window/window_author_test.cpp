// SPDX-License-Identifier: Apache-2.0
// A scene that is built in the window: files dropped in, named, moved by gizmo and by numbers, scaled,
// deleted, undone, edited, saved, and opened again.
#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/message_differencer.h>

#include <future>
#include <thread>

#include "core/clock.h"
#include "core/file.h"
#include "gaussian/asset_file.h"
#include "material/part_places.h"
#include "patience.h"
#include "rates.h"
#include "sample/made_room.h"
#include "system/support/author_server.h"
#include "system/window/window_session.h"
#include "viewer/author/gizmo.h"

namespace livegs {
namespace {

class WindowAuthor : public WindowHands {
 protected:
  void SetUp() override {
    WindowHands::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    server_ = std::make_unique<AuthorServer>(folder_.path());
    server_->start(true);
  }
  void run_steps() {
    WindowRunOptions options;
    options.address = server_->address();
    options.cache = folder_ / "window_cache";
    options.renderer = RendererChoice::Cpu;
    options.size = PictureSize{kWidth, kWindowHeight};
    options.camera_file = camera_file();
    std::atomic<bool> interrupted{false};
    options.on_picture = [&](const Image& shown, const RunPanel& run) {
      notice_ = run.notice;
      see(shown, "LiveGS " + server_->address(), interrupted);
    };
    const auto done = run_window(options, interrupted);
    EXPECT_TRUE(done) << done.error().message;
    expect_all_done();
  }
  std::filesystem::path camera_file() { return folder_.write("camera.json", camera_text_); }
  Camera camera() { return *read_camera_file(camera_file(), PictureSize{kWidth, kWindowHeight}); }

  // State of the server, asked for in each picture.
  const v1::Object* object(const std::string& name) {
    seen_ = server_->scene();
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
    const Eigen::Vector2d at = pixel_of(camera(), {x, 0, kDropped_m}).value();
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
  // `other`: in the second window.
  void chord(const std::string& key, bool other = false) {
    const auto press = [this, other](const std::string& name, bool down) {
      return [this, other, name, down] { (other ? other_ : hands_)->key(name, down); };
    };
    act({press("Control_L", true), [] {}, press(key, true), [] {}, press(key, false),
         press("Control_L", false), [] {}});
  }
  void type(const std::vector<std::string>& keys) {
    chord("a");
    for (const std::string& key : keys) press_key(key);
    press_key("Return");
  }

  // Stops the server and opens the saved scene again.
  void expect_the_same_again() {
    const v1::Scene saved = server_->scene();
    server_->stop();
    server_->start(false);
    EXPECT_TRUE(google::protobuf::util::MessageDifferencer::Equals(server_->scene(), saved)) << "to the bit";
  }

  static constexpr double kDropped_m = 0.3;  // z of dropped files
  static constexpr int kWindowHeight = 1000;
  static constexpr size_t kTextRows = 6;  // with the search above the list
  // Columns of the Objects panel: its left end, and the materials of parts.
  static constexpr int kPartsLeft = kWidth - 10 - 390 + 12 + 2, kMaterialColumn = kWidth - 148;
  static constexpr int kFields = 10 + 84, kFieldsEnd = 283;  // ends of the Scene panel's fields
  std::string camera_text_ =
      R"({ "position_m": [0.4, 0.9, 3.0], "look_at_m": [0.4, 0.2, 0], "vertical_fov_deg": 40 })";
  std::unique_ptr<AuthorServer> server_;
  v1::Scene seen_;
  std::string notice_;             // of the Run panel
  std::unique_ptr<XHands> other_;  // of the second window
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

  // A value is edited in the Objects panel, and goes back to its estimate.
  const auto undo_title = [this](const std::string& title) {
    return [this, title](const Image&) {
      const auto document = server_->control().scene();
      return document && document->undo() == title;
    };
  };
  const auto friction_row = [](const Image& shown) -> std::optional<int> {
    const auto rows = widgets(shown, kWidth - 10 - 12 - 3, 46, 51, 61);
    return rows.empty() ? std::nullopt : std::optional(rows.back());
  };
  click("the friction", [friction_row](const Image& shown) -> std::optional<Eigen::Vector2d> {
    const auto row = friction_row(shown);
    return row ? std::optional(Eigen::Vector2d(kWidth - 60, *row)) : std::nullopt;
  });
  type({"0", "period", "9"});
  step("the edited value", undo_title("edit values of fez"));
  pictures(6);
  keep("author_5_edited_value");
  click("the estimate", [friction_row](const Image& shown) -> std::optional<Eigen::Vector2d> {
    const auto row = friction_row(shown);
    return row ? std::optional(Eigen::Vector2d(kWidth - 60, *row + 23)) : std::nullopt;
  });
  step("the estimate again", undo_title("return to the estimate of fez"));
  chord("z");
  step("undone", undo_title("edit values of fez"));

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
    const auto document = server_->control().scene();
    return document && !document->unsaved();
  });
  pictures(2);
  keep("author_7_saved");
  close();
  run_steps();
  EXPECT_EQ(server_->scene().objects_size(), 4);
  expect_the_same_again();
}

// Parts of a wooden stool: it is divided, one part becomes cork, undo and redo, and the sidecar has them
// after the server was started again.
TEST_F(WindowAuthor, DividesAnObjectIntoParts) {
  drop("stool.ply", 0.4);
  step("the stool", [this](const Image&) { return object("stool") != nullptr; });
  // The Parts section is the last header; the rows below have the colour of their part.
  const auto headers = [](const Image& shown) { return widgets(shown, kPartsLeft, 61, 92, 122); };
  click("the Parts section", [headers](const Image& shown) -> std::optional<Eigen::Vector2d> {
    const std::vector<int> rows = headers(shown);
    return rows.empty() ? std::nullopt : std::optional(Eigen::Vector2d(kPartsLeft + 60, rows.back()));
  });
  act({[this] { hands_->move(600, 900); }, [] {}});
  pictures(3);
  keep("parts_1_opened");
  click("Divide", [](const Image& shown) -> std::optional<Eigen::Vector2d> {
    const std::vector<int> rows = widgets(shown, kPartsLeft, 56, 77, 99);
    return rows.empty() ? std::nullopt : std::optional(Eigen::Vector2d(kPartsLeft + 10, rows.front()));
  });
  act({[this] { hands_->move(600, 900); }, [] {}});
  const auto kept_parts = [this] {
    v1::PhysicsFile file;
    for (const auto& one : std::filesystem::directory_iterator(server_->file().parent_path())) {
      if (!one.path().filename().string().ends_with(".physics.json")) continue;
      const auto bytes = read_file(one.path());
      EXPECT_TRUE(bytes);
      const std::string text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
      EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(text, &file).ok());
    }
    return file.edits().parts();
  };
  const auto material = [kept_parts](const std::string& name) {
    return [kept_parts, name](const Image&) {
      const auto parts = kept_parts();
      return parts.size() == 2 && (parts[1].material() == name) == (name == "cork") &&
             std::abs(parts[0].mass_share() + parts[1].mass_share() - 1) < 1e-9;
    };
  };
  step("two parts", material("of before"));
  const auto many_of = [](size_t part) {
    return [part](const Image& shown) {
      const Eigen::Vector3f hue = part_rgb(part).normalized();
      size_t count = 0;
      for (int y = 0; y < shown.height; ++y) {
        for (int x = kLeft; x < kRight; ++x) {
          const Eigen::Vector3f rgb(shown.at(x, y));
          count += rgb.norm() > 0.25f && rgb.normalized().dot(hue) > 0.98f;
        }
      }
      return count > 1000;
    };
  };
  step("the seat in its colour", many_of(1));
  step("the legs in theirs", many_of(0));
  pictures(3);
  keep("parts_2_divided");
  click("the material of the second part", [](const Image& shown) -> std::optional<Eigen::Vector2d> {
    const std::vector<int> rows = widgets(shown, kMaterialColumn, 46, 51, 61);
    return rows.size() < 2 ? std::nullopt : std::optional(Eigen::Vector2d(kMaterialColumn, rows[1]));
  });
  pictures(4);
  keep("parts_3_materials");
  type({"c", "o", "r", "k"});
  act({[this] { hands_->move(600, 900); }, [] {}});
  step("cork", material("cork"));
  pictures(6);
  keep("parts_4_cork");
  chord("z");
  step("undone", material("of before"));
  chord("y");
  step("redone", material("cork"));
  click("the estimate", [](const Image& shown) -> std::optional<Eigen::Vector2d> {
    const std::vector<int> rows = widgets(shown, kPartsLeft, 56, 77, 99);
    return rows.empty() ? std::nullopt : std::optional(Eigen::Vector2d(kPartsLeft + 130, rows.front()));
  });
  act({[this] { hands_->move(600, 900); }, [] {}});
  step("one part again", [kept_parts](const Image&) { return kept_parts().empty(); });
  chord("z");
  step("cork once more", material("cork"));
  chord("s");
  step("saved", [this](const Image&) {
    const auto document = server_->control().scene();
    return document && !document->unsaved();
  });
  close();
  run_steps();
  server_->stop();
  Program info({LIVEGS_TOOL, "info", server_->file()});
  EXPECT_EQ(info.wait(), 0) << info.err();
  EXPECT_NE(info.out().find("part 2 of cork, 50 % of the mass"), std::string::npos) << info.out();
  server_->start(false);
}

// A second window, of another process, and a server that is killed between the steps of both.
// Nightly: two windows and four starts of a server are slow beside other tests.
TEST_F(WindowAuthor, TwoWindowsEditOneScene) {
  if (!full_sets()) GTEST_SKIP() << "nightly, with LIVEGS_TEST_SEEDS";
  constexpr int kOtherWidth = 640, kOtherHeight = 480;
  Program other({LIVEGS_CLIENT, "localhost:" + server_->port(), "--display", "window", "--renderer", "cpu",
                 "--size", "640x480", "--camera", camera_file(), "--cache", folder_ / "other_cache"});
  step("the second window", [&](const Image&) {
    if (!other_) other_ = XHands::at_window(display_, "LiveGS localhost:" + server_->port());
    if (other_) other_->place(kWidth + 10, 0);
    return other_ != nullptr;
  });
  act({[this] { other_->move(600, 460); }, [this] { other_->key("h", true); }, [] {},
       [this] { other_->key("h", false); }, [] {}});  // its panels are hidden
  // Parts of both windows around a point above the floor, in front of which nothing else is drawn.
  const auto around = [](const Image& from, const Camera& camera, double x) {
    constexpr int kHalf_px = 20;
    const Eigen::Vector2i at = pixel_of(camera, {x, 0.05, kDropped_m}).value().cast<int>();
    return cropped(from, at.x() - kHalf_px, at.y() - kHalf_px, at.x() + kHalf_px, at.y() + kHalf_px);
  };
  const Camera other_camera = *read_camera_file(camera_file(), PictureSize{kOtherWidth, kOtherHeight});
  const auto there = [&](double x) {
    const Image shown = other_->picture();
    return shown.width == kOtherWidth ? around(shown, other_camera, x) : Image();
  };
  const auto differs = [](const Image& a, const Image& b) {
    return a.pixels.size() == b.pixels.size() && psnr_db(a, b) < 20;
  };
  const auto equals = [](const Image& a, const Image& b) {
    return a.pixels.size() == b.pixels.size() && psnr_db(a, b) > 35;
  };
  // After a step: the server is killed and started again. The scene is the same, and both windows show it.
  const auto kill = [&](const std::string& after) {
    step("a killed server after " + after, [this](const Image&) {
      const v1::Scene before = server_->scene();
      server_->kill();
      server_->start(true);  // there is no scene file until a save
      EXPECT_TRUE(google::protobuf::util::MessageDifferencer::Equals(server_->scene(), before));
      return true;
    });
    step("the notice of the lost server after " + after, [this](const Image&) { return !notice_.empty(); });
    step("the server again after " + after, [this](const Image&) { return notice_.empty(); });
  };
  const auto objects = [&](int count) {
    return [this, count](const Image&) { return server_->scene().objects_size() == count; };
  };

  constexpr double kCup = 0.0;
  Image empty_here, empty_there;
  step("two empty windows", [&](const Image& shown) {
    empty_here = around(shown, camera(), kCup);
    const Image before = std::exchange(empty_there, there(kCup));
    return !before.pixels.empty() && before.pixels == empty_there.pixels;
  });
  drop("cup.ply", kCup);
  step("the cup", objects(1));
  step("the cup in the second window", [&](const Image&) { return differs(there(kCup), empty_there); });
  kill("the drop");
  step("the cup still there", [&](const Image& shown) {
    return differs(around(shown, camera(), kCup), empty_here) && differs(there(kCup), empty_there);
  });

  // The second window duplicates it, the first deletes the original.
  act({[&] {
         const Eigen::Vector2d at = pixel_of(other_camera, {kCup, 0.05, kDropped_m}).value();
         other_->move(at.x(), at.y());
       },
       [] {}, [] {}, [this] { other_->press(); }, [] {}, [this] { other_->release(); }, [] {}});
  pictures(10);
  chord("d", true);
  step("the duplicate", objects(2));
  double copy = 0;
  step("the duplicate in the first window", [&](const Image& shown) {
    const v1::Scene scene = server_->scene();
    copy = scene.objects(1).pose().position_m(0);
    return differs(around(shown, camera(), copy), empty_here);
  });
  act({[this] { other_->move(600, 460); }});
  kill("the duplicate");
  step("both still there",
       [&](const Image&) { return differs(there(kCup), empty_there) && differs(there(copy), empty_there); });
  keep("two_windows_first");
  step("the second window's picture", [&](const Image&) {
    return write_png(pictures_ / "two_windows_second.png", other_->picture()).has_value();
  });
  act({[this] { hands_->move(600, 60); }, [] {}});
  press_key("Delete");
  step("the original deleted", objects(1));
  step("and in the second window", [&](const Image&) { return equals(there(kCup), empty_there); });
  chord("z", true);
  step("undone by the second window", objects(2));
  step("and in the first window",
       [&](const Image& shown) { return differs(around(shown, camera(), kCup), empty_here); });
  kill("undo");

  chord("s");
  step("saved", [this](const Image&) {
    const auto document = server_->control().scene();
    return document && !document->unsaved();
  });
  act({[this] { other_->close(); }});
  close();
  run_steps();
  EXPECT_EQ(other.wait(), 0) << other.err();
  EXPECT_EQ(server_->scene().objects_size(), 2);
  expect_the_same_again();
}

// A thing of a captured room is outlined under the mouse, taken by a click, and put back by undo.
TEST_F(WindowAuthor, TakesAThingOutOfARoom) {
  camera_text_ =
      R"({ "position_m": [0.25, 1.3, 0.75], "look_at_m": [0.15, 0.72, -0.05], "vertical_fov_deg": 40 })";
  const MadeRoom room = make_room(RoomKind::Apart);
  server_->stop();
  ASSERT_TRUE(write_asset(server_->file().parent_path() / "desk.ply", room.asset));
  folder_.write("made/room.scene.json", R"({ "environment": { "asset": "desk.ply", "collide": true } })");
  server_->start(false);
  const int64_t give_up_ns = now_ns() + std::chrono::nanoseconds(kPatience).count();
  while (server_->control().room_parts().value().state() != v1::RoomParts::READY && now_ns() < give_up_ns)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  constexpr size_t kMug = 2;
  const Eigen::Vector3d mug = room.bounds_m[kMug].center();
  const Eigen::Vector2d at = pixel_of(camera(), {mug.x(), -mug.y(), -mug.z()}).value();
  ASSERT_GT(at.x(), kLeft);
  ASSERT_LT(at.x(), kRight);
  act({[this, at] { hands_->move(at.x() + 120, at.y() + 200); }});  // beside it
  pictures(4);
  press_key("6");
  pictures(2);
  // Yellow; the mug is blue, the desk brown.
  const auto is_outline = [](const float* rgb) { return rgb[0] > 0.75f && rgb[1] > 0.55f && rgb[2] < 0.5f; };
  const auto outlined = [at, is_outline](const Image& shown) {
    int count = 0;
    for (int y = static_cast<int>(at.y()) - 110; y < static_cast<int>(at.y()) + 110; ++y) {
      for (int x = static_cast<int>(at.x()) - 110; x < static_cast<int>(at.x()) + 110; ++x)
        count += is_outline(shown.at(x, y));
    }
    return count > 60;
  };
  act({[this, at] { hands_->move(at.x(), at.y()); }});
  step("the outline", outlined);
  keep("take_1_outlined");
  act({[this] { hands_->press(); }, [] {}, [this] { hands_->release(); }});
  step("the thing", [this](const Image&) { return object("thing 1") != nullptr; });
  act({[this] {
    v1::EditSceneRequest moved;
    v1::ObjectEdit& edit = *moved.add_objects();
    edit.set_object("thing 1");
    *edit.mutable_value()->mutable_pose() = object("thing 1")->pose();
    edit.mutable_value()->mutable_pose()->set_position_m(0, along("thing 1", 0) - 0.12);
    edit.mutable_value()->mutable_pose()->set_position_m(2, along("thing 1", 2) + 0.1);
    edit.add_fields("pose");
    EXPECT_TRUE(server_->control().edit_scene(moved));
  }});
  pictures(20);
  keep("take_2_moved");
  chord("z");
  chord("z");
  step("the room of before", [this](const Image&) { return object("thing 1") == nullptr; });
  pictures(4);
  keep("take_3_undone");
  close();
  run_steps();
}

}  // namespace
}  // namespace livegs
