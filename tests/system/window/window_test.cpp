// SPDX-License-Identifier: Apache-2.0
// The desktop window on a virtual display (Xvfb). Tests compare screenshots before, during and after a pull.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "core/file.h"
#include "splat/image.h"
#include "system/programs/programs_fixture.h"
#include "system/window/panel_text.h"
#include "system/window/screen.h"

namespace livegs {
namespace {

class Window : public Programs {
 protected:
  std::string size_ = "1280x800";
  std::vector<std::string> window_words(const std::string& display, const std::string& port,
                                        std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"/usr/bin/env", "DISPLAY=" + display,
                                      LIVEGS_CLIENT,  "127.0.0.1:" + port,
                                      "--display",    "window",
                                      "--size",       size_,
                                      "--cache",      folder_ / "cache",
                                      "--threads",    "2"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
};

// A server, and a display for a window. Skipped without Xvfb (listed in deploy/packages.txt).
class WindowOnADisplay : public Window {
 protected:
  void SetUp() override {
    if (!Screen::there_is_one()) GTEST_SKIP() << "Xvfb: not installed; install xvfb";
    screen_ = std::make_unique<Screen>();
    display_ = screen_->display;
    ASSERT_NE(display_, "") << screen_->program->err();
    server_ = std::make_unique<Program>(server_words());
    port_ = server_->first_line();
    ASSERT_NE(port_, "") << server_->err();
  }
  std::unique_ptr<Screen> screen_;
  std::unique_ptr<Program> server_;
  std::string display_, port_;
};

// Horizontal range between the panels, pixels.
constexpr int kLeft = 315, kRight = 875;  // also the right part of a narrow window with one panel

// Number of pixels in this range that differ by more than a twentieth.
size_t changed(const Image& a, const Image& b) {
  size_t count = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = kLeft; x < std::min(kRight, a.width); ++x) {
      double most = 0;
      for (int c = 0; c < 3; ++c) most = std::max<double>(most, std::abs(a.at(x, y)[c] - b.at(x, y)[c]));
      count += most > 0.05;
    }
  }
  return count;
}

// Number of pixels in this range with exactly the colour of a force arrow.
size_t force_pixels(const Image& image) {
  size_t count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = kLeft; x < std::min(kRight, image.width); ++x) {
      const float* pixel = image.at(x, y);
      count += std::abs(pixel[0] - 1.0f) < 0.01f && std::abs(pixel[1] - 150 / 255.0f) < 0.01f &&
               std::abs(pixel[2] - 30 / 255.0f) < 0.01f;
    }
  }
  return count;
}

// After a fallback to the CPU, the comparison would be of the CPU with itself.
void expect_drawn_by_vulkan(Program& window) {
  EXPECT_NE(window.err().find("renderer: vulkan: "), std::string::npos) << window.err();
  EXPECT_EQ(window.err().find("rendering continues on the CPU"), std::string::npos) << window.err();
}

// Waits for the first screenshot from number `from` on that satisfies the condition. Screenshots before the
// newest are complete files.
std::optional<Image> first_shot(const std::filesystem::path& folder, int from, int& newest,
                                const std::function<bool(const Image&)>& wanted) {
  const auto name = [&](int number) {
    char text[32];
    std::snprintf(text, sizeof text, "window_%03d.png", number);
    return folder / text;
  };
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  for (int number = from; std::chrono::steady_clock::now() < give_up;) {
    if (!std::filesystem::exists(name(number + 1))) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      continue;
    }
    auto image = read_png(name(number));
    newest = number++;
    if (image && wanted(*image)) return std::move(*image);
  }
  return std::nullopt;
}

void keep(const char* name, const Image& image) {
  if (const char* folder = std::getenv("LIVEGS_TEST_PICTURES")) {
    EXPECT_TRUE(write_png(std::filesystem::path(folder) / name, image));
  }
}

// Before, during and after a pull.
TEST_F(WindowOnADisplay, ShowsTheSceneAndAPull) {
  const std::filesystem::path shots = folder_ / "shots";
  // The camera shows the box between the panels.
  const std::string camera =
      folder_.write("camera.json", R"({ "position_m": [-0.3, 0.4, 1.8], "look_at_m": [-0.3, 0.3, 0],
                                                              "vertical_fov_deg": 40 })");
  Program window(window_words(display_, port_,
                              {"--poke", "box", "--output", shots.string(), "--every", "1", "--renderer",
                               "cpu", "--camera", camera}));
  int newest = 0;
  const auto before = first_shot(shots, 0, newest, [](const Image&) { return true; });
  ASSERT_TRUE(before) << window.err();
  ASSERT_EQ(before->width, 1280);
  ASSERT_EQ(before->height, 800);
  const auto [darkest, brightest] = std::minmax_element(before->pixels.begin(), before->pixels.end());
  EXPECT_GT(*brightest - *darkest, 0.5f);
  // While the box is pulled, it moves up and an arrow is visible; not before or after.
  EXPECT_EQ(force_pixels(*before), 0u);
  size_t most_changed = 0, most_force = 0;
  const auto pulled = first_shot(shots, newest + 1, newest, [&](const Image& image) {
    most_changed = std::max(most_changed, changed(*before, image));
    most_force = std::max(most_force, force_pixels(image));
    return most_changed > 2000 && most_force > 200;
  });
  EXPECT_TRUE(pulled) << window.err() << most_changed
                      << " pixels changed; pixels of the arrow: " << most_force;
  EXPECT_TRUE(first_shot(shots, newest + 1, newest, [](const Image& image) {
    return force_pixels(image) == 0;
  })) << window.err();
  window.send(SIGINT);
  EXPECT_EQ(window.wait(), 0) << window.err();

  server_->send(SIGTERM);
  EXPECT_EQ(server_->wait(), 0) << server_->err();
}

// The same scene at rest by both renderers at the window size. There is room for one panel.
TEST_F(WindowOnADisplay, VulkanShowsWhatTheCpuShows) {
  size_ = "690x300";
  const std::string camera =
      folder_.write("camera.json", R"({ "position_m": [-0.35, 0.5, 1.5], "look_at_m": [-0.35, 0.1, 0],
                                                              "vertical_fov_deg": 40 })");
  const auto same = [](const Image& a, const Image& b) {
    for (int y = 0; y < a.height; ++y) {
      if (!std::equal(a.at(kLeft, y), a.at(kLeft, y) + 4 * (a.width - kLeft), b.at(kLeft, y))) return false;
    }
    return true;
  };
  // The first of four identical screenshots: nothing moves any more.
  const auto at_rest = [&](const std::string& renderer) -> std::optional<Image> {
    const std::filesystem::path shots = folder_ / renderer;
    Program window(window_words(display_, port_,
                                {"--renderer", renderer, "--full-size", "--camera", camera, "--output",
                                 shots.string(), "--every", "2"}));
    Image last;
    int newest = 0, still = 0;
    auto rests = first_shot(shots, 0, newest, [&](const Image& image) {
      still = !last.pixels.empty() && same(last, image) ? still + 1 : 0;
      last = image;
      return still == 3;
    });
    EXPECT_TRUE(rests) << window.err();
    window.send(SIGINT);
    EXPECT_EQ(window.wait(), 0) << window.err();
    if (renderer == "vulkan") expect_drawn_by_vulkan(window);
    if (rests) keep((renderer + ".png").c_str(), *rests);
    return rests;
  };
  const auto cpu = at_rest("cpu"), vulkan = at_rest("vulkan");
  ASSERT_TRUE(cpu && vulkan);
  double squares = 0;
  size_t count = 0;
  const float *least = cpu->at(kLeft, 0), *most = least;
  for (int y = 0; y < cpu->height; ++y) {
    for (int x = kLeft; x < cpu->width; ++x, count += 3) {
      const float *a = cpu->at(x, y), *b = vulkan->at(x, y);
      for (int c = 0; c < 3; ++c) squares += static_cast<double>(a[c] - b[c]) * (a[c] - b[c]);
      if (a[0] < *least) least = a;
      if (a[0] > *most) most = a;
    }
  }
  ASSERT_GT(*most - *least, 0.4f);  // the picture is not empty
  ASSERT_GT(squares, 0) << "the pictures are identical, so the CPU drew both";
  const double psnr_db = 10 * std::log10(static_cast<double>(count) / squares);
  std::printf("%.1f dB\n", psnr_db);
  EXPECT_GT(psnr_db, 50);
}

// A pull drawn by Vulkan: the arrow appears and disappears, and the box is lifted.
TEST_F(WindowOnADisplay, VulkanShowsAPull) {
  size_ = "690x300";
  const std::filesystem::path shots = folder_ / "shots";
  const std::string camera =
      folder_.write("camera.json", R"({ "position_m": [-0.6, 0.4, 1.8], "look_at_m": [-0.6, 0.3, 0],
                                                              "vertical_fov_deg": 40 })");
  Program window(window_words(display_, port_,
                              {"--poke", "box", "--renderer", "vulkan", "--camera", camera, "--output",
                               shots.string(), "--every", "1"}));
  int newest = 0;
  const auto before = first_shot(shots, 0, newest, [](const Image&) { return true; });
  ASSERT_TRUE(before) << window.err();
  EXPECT_EQ(force_pixels(*before), 0u);
  const auto pulled = first_shot(shots, newest + 1, newest, [&](const Image& image) {
    const size_t arrow = force_pixels(image);
    return arrow > 60 && changed(*before, image) > arrow + 500;  // the box has moved as well
  });
  ASSERT_TRUE(pulled) << window.err();
  keep("vulkan_pulled.png", *pulled);
  const auto after =
      first_shot(shots, newest + 1, newest, [](const Image& image) { return force_pixels(image) == 0; });
  EXPECT_TRUE(after) << window.err();
  window.send(SIGINT);
  EXPECT_EQ(window.wait(), 0) << window.err();
  expect_drawn_by_vulkan(window);
}

// A device without memory for all kernels, and one without memory for any: the window shows a notice and
// continues.
TEST_F(WindowOnADisplay, ShowsThatTheDeviceIsFull) {
  size_ = "690x300";
  for (const auto& [megabytes, notice] : {std::pair("5", "% of the kernels; the rest is not drawn"),
                                          std::pair("0.05", "rendering continues on the CPU")}) {
    const std::filesystem::path shots = folder_ / megabytes;
    std::vector<std::string> words =
        window_words(display_, port_, {"--renderer", "vulkan", "--output", shots.string(), "--every", "1"});
    words.insert(words.begin() + 1, std::string("LIVEGS_VULKAN_MEMORY_MB=") + megabytes);
    Program window(words);
    int newest = 0;
    const auto notice_shot =
        first_shot(shots, 0, newest, [](const Image& image) { return notice_pixels(image) > 100; });
    EXPECT_TRUE(notice_shot) << window.err();
    if (notice_shot) keep((std::string("full_") + megabytes + ".png").c_str(), *notice_shot);
    window.send(SIGINT);
    EXPECT_EQ(window.wait(), 0) << window.err();
    EXPECT_NE(window.err().find(notice), std::string::npos) << megabytes << " MB: " << window.err();
  }
}

// The panel of an object: text from top to bottom, none of it outside the panel.
TEST_F(WindowOnADisplay, ShowsThePanelOfAnObject) {
  const auto shown = [&](const std::string& name, std::vector<std::string> more,
                         const std::function<bool(const Image&)>& wanted) {
    const std::filesystem::path shots = folder_ / name;
    more.insert(more.end(), {"--output", shots.string(), "--every", "1"});
    Program window(window_words(display_, port_, more));
    int newest = 0;
    auto found = first_shot(shots, 0, newest, [&](const Image& image) {
      return text_pixels(image, 10, 310, 10, 400) > 1000 && wanted(image);
    });  // the other panel
    EXPECT_TRUE(found) << window.err();
    window.send(SIGINT);
    EXPECT_EQ(window.wait(), 0) << window.err();
    return found;
  };
  const auto text = [](const Image& image) { return text_pixels(image, 880, 1270, 120, 790); };
  const auto closed = shown("plain", {}, [](const Image&) { return true; });
  ASSERT_TRUE(closed);
  const auto open = shown("selected", {"--select", "cube"},
                          [&](const Image& image) { return text(image) > text(*closed) + 2000; });
  ASSERT_TRUE(open);
  EXPECT_EQ(text_pixels(*open, 1271, 1280, 0, 800), 0u);
}

// In a narrow window, the requested panel is open, the other one is collapsed above it, and the scene is
// visible to their right.
TEST_F(WindowOnADisplay, NarrowWindowHasOneOpenPanel) {
  size_ = "640x480";
  for (const bool selects : {false, true}) {
    const std::filesystem::path shots = folder_ / (selects ? "narrow_selected" : "narrow");
    std::vector<std::string> more = {"--renderer", "cpu", "--output", shots.string(), "--every", "1"};
    if (selects) more.insert(more.end(), {"--select", "cube"});
    Program window(window_words(display_, port_, more));
    int newest = 0;
    const auto found = first_shot(shots, 0, newest, [&](const Image& image) {
      return text_pixels(image, 10, 310, 60, 470) > 1000 &&
             (text_pixels(image, 311, 400, 60, 375) > 100) == selects;
    });
    ASSERT_TRUE(found) << window.err();
    const Image& last = *found;
    window.send(SIGINT);
    EXPECT_EQ(window.wait(), 0) << window.err();
    if (const char* folder = std::getenv("LIVEGS_TEST_PICTURES")) {
      EXPECT_TRUE(
          write_png(std::filesystem::path(folder) / (selects ? "narrow_selected.png" : "narrow.png"), last));
    }
    // Run is 300 px wide and Objects 390 px; both contain this text.
    EXPECT_GT(text_pixels(last, 10, 310, 60, 470), 1000u);
    EXPECT_EQ(text_pixels(last, 311, 400, 60, 375) > 100, selects);
    EXPECT_EQ(text_pixels(last, 0, 640, 471, 480), 0u);
    EXPECT_GT(text_pixels(last, 10, 110, 10, 40), 20u);  // Run, collapsed or its title
  }
}

// Records a study: a force with size, direction, point and duration, as a video with its sentence.
TEST_F(WindowOnADisplay, RecordsAForceWithItsSentence) {
  if (!std::filesystem::exists("/usr/bin/ffmpeg"))
    GTEST_SKIP() << "ffmpeg: not installed; run deploy/install-dependencies";
  size_ = "480x300";
  const std::filesystem::path study = folder_ / "study";
  Program window(
      window_words(display_, port_, {"--force", "cube:0,0.1,0:10,0,0:0.3", "--output", study.string()}));
  EXPECT_EQ(window.wait(), 0) << window.err();
  const auto sentence = read_file(study / "study_001.txt");
  ASSERT_TRUE(sentence) << window.err();
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(sentence->data()), sentence->size()),
            "Apply a force of 10 newtons to the cube for 0.3 seconds.\n");
  for (const char* name : {"study_001.mp4", "study_001.json", "study_001_camera.json"}) {
    EXPECT_TRUE(std::filesystem::exists(study / name)) << name;
  }
  EXPECT_GT(std::filesystem::file_size(study / "study_001.mp4"), 2000u);
}

// The object moves in the video: 40 N lift a cube of 2.4 kg, which is still in the air in the middle of the
// video.
TEST_F(WindowOnADisplay, VideoShowsTheMotion) {
  if (!std::filesystem::exists("/usr/bin/ffmpeg"))
    GTEST_SKIP() << "ffmpeg: not installed; run deploy/install-dependencies";
  size_ = "480x300";
  const std::filesystem::path study = folder_ / "study";
  const std::string camera =
      folder_.write("camera.json", R"({ "position_m": [0, 0.5, 2.4], "look_at_m": [0, 0.4, 0],
                                                              "vertical_fov_deg": 40 })");
  Program window(window_words(display_, port_,
                              {"--force", "cube:0,0.1,0:0,40,0:0.3", "--output", study.string(), "--renderer",
                               "cpu", "--camera", camera}));
  EXPECT_EQ(window.wait(), 0) << window.err();
  // 2.3 s at 30 pictures per second. The start of the force depends on the response time of the server.
  Program frames({"/usr/bin/ffmpeg", "-v", "error", "-i", (study / "study_001.mp4").string(), "-vsync", "0",
                  (study / "window_%03d.png").string()});
  ASSERT_EQ(frames.wait(), 0) << frames.err();
  struct Cube {
    double y = 0;
    size_t pixels = 0;
  };
  const auto cube_of = [](const Image& image) {
    Cube cube;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const float* pixel = image.at(x, y);
        if (!(pixel[2] > 0.25f && pixel[2] > 1.4f * pixel[0])) continue;
        cube.y += y;
        ++cube.pixels;
      }
    }
    cube.y /= static_cast<double>(std::max<size_t>(cube.pixels, 1));
    return cube;
  };
  std::vector<Cube> cubes;
  size_t highest = 0;
  for (int i = 1;; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "window_%03d.png", i);
    const auto image = read_png(study / name);
    if (!image) break;
    cubes.push_back(cube_of(*image));
    ASSERT_GT(cubes.back().pixels, 300u) << name;
    if (cubes.back().y < cubes[highest].y) highest = cubes.size() - 1;
  }
  ASSERT_GE(cubes.size(), 60u);
  EXPECT_NEAR(cubes[10].y, cubes[0].y, 1.5);  // after a third of a second, before the force
  EXPECT_LT(cubes[highest].y, cubes[0].y - 20);
  EXPECT_GT(highest, 15u);
  EXPECT_LT(highest + 10, cubes.size());
  EXPECT_GT(cubes.back().y, cubes[highest].y + 10);  // fallen back
}

// Several points at once.
TEST_F(WindowOnADisplay, RecordsForcesOnSeveralPoints) {
  if (!std::filesystem::exists("/usr/bin/ffmpeg"))
    GTEST_SKIP() << "ffmpeg: not installed; run deploy/install-dependencies";
  size_ = "480x300";
  const std::filesystem::path study = folder_ / "study";
  Program window(
      window_words(display_, port_,
                   {"--force", "cube:0.1,0.1,0.1:10,0,0:0.3", "--force", "cube:0.1,0.1,-0.1:10,0,0:0.3",
                    "--force", "box:0,0.1,0:0,1,0:1", "--output", study.string()}));
  EXPECT_EQ(window.wait(), 0) << window.err();
  const auto sentence = read_file(study / "study_001.txt");
  ASSERT_TRUE(sentence) << window.err();
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(sentence->data()), sentence->size()),
            "Apply a force of 10 newtons to the cube for 0.3 seconds at 2 points, and a force of 1 newton to "
            "the box for 1 second.\n");
  const auto json = read_file(study / "study_001.json");
  ASSERT_TRUE(json);
  EXPECT_EQ(nlohmann::json::parse(reinterpret_cast<const char*>(json->data()),
                                  reinterpret_cast<const char*>(json->data()) + json->size())
                .size(),
            3u);
  EXPECT_GT(std::filesystem::file_size(study / "study_001.mp4"), 2000u);
}

// An interruption before the first picture leaves no files. Later, the video contains the pictures so far,
// and a line states their number.
TEST_F(WindowOnADisplay, InterruptedRecordingEndsCleanly) {
  if (!std::filesystem::exists("/usr/bin/ffmpeg"))
    GTEST_SKIP() << "ffmpeg: not installed; run deploy/install-dependencies";
  size_ = "640x480";
  const std::filesystem::path study = folder_ / "study";
  const auto words = window_words(
      display_, port_, {"--force", "cube:0,0.1,0:1,0,0:3", "--output", study.string(), "--renderer", "cpu"});
  const auto interrupt_at = [&](Program& window, const char* file, int signal_number) {
    for (int tries = 0; tries < 12'000 && !std::filesystem::exists(study / file); ++tries)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    window.send(signal_number);
    EXPECT_EQ(window.wait(), 1) << window.err();
  };
  Program early(words);
  interrupt_at(early, "study_001.txt", SIGINT);
  EXPECT_NE(early.err().find("--force: interrupted before the first picture"), std::string::npos)
      << early.err();
  EXPECT_TRUE(std::filesystem::is_empty(study)) << early.err();

  Program late(words);
  interrupt_at(late, "study_001.mp4", SIGTERM);
  const std::string said = late.err();
  const size_t at = said.find("study_001.mp4 is incomplete: ");
  ASSERT_NE(at, std::string::npos) << said;
  int drawn = 0, all = 0;
  ASSERT_EQ(std::sscanf(said.c_str() + at, "study_001.mp4 is incomplete: %d of %d pictures", &drawn, &all), 2)
      << said;
  EXPECT_GE(drawn, 1);
  EXPECT_LT(drawn, all);
  // 0.5 + 3 + 1.5 s at 30 pictures per second. The force begins with the tick after the request, which a busy
  // machine sends late.
  EXPECT_GE(all, 146);
  for (const char* name : {"study_001.txt", "study_001.json", "study_001_camera.json"})
    EXPECT_TRUE(std::filesystem::exists(study / name)) << name;
  Program probe({"/usr/bin/ffprobe", "-v", "error", "-count_frames", "-select_streams", "v", "-show_entries",
                 "stream=nb_read_frames", "-of", "csv=p=0", (study / "study_001.mp4").string()});
  EXPECT_EQ(probe.wait(), 0) << probe.err();
  EXPECT_EQ(std::atoi(probe.out().c_str()), drawn) << probe.out();
}

// Without a user to choose another force, the program ends and leaves no partial files.
TEST_F(WindowOnADisplay, EndsIfTheServerRefusesItsForce) {
  size_ = "480x300";
  const std::filesystem::path study = folder_ / "study";
  Program window(window_words(display_, port_,
                              {"--force", "cube:0,0.1,0:1,0,0:0.3", "--force", "cube:0,0.1,0:2e5,0,0:0.3",
                               "--output", study.string(), "--renderer", "cpu"}));
  EXPECT_EQ(window.wait(), 1);
  expect_one_line(window, "force.force_n: is too large");
  for (const auto& entry : std::filesystem::directory_iterator(study))
    EXPECT_EQ(entry.path().filename().string().find("study_"), std::string::npos) << entry.path();
}

TEST_F(WindowOnADisplay, EndsIfItsTokenIsViewOnly) {
  size_ = "480x300";
  const std::filesystem::path study = folder_ / "study";
  const std::string state = folder_ / "state";
  Program guarded(server_words({"--tls", "on", "--state-dir", state}));
  const std::string port = guarded.first_line();
  ASSERT_NE(port, "") << guarded.err();
  const auto ctl = [&](std::vector<std::string> more) {
    std::vector<std::string> words = {LIVEGS_TOOL,         "ctl",         "--server",
                                      "127.0.0.1:" + port, "--state-dir", state};
    words.insert(words.end(), more.begin(), more.end());
    Program program(words);
    EXPECT_EQ(program.wait(), 0) << program.err();
    return program.out();
  };
  const std::string token = folder_.write("watcher", ctl({"tokens", "add", "watcher", "--scope", "view"}));
  const std::string status = ctl({"status"});
  const size_t code = status.find("pairing code  ");
  ASSERT_NE(code, std::string::npos) << status;
  Program window(
      window_words(display_, port,
                   {"--force", "cube:0,0.1,0:1,0,0:0.3", "--output", study.string(), "--token-file", token,
                    "--pair", status.substr(code + 14, 29), "--state-dir", folder_ / "pins"}));
  EXPECT_EQ(window.wait(), 1);
  EXPECT_NE(window.err().find("--force: "), std::string::npos) << window.err();
  EXPECT_FALSE(std::filesystem::exists(study / "study_001.txt"));
}

TEST_F(WindowOnADisplay, ReportsUnknownObjectToSelect) {
  Program window(window_words(display_, port_, {"--select", "nosuch", "--renderer", "cpu"}));
  EXPECT_EQ(window.wait(), 2);
  expect_one_line(window, "--select: no object is named \"nosuch\"");
}

// Number of squares of 20 x 20 pixels (of 1120) whose mean differs. Independent of the resolution of each
// picture.
size_t changed_squares(const Image& a, const Image& b) {
  constexpr int kSquare = 20;
  size_t count = 0;
  for (int top = 0; top + kSquare <= a.height; top += kSquare) {
    for (int left = kLeft; left + kSquare <= kRight; left += kSquare) {
      float difference[3] = {0, 0, 0};
      for (int y = top; y < top + kSquare; ++y) {
        for (int x = left; x < left + kSquare; ++x) {
          for (int c = 0; c < 3; ++c) difference[c] += (a.at(x, y)[c] - b.at(x, y)[c]) / (kSquare * kSquare);
        }
      }
      count += std::any_of(std::begin(difference), std::end(difference),
                           [](float one) { return std::abs(one) > 0.06f; });
    }
  }
  return count;
}

// The last picture stays with a red notice. The window reconnects to a restarted server and ends normally.
TEST_F(WindowOnADisplay, OutlivesItsServer) {
  const std::filesystem::path shots = folder_ / "shots";
  const std::string camera =
      folder_.write("camera.json", R"({ "position_m": [-0.3, 0.4, 1.8], "look_at_m": [-0.3, 0.3, 0],
                                                              "vertical_fov_deg": 40 })");
  Program window(
      window_words(display_, port_,
                   {"--renderer", "cpu", "--camera", camera, "--output", shots.string(), "--every", "4"}));
  int newest = 0;
  const auto shot = [&](int from, const std::function<bool(const Image&)>& wanted) {
    return first_shot(shots, from, newest, wanted);
  };
  ASSERT_TRUE(server_->says("streaming to")) << server_->err();
  const auto before = shot(5, [](const Image&) { return true; });
  ASSERT_TRUE(before) << window.err();
  EXPECT_EQ(notice_pixels(*before), 0u);
  server_->send(SIGKILL);
  EXPECT_TRUE(window.says("server disconnected")) << window.err();
  server_->wait();
  const auto gone = shot(newest, [](const Image& image) { return notice_pixels(image) > 0; });
  ASSERT_TRUE(gone) << window.err();
  EXPECT_GT(notice_pixels(*gone), 100u);
  const auto still = shot(newest + 2, [](const Image&) { return true; });
  ASSERT_TRUE(still) << window.err();
  keep("server_gone.png", *still);
  EXPECT_GT(notice_pixels(*still), 100u);
  EXPECT_LT(changed_squares(*gone, *still), 10u);
  EXPECT_LT(changed_squares(*before, *still), 10u);  // the box, about 50 squares, has not moved
  std::vector<std::string> words = server_words();
  std::replace(words.begin(), words.end(), std::string("127.0.0.1:0"), "127.0.0.1:" + port_);
  Program again(words);
  EXPECT_TRUE(window.says("to a new server")) << window.err();
  EXPECT_TRUE(again.says("streaming to")) << again.err();
  // The first pictures may be at a lower resolution.
  const auto back = shot(newest, [&](const Image& image) {
    return notice_pixels(image) == 0 && changed_squares(*before, image) < 10;
  });
  EXPECT_TRUE(back) << window.err();
  window.send(SIGINT);
  EXPECT_EQ(window.wait(), 0) << window.err();
}

// Without --display, the client opens a window if there is a display, and writes pictures otherwise.
TEST_F(WindowOnADisplay, OpensByDefaultIfThereIsADisplay) {
  std::vector<std::string> words = {"/usr/bin/env", "DISPLAY=" + display_,
                                    LIVEGS_CLIENT,  "127.0.0.1:" + port_,
                                    "--size",       "320x240",
                                    "--cache",      folder_ / "cache",
                                    "--threads",    "1",
                                    "--renderer",   "cpu",
                                    "--seconds",    "2",
                                    "--output",     folder_ / "auto"};
  Program window(words);
  EXPECT_EQ(window.wait(), 0) << window.err();
  EXPECT_TRUE(std::filesystem::exists(folder_ / "auto" / "window_000.png")) << window.err();
  EXPECT_FALSE(std::filesystem::exists(folder_ / "auto" / "first.png"));

  words[1] = "DISPLAY=";
  words.back() = folder_ / "files";
  Program files(words);
  EXPECT_EQ(files.wait(), 0) << files.err();
  EXPECT_TRUE(std::filesystem::exists(folder_ / "files" / "first.png")) << files.err();

  // Options that only apply to files select the offscreen display.
  words[1] = "DISPLAY=" + display_;
  words.back() = folder_ / "no_video";
  words.push_back("--no-video");
  Program no_video(words);
  EXPECT_EQ(no_video.wait(), 0) << no_video.err();
  EXPECT_TRUE(std::filesystem::exists(folder_ / "no_video" / "first.png")) << no_video.err();
}

TEST_F(WindowOnADisplay, PlaysARecording) {
  const std::string file = folder_ / "session.lvgrec";
  Program recording(
      {LIVEGS_TOOL, "ctl", "--server", "127.0.0.1:" + port_, "record", "start", "--assets", file});
  ASSERT_EQ(recording.wait(), 0) << recording.err();
  Program client(client_words(port_, {"--seconds", "2", "--no-video", "--every", "0"}));
  ASSERT_EQ(client.wait(), 0) << client.err();
  server_->send(SIGTERM);
  ASSERT_EQ(server_->wait(), 0) << server_->err();
  // Playback ends at the end of the recording, before ten seconds have passed.
  Program window({"/usr/bin/env", "DISPLAY=" + display_, LIVEGS_CLIENT, "--replay", file, "--from", "0.5",
                  "--seconds", "10", "--display", "window", "--size", "320x240", "--cache", folder_ / "empty",
                  "--renderer", "cpu"});
  EXPECT_EQ(window.wait(), 0) << window.err();
  EXPECT_EQ(window.err().find("error"), std::string::npos) << window.err();
}

TEST_F(Window, MissingDisplayGivesOneLineAndCodeOne) {
  Program window(window_words("", "1"));
  EXPECT_EQ(window.wait(), 1);
  const std::string err = window.err();
  EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
  EXPECT_NE(err.find("--display offscreen"), std::string::npos) << err;
}

TEST_F(Window, OffscreenForceGivesOneLineAndCodeTwo) {
  Program client({LIVEGS_CLIENT, "127.0.0.1:1", "--display", "offscreen", "--force", "cube:0,0,0:1,0,0:1"});
  EXPECT_EQ(client.wait(), 2);
  expect_one_line(client, "--display window");
}

TEST_F(Window, InvalidForceTimeGivesOneLineAndCodeTwo) {
  for (const char* force : {"cube:0,0,0:1,0,0:0", "cube:0,0,0:1,0,0:61", "cube:0,0,0:1,nan,0:1"}) {
    Program window(window_words("", "1", {"--force", force}));
    EXPECT_EQ(window.wait(), 2) << force;
    expect_one_line(window, force);
  }
}

TEST_F(Window, MalformedForceGivesOneLineAndCodeTwo) {
  Program window(window_words("", "1", {"--force", "hat:1,2:3"}));
  EXPECT_EQ(window.wait(), 2);
  const std::string err = window.err();
  EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
  EXPECT_NE(err.find("OBJECT:X,Y,Z:FX,FY,FZ:SECONDS"), std::string::npos) << err;
}

}  // namespace
}  // namespace livegs
