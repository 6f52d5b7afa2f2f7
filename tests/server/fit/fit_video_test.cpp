// SPDX-License-Identifier: Apache-2.0
// livegs fit on rendered videos of four soft things with hidden values, each pulled for a quarter of a second
// and let go, as in the study of LIVE-GS. With LIVEGS_FIT_CSV=FILE a row is added for each fit.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "core/clock.h"
#include "core/text/format_text.h"
#include "fit/point_tracks.h"
#include "gaussian/asset_file.h"
#include "hidden_motion.h"
#include "known_gaps.h"
#include "sample/sample_scene.h"
#include "scenes/soft_things.h"
#include "scratch_folder.h"
#include "splat/camera_file.h"
#include "system/support/program.h"
#include "system/support/results_csv.h"

namespace livegs {
namespace {

struct VideoCase {
  const char* name;
  GaussianAsset (*make)();
  double modulus_pa, damping, mass_kg, spacing_m;
  const char *held, *pull;  // a region's box; a force event's fields
  const char* camera;
};

GaussianAsset hat() { return make_felt_hat(); }

const VideoCase kVideoCases[] = {
    {"cord", make_spiral_cord, 5e5, 0.06, 0.08, 0.007,
     R"("min_m": [-0.1, -0.01, -0.1], "max_m": [0.1, 0.03, 0.1])",
     R"("point_m": [0.03, 0.29, 0], "force_n": [0.015, 0.003, 0.006])",
     R"({"position_m": [0.1, 0.25, 0.5], "look_at_m": [0.02, 0.16, 0], "vertical_fov_deg": 45, "width": 640, "height": 480})"},
    {"hat", hat, 6e4, 0.12, 0.12, 0.014, R"("min_m": [-0.2, 0.09, -0.2], "max_m": [0.2, 0.2, 0.2])",
     R"("point_m": [0.13, 0.012, 0], "force_n": [1, -3, 0])",
     R"({"position_m": [0.35, 0.3, 0.4], "look_at_m": [0, 0.06, 0], "vertical_fov_deg": 40, "width": 640, "height": 480})"},
    {"flowers", make_flowers, 2e5, 0.09, 0.15, 0.01,
     R"("min_m": [-0.1, -0.01, -0.1], "max_m": [0.1, 0.045, 0.1])",
     R"("point_m": [0.1, 0.26, 0], "force_n": [0.04, -0.01, 0.02])",
     R"({"position_m": [0.1, 0.3, 0.75], "look_at_m": [0.02, 0.14, 0], "vertical_fov_deg": 36, "width": 640, "height": 480})"},
    {"leaf", make_large_leaf, 4e5, 0.15, 0.1, 0.006,
     R"("min_m": [-0.25, -0.01, -0.1], "max_m": [-0.15, 0.2, 0.1])",
     R"("point_m": [0.15, 0.1, 0], "force_n": [0, -0.25, 0.05])",
     R"({"position_m": [0.2, 0.5, 0.55], "look_at_m": [0, 0.06, 0], "vertical_fov_deg": 38, "width": 640, "height": 480})"},
};

int held_ranges = 0, all_ranges = 0;

std::string video_scene(const VideoCase& one, double modulus_pa, double damping) {
  return R"({ "gravity_m_s2": [0, 0, 0], "objects": [ { "name": "thing", "asset": "thing.ply", "scale": 1, "spacing_m": )" +
         std::to_string(one.spacing_m) +
         R"(, "physics": { "behavior": "ELASTIC", "poisson_ratio": 0.3, "youngs_modulus_pa": )" +
         std::to_string(modulus_pa) + R"(, "damping": )" + std::to_string(damping) + R"(, "mass_kg": )" +
         std::to_string(one.mass_kg) + R"( }, "regions": [ { "box": { )" + one.held +
         R"( }, "fixed": true } ] } ], "events": [ { "time_s": 0.1, "force": { "object": "thing", )" +
         one.pull + R"(, "duration_s": 0.25 } } ] })";
}

// Processor time of the programs that ended, s.
double programs_cpu_s() {
  rusage used{};
  ::getrusage(RUSAGE_CHILDREN, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

int usable_cores() {
  cpu_set_t cores;
  return ::sched_getaffinity(0, sizeof cores, &cores) == 0 ? CPU_COUNT(&cores) : 0;
}

// Runs `livegs fit` and compares its values with the hidden ones. `input`: of the row of results.
void expect_fit(const VideoCase& one, const char* input, std::vector<std::string> words,
                const std::filesystem::path& output, double stiffness_bar, double loss_bar) {
  words.insert(words.begin(), {LIVEGS_TOOL, "fit"});
  words.insert(words.end(), {"-o", output.string()});
  const int64_t begun_ns = now_ns();
  const double cpu_before_s = programs_cpu_s();
  Program fit(words);
  ASSERT_EQ(fit.wait(), 0) << fit.err();
  const double wall_s = seconds_from_ns(now_ns() - begun_ns);
  std::puts((fit.err() + fit.out()).c_str());
  nlohmann::json result;
  std::ifstream(output / "fit.json") >> result;
  double stiffness_error = NAN, loss_error = NAN;
  for (const auto& value : result["values"]) {
    const bool stiffness = value["quantity"] == "youngs_modulus_pa";
    const double truth = stiffness ? one.modulus_pa : one.damping, best = value["best"].get<double>();
    EXPECT_NEAR(best / truth, 1.0, stiffness ? stiffness_bar : loss_bar) << value;
    (stiffness ? stiffness_error : loss_error) = std::abs(best / truth - 1);
    held_ranges += value["low"].get<double>() <= truth && truth <= value["high"].get<double>();
    ++all_ranges;
  }
  EXPECT_TRUE(std::isfinite(stiffness_error) && std::isfinite(loss_error)) << result["values"];
  add_result("LIVEGS_FIT_CSV", "scene,input,seconds,cpu_s,cores,simulations,modulus_error,loss_error",
             format_text("%s,%s,%.1f,%.1f,%d,%zu,%.4f,%.4f", one.name, input, wall_s,
                         programs_cpu_s() - cpu_before_s, usable_cores(), result["simulations"].get<size_t>(),
                         stiffness_error, loss_error));
}

class FitVideo : public testing::TestWithParam<VideoCase> {};

TEST_P(FitVideo, GivesTheHiddenStiffnessAndLoss) {
  const VideoCase& one = GetParam();
  const ScratchFolder scratch;
  const std::filesystem::path folder = scratch.path();
  ASSERT_TRUE(write_asset(folder / "thing.ply", one.make()));
  std::ofstream(folder / "truth.scene.json") << video_scene(one, one.modulus_pa, one.damping);
  std::ofstream(folder / "guess.scene.json") << video_scene(one, 5 * one.modulus_pa, 0.3);
  std::ofstream(folder / "camera.json") << one.camera;
  const std::string in = folder.string() + "/";
  Program filmed({LIVEGS_TOOL, "simulate", in + "truth.scene.json", "--seconds", "1.5", "--render",
                  in + "camera.json", "--every", "3", "-o", in + "film"});
  ASSERT_EQ(filmed.wait(), 0) << filmed.err();
  Program encoded({"/usr/bin/ffmpeg", "-nostdin", "-v", "error", "-framerate", "30", "-pattern_type", "glob",
                   "-i", in + "film/frame_*.png", "-c:v", "libx264", "-crf", "14", "-pix_fmt", "yuv420p",
                   in + "film.mp4"});
  ASSERT_EQ(encoded.wait(), 0) << encoded.err();
  expect_fit(one, "video",
             {in + "guess.scene.json", "--video", in + "film.mp4", "--camera", in + "camera.json"},
             folder / "fit", 0.15, 0.25);

  // Paths with an error of a pixel, one in twenty wrong, by a camera whose focal length is 2 % wrong.
  auto camera = read_camera_file(folder / "camera.json");
  ASSERT_TRUE(camera);
  HiddenMotion motion;
  motion.truth = scene_of(video_scene(one, one.modulus_pa, one.damping));
  motion.request.scene.folder = folder;
  motion.request.camera = *camera;
  PointTracks tracks = exact_tracks(motion, 200);
  disturb(tracks, 1.0, 0.05, 7);
  ASSERT_TRUE(write_tracks_file(folder / "noisy.csv", tracks));
  camera->focal_x_px *= 1.02;
  camera->focal_y_px *= 1.02;
  ASSERT_TRUE(write_camera_file(folder / "wrong_camera.json", *camera));
  expect_fit(one, "noisy paths",
             {in + "guess.scene.json", "--tracks", in + "noisy.csv", "--camera", in + "wrong_camera.json"},
             folder / "noisy", 0.25, 0.25);
}

INSTANTIATE_TEST_SUITE_P(Things, FitVideo, testing::ValuesIn(kVideoCases),
                         [](const auto& param) { return std::string(param.param.name); });

// Of 16 ranges of 90 %, fewer than 12 hold with a probability of 2 %.
class RangesHold : public testing::Environment {
  void TearDown() override {
    if (all_ranges < 16) return;  // a part of the cases
    report_gap("fit.ranges_held", static_cast<double>(held_ranges) / all_ranges);
    EXPECT_GE(held_ranges, 12);
  }
};
const auto* const ranges_hold = testing::AddGlobalTestEnvironment(new RangesHold);

}  // namespace
}  // namespace livegs
