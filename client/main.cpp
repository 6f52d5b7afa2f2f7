// SPDX-License-Identifier: Apache-2.0
// livegs-client: sees and touches a scene that livegs-server streams. Exit codes: 0 done, 1 could not do it,
// 2 bad usage or input.
#include <signal.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <string>

#include "core/log.h"
#include "core/parallel_for.h"
#include "viewer/runs/headset_run.h"
#include "viewer/runs/offscreen_run.h"
#include "viewer/runs/replay_run.h"
#include "viewer/runs/spectate_run.h"
#include "viewer/runs/window_run.h"
#include "viewer/study/force_study.h"
#include "xr/window_display.h"

namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "it is set by a signal handler");

const std::map<std::string, livegs::v1::JoinRequest::Encoding> kEncodings{
    {"drivers", livegs::v1::JoinRequest::DRIVERS},
    {"drivers-raw", livegs::v1::JoinRequest::DRIVERS_RAW},
    {"kernels", livegs::v1::JoinRequest::KERNELS},
    {"kernels-exact", livegs::v1::JoinRequest::KERNELS_EXACT}};

int report(const livegs::Error& error) {
  using livegs::ErrorCode;
  std::fprintf(stderr, "livegs-client: %s\n", error.message.c_str());
  return error.code == ErrorCode::InvalidArgument || error.code == ErrorCode::InvalidData ||
                 error.code == ErrorCode::NotFound
             ? 2
             : 1;
}

bool parse_size(const std::string& text, livegs::PictureSize& size) {
  int used = 0;
  return std::sscanf(text.c_str(), "%dx%d%n", &size.width, &size.height, &used) == 2 &&
         used == static_cast<int>(text.size()) && size.width >= 1 && size.width <= 16384 &&
         size.height >= 1 && size.height <= 16384;
}

// What was asked for and is not done there, by name and with where it is. `of`: openxr, window, offscreen, or
// "a recording" or "publications", to which nobody does anything; `display`: where it is shown.
std::string what_is_not_done(const std::string& of, const std::string& display,
                             const std::function<bool(const char*)>& asked) {
  const bool watched = of == "a recording" || of == "publications";
  for (const char* option : {"--script", "--poke", "--force", "--select"}) {
    if (watched && asked(option))
      return std::string(option) + ": who watches " + of + " does nothing to the scene; leave it out";
  }
  const bool headset = display == "openxr", window = display == "window", offscreen = display == "offscreen";
  struct Undone {
    const char* option;
    bool there;  // where it is not done
    const char* remedy;
  };
  const Undone options[] = {
      {"--script", !offscreen,
       "moves hands offscreen; in a window and in a headset a person does. Give --display offscreen"},
      {"--poke", headset,
       "is done in a window or offscreen, not in a headset; give --display window or --display offscreen"},
      {"--force", !window, "is recorded in a window; give --display window, where there is one"},
      {"--select", !window, "is about the window's panel; give --display window, where there is one"},
      {"--output", headset,
       "is for what a window or offscreen pictures leave; give --display window or --display offscreen"},
      {"--every", headset,
       "is for what a window or offscreen pictures leave; give --display window or --display offscreen"},
      {"--size", headset, "is for a headset to say; leave it out"},
      {"--full-size", !window,
       "is about a window's pictures; offscreen and in a headset leave it out, or give --display window"},
      {"--no-video", !offscreen,
       "is about the video that --display offscreen makes; leave it out or give that"},
      {"--video-rate", !offscreen,
       "is about the video that --display offscreen makes; leave it out or give that"},
      {"--output", of == "a recording" && window,
       "is for pictures in files; a recording in a window leaves none. Give --display offscreen"},
      {"--every", of == "a recording" && window,
       "is for pictures in files; a recording in a window leaves none. Give --display offscreen"},
  };
  for (const Undone& one : options) {
    if (one.there && asked(one.option)) return std::string(one.option) + ": " + one.remedy;
  }
  return {};
}

int run_replayed(const livegs::ReplayOptions& options, bool window) {
  if (window) {
    const auto done = livegs::run_replay_window(options, interrupted);
    return done ? 0 : report(done.error());
  }
  const auto summary = livegs::run_replay(options, interrupted);
  if (!summary) return report(summary.error());
  std::fputs(livegs::summary_text(*summary).c_str(), stdout);
  std::printf("outputs in %s\n", options.output.c_str());
  return summary->error ? report(*summary->error) : 0;
}

}  // namespace

int main(int argc, char** argv) {
  livegs::OffscreenRunOptions options;
  std::string display = "auto", renderer = "auto", encoding = "drivers", size, select;
  std::vector<std::string> forces;
  std::string replay_file, subscribe;
  double from_s = 0;
  int threads = 0;
  bool verbose = false, no_video = false, unpair = false, full_size = false;
  livegs::AccessOptions access;
  CLI::App app("Sees and touches a scene that livegs-server streams", "livegs-client");
  auto* address = app.add_option("HOST:PORT", options.address, "Where the server listens");
  auto* replay = app.add_option("--replay", replay_file, "A recording (*.lvgrec) to see in place of a server")
                     ->check(CLI::ExistingFile)
                     ->excludes(address);
  app.add_option("--from", from_s, "With --replay: seconds after its beginning to start at")
      ->check(CLI::NonNegativeNumber)
      ->needs(replay);
  app.add_option("--subscribe", subscribe,
                 "tcp://127.0.0.1:PORT: only watch, by the frames that the server publishes there "
                 "(livegs-server --publish)")
      ->excludes(replay);
  app.add_option("--display", display,
                 "auto: a window where one can be opened, else offscreen; window: a desktop window; "
                 "offscreen: pictures become "
                 "files; openxr: a headset, or a window where there is none")
      ->check(CLI::IsMember({"auto", "window", "offscreen", "openxr"}))
      ->capture_default_str();
  app.add_option("--renderer", renderer,
                 "auto: Vulkan on a GPU, else the CPU; vulkan: Vulkan or nothing, in software too; cpu")
      ->check(CLI::IsMember({"auto", "vulkan", "cpu"}))
      ->capture_default_str();
  app.add_option("--seconds", options.seconds, "Of stream; 0: until the server ends, or the window is closed")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--output,-o", options.output,
                 "The folder for pictures, video and timings; with a window, for a screenshot a second")
      ->capture_default_str();
  app.add_option("--size", size, "WxH in pixels; 640x480, or the camera file's, when left out");
  app.add_option("--camera", options.camera_file,
                 "A camera file; all objects from a little above when left out");
  auto* script = app.add_option("--script", options.script_file,
                                "What the hands do, offscreen: a file of InputScript's JSON form");
  app.add_option("--poke", options.poke, "Poke the object of this name: a pull by the ray, then two balls")
      ->excludes(script);
  app.add_option("--select", select, "The object that the window's panel is about at first");
  app.add_option(
         "--force", forces,
         "OBJECT:X,Y,Z:FX,FY,FZ:SECONDS, newtons on a point of the object at rest: the window applies it "
         "once, "
         "records it to a video with its sentence beside it, and ends. Given again: several points at once")
      ->allow_extra_args(false);
  app.add_option("--video-rate", options.video_rate_hz, "Pictures a second of video")
      ->check(CLI::Range(1.0, 240.0))
      ->capture_default_str();
  app.add_option("--every", options.png_every,
                 "Keep every so many pictures as a PNG; 0: none, or with a window one a second")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  app.add_flag("--no-video", no_video, "PNGs only");
  app.add_flag(
      "--full-size", full_size,
      "Of a window: draw every picture at its size, where one that is late is drawn smaller otherwise");
  app.add_option("--cache", options.cache,
                 "Where fetched assets are kept; $XDG_CACHE_HOME/livegs when left out");
  app.add_option("--connect-timeout", options.connect_timeout_s, "Seconds to wait for a server to be ready")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  auto* reconnect =
      app.add_option(
             "--reconnect", options.reconnect_s,
             "Seconds to look for a server that went away; 10, or with a window no end, when left out")
          ->check(CLI::Range(0.0, 1e6));
  app.add_option("--most-mbit-s", options.most_mbit_s,
                 "What the link can take, megabits a second: the server sends no more, what matters most "
                 "first. As much as it gives when left out")
      ->check(CLI::Range(0.1, 1e5));
  app.add_option("--rate", options.rate_hz,
                 "Frames a second that there is a use for: the server sends every n-th tick, no fewer than "
                 "that; each when left out")
      ->check(CLI::Range(5.0, 1000.0));
  app.add_option(
         "--position-bits", options.position_bits,
         "Of elastic objects' positions along their longest side: 18 or 20 for finer steps and more bytes")
      ->check(CLI::IsMember({16, 18, 20}))
      ->capture_default_str();
  app.add_option("--encoding", encoding,
                 "What frames hold: what drives the kernels, each frame against those before (drivers) or as "
                 "floats (drivers-raw); "
                 "or, a hundred to a thousand times as many bytes, kernels that the server has moved, packed "
                 "(kernels) or as "
                 "floats (kernels-exact)")
      ->check(CLI::IsMember({"drivers", "drivers-raw", "kernels", "kernels-exact"}))
      ->capture_default_str();
  app.add_option("--pair", access.pairing_code,
                 "The pairing code that the server shows: its certificate is remembered from then on");
  app.add_option("--token-file", access.token_file,
                 "A file whose first line is the token to show, remembered too; LIVEGS_TOKEN when left out")
      ->check(CLI::ExistingFile);
  app.add_option("--state-dir", access.state_dir,
                 "Where paired servers are remembered; $XDG_STATE_HOME/livegs when left out");
  app.add_flag("--unpair", unpair, "Forget what is remembered of the server, and end");
  app.add_option("--threads", threads, "Threads that draw; 0: one a core")->check(CLI::Range(0, 1024));
  app.add_flag("--verbose", verbose, "Log more");
  app.set_version_flag("--version", LIVEGS_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (!std::isfinite(options.rate_hz)) return report(livegs::invalid_argument("--rate: is not a number"));
  if (!std::isfinite(from_s)) return report(livegs::invalid_argument("--from: is not a number"));
  if (options.address.empty() && replay_file.empty())
    return report(livegs::invalid_argument(
        "HOST:PORT: is required; where does the server listen? Or give --replay FILE"));
  livegs::PictureSize parsed;
  if (!size.empty()) {
    if (!parse_size(size, parsed))
      return report(livegs::invalid_argument("--size " + size + ": is not WxH, each 1 to 16384"));
    options.size = parsed;
  }
  options.video = !no_video;
  if (renderer != "auto")
    options.renderer = renderer == "cpu" ? livegs::RendererChoice::Cpu : livegs::RendererChoice::Vulkan;
  options.encoding = kEncodings.at(encoding);
  livegs::set_log_level(verbose ? livegs::LogLevel::Debug : livegs::LogLevel::Info);
  livegs::set_thread_count(threads);
  for (int signal_number : {SIGINT, SIGTERM}) signal(signal_number, [](int) { interrupted = true; });
  if (unpair) {
    const auto forgotten = livegs::forget_server(options.address, access.state_dir);
    return forgotten ? 0 : report(forgotten.error());
  }
  if (display == "auto") {
    const bool of_files = !options.script_file.empty() || !subscribe.empty() || no_video ||
                          app.count("--video-rate") > 0 ||
                          (!replay_file.empty() && app.count("--output") + app.count("--every") > 0);
    const bool of_window = !forces.empty() || !select.empty() || full_size;
    display = of_window || (!of_files && livegs::WindowDisplay::is_possible()) ? "window" : "offscreen";
  }
  const std::string of = !replay_file.empty() ? "a recording" : !subscribe.empty() ? "publications" : display;
  const std::string not_done =
      what_is_not_done(of, display, [&](const char* option) { return app.count(option) > 0; });
  if (!replay_file.empty() && display == "openxr")
    return report(livegs::invalid_argument(
        "--replay: plays in a window or into files, not in a headset; leave --display openxr out"));
  if (!not_done.empty()) return report(livegs::invalid_argument(not_done));
  if (!replay_file.empty()) {
    livegs::ReplayOptions replayed;
    replayed.file = replay_file;
    replayed.from_s = from_s;
    if (app.count("--seconds") > 0) replayed.seconds = options.seconds;
    replayed.cache = options.cache;
    if (app.count("--output") > 0) replayed.output = options.output;
    replayed.size = options.size;
    replayed.camera_file = options.camera_file;
    replayed.video_rate_hz = options.video_rate_hz;
    replayed.png_every = options.png_every;
    replayed.video = options.video;
    replayed.renderer = options.renderer;
    replayed.full_size = full_size;
    return run_replayed(replayed, display == "window");
  }
  auto chosen = livegs::choose_access(options.address, access);
  if (!chosen) return report(chosen.error());
  options.access = std::move(*chosen);

  if (!subscribe.empty()) {
    if (display != "offscreen") return report(livegs::invalid_argument("--subscribe: draws offscreen only"));
    const auto watched = livegs::run_spectator(subscribe, options, interrupted);
    if (!watched) return report(watched.error());
    std::fputs(livegs::summary_text(*watched).c_str(), stdout);
    std::printf("outputs in %s\n", options.output.c_str());
    if (watched->stream_error) {
      report(*watched->stream_error);
      return 1;
    }
    return 0;
  }
  livegs::JoinOptions lasting = options;  // for displays that people watch
  lasting.reconnect_after_drain = true;
  if (reconnect->count() == 0) lasting.reconnect_s = livegs::JoinOptions().reconnect_s;
  if (display == "openxr") {
    livegs::VulkanDeviceOptions device;
    device.pipeline_cache_folder = livegs::user_pipeline_cache_folder();
    auto headset = livegs::HeadsetDisplay::open(device);
    if (headset) {
      livegs::HeadsetRunOptions run;
      static_cast<livegs::JoinOptions&>(run) = lasting;
      run.seconds = app.count("--seconds") > 0 ? options.seconds : 0.0;
      run.camera_file = options.camera_file;
      const auto done = livegs::run_headset(run, **headset, interrupted);
      if (!done) return report(done.error());
      std::fputs(livegs::summary_text(*done).c_str(), stdout);
      return 0;
    }
    livegs::log_warn("%s; a window instead", headset.error().message.c_str());
    display = "window";
  }
  if (display == "window") {
    livegs::WindowRunOptions window;
    static_cast<livegs::JoinOptions&>(window) = lasting;
    window.seconds = app.count("--seconds") > 0 ? options.seconds : 0.0;
    window.size = options.size;
    window.camera_file = options.camera_file;
    window.full_size = full_size;
    window.poke = options.poke;
    window.select = select;
    for (const std::string& force : forces) {
      auto parsed_force = livegs::parse_force(force);
      if (!parsed_force) return report(parsed_force.error());
      window.forces.push_back(std::move(*parsed_force));
    }
    if (app.count("--output") > 0) window.screenshots = options.output;
    if (app.count("--every") > 0) window.screenshot_every = options.png_every;
    if (const auto done = livegs::run_window(window, interrupted); !done) return report(done.error());
    return 0;
  }
  const auto summary = livegs::run_offscreen(options, interrupted);
  if (!summary) return report(summary.error());
  std::fputs(livegs::summary_text(*summary).c_str(), stdout);
  std::printf("outputs in %s\n", options.output.c_str());
  if (summary->stream_error) {
    report(*summary->stream_error);
    return 1;
  }
  return 0;
}
