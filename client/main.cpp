// SPDX-License-Identifier: Apache-2.0
// livegs-client: shows a scene streamed by livegs-server and sends input. Exit codes: 0 success, 1 failure, 2
// bad usage or input.
#include <signal.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <string>

#include "core/log.h"
#include "core/parallel_for.h"
#include "core/require_processor.h"
#include "core/text/help_format.h"
#include "core/written_files.h"
#include "viewer/runs/headset_run.h"
#include "viewer/runs/offscreen_run.h"
#include "viewer/runs/replay_run.h"
#include "viewer/runs/spectate_run.h"
#include "viewer/runs/window_run.h"
#include "viewer/study/force_study.h"
#include "xr/window_display.h"

namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "the flag is set by a signal handler");

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

// Returns an error for the first option that does not apply to this run, empty if none. `of`: openxr, window,
// offscreen, or "a recording" or "publications", which accept no input; `display`: the output.
std::string what_is_not_done(const std::string& of, const std::string& display,
                             const std::function<bool(const char*)>& asked) {
  const bool watched = of == "a recording" || of == "publications";
  for (const char* option : {"--script", "--poke", "--force", "--select"}) {
    if (watched && asked(option))
      return std::string(option) + ": has no effect with " + of + "; remove the option";
  }
  const bool headset = display == "openxr", window = display == "window", offscreen = display == "offscreen";
  struct Undone {
    const char* option;
    bool there;  // true: the option does not apply
    const char* remedy;
  };
  const Undone options[] = {
      {"--script", !offscreen, "applies to --display offscreen only; add --display offscreen"},
      {"--poke", headset, "does not apply to a headset; use --display window or --display offscreen"},
      {"--force", !window, "applies to a window only; use --display window on a desktop"},
      {"--select", !window, "applies to a window only; use --display window on a desktop"},
      {"--output", headset, "does not apply to a headset; use --display window or --display offscreen"},
      {"--every", headset, "does not apply to a headset; use --display window or --display offscreen"},
      {"--size", headset, "does not apply to a headset; remove the option"},
      {"--full-size", !window, "applies to a window only; remove the option, or use --display window"},
      {"--ui-scale", !window, "applies to a window only; remove the option, or use --display window"},
      {"--no-video", !offscreen,
       "applies to --display offscreen only; remove the option, or use --display offscreen"},
      {"--video-rate", !offscreen,
       "applies to --display offscreen only; remove the option, or use --display offscreen"},
      {"--output", of == "a recording" && window,
       "does not apply to a recording in a window; use --display offscreen"},
      {"--every", of == "a recording" && window,
       "does not apply to a recording in a window; use --display offscreen"},
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
  std::fputs(livegs::written_files_text().c_str(), stdout);
  return summary->error ? report(*summary->error) : 0;
}

}  // namespace

int main(int argc, char** argv) {
  livegs::require_processor();
  livegs::OffscreenRunOptions options;
  std::string display = "auto", renderer = "auto", encoding = "drivers", size, select;
  std::vector<std::string> forces;
  std::string replay_file, subscribe;
  double from_s = 0;
  double ui_scale = 0;
  int threads = 0;
  bool verbose = false, no_video = false, unpair = false, full_size = false, no_shadows = false;
  livegs::AccessOptions access;
  CLI::App app("Shows a scene streamed by livegs-server and sends input to it", "livegs-client");
  auto* address = app.add_option("HOST:PORT", options.address, "Address of the server");
  auto* replay =
      app.add_option("--replay", replay_file, "Play a recording (*.lvgrec) instead of connecting to a server")
          ->check(CLI::ExistingFile)
          ->excludes(address);
  app.add_option("--from", from_s, "With --replay: start time in seconds")
      ->check(CLI::NonNegativeNumber)
      ->needs(replay);
  app.add_option(
         "--subscribe", subscribe,
         "Watch the frames published at tcp://127.0.0.1:PORT (livegs-server --publish), without input")
      ->excludes(replay);
  app.add_option(
         "--display", display,
         "window: a desktop window; offscreen: picture files; openxr: a headset, or a window if there is "
         "none; auto: a window if possible, else offscreen")
      ->check(CLI::IsMember({"auto", "window", "offscreen", "openxr"}))
      ->capture_default_str();
  app.add_option("--renderer", renderer,
                 "auto: Vulkan on a GPU, else the CPU; vulkan: Vulkan only, also on a software device; cpu")
      ->check(CLI::IsMember({"auto", "vulkan", "cpu"}))
      ->capture_default_str();
  app.add_option("--seconds", options.seconds,
                 "Duration; 0: until the server ends or the window is closed (default: 10 offscreen, 0 in a "
                 "window or a headset)")
      ->check(CLI::NonNegativeNumber);
  app.add_option(
      "--output,-o", options.output,
      "Folder for pictures, video and timings (default: out/client); window mode: for a screenshot per "
      "second, and for recordings (default: no screenshots, recordings in out/study)");
  app.add_option(
      "--size", size,
      "Picture size in pixels (default: that of the camera file, else 1280x800 in a window and 640x480 "
      "offscreen)");
  app.add_option("--camera", options.camera_file, "Camera file (default: all objects, from slightly above)");
  auto* script = app.add_option("--script", options.script_file,
                                "Offscreen mode: input script of the hands (JSON, message InputScript)");
  app.add_option("--poke", options.poke,
                 "Poke the named object: pull it with the ray of a hand, then shoot two balls at it")
      ->excludes(script);
  app.add_option("--select", select, "Object selected in the panel at the start");
  app.add_option("--force", forces,
                 "Window mode: apply the force FX,FY,FZ in newtons (world axes) for SECONDS, at most 60, at "
                 "the point X,Y,Z in metres (object at rest), record a video and a description, and exit. "
                 "Repeat the option for several points at once")
      ->allow_extra_args(false);
  app.add_option("--video-rate", options.video_rate_hz, "Video frame rate in Hz")
      ->check(CLI::Range(1.0, 240.0))
      ->capture_default_str();
  app.add_option(
         "--every", options.png_every,
         "Save every Nth picture as PNG; 0: none (default: 30 offscreen; window mode with --output: one per "
         "second)")
      ->check(CLI::Range(0, 1000000));
  app.add_flag("--no-video", no_video, "Save PNGs only");
  app.add_flag("--no-shadows", no_shadows, "Draw objects without contact and soft shadows");
  app.add_flag(
      "--full-size", full_size,
      "Window mode: always render at full resolution (default: reduce resolution when frames are late)");
  app.add_option("--ui-scale", ui_scale,
                 "Window mode: scale of texts and panels (default: that of the monitor)")
      ->check(CLI::Range(livegs::kMinUiScale, livegs::kMaxUiScale));
  app.add_option("--cache", options.cache, "Folder for fetched assets (default: $XDG_CACHE_HOME/livegs)");
  app.add_option("--connect-timeout", options.connect_timeout_s, "Time limit until the server is ready")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  auto* reconnect = app.add_option("--reconnect", options.reconnect_s,
                                   "Time limit for reconnecting after a connection loss (default: 10; window "
                                   "mode: none)")
                        ->check(CLI::Range(0.0, 1e6));
  app.add_option("--max-mbit-s", options.max_mbit_s,
                 "Bandwidth limit of frames and assets together, in Mbit/s; important objects are sent first "
                 "(default: no limit)")
      ->check(CLI::Range(0.1, 1e5));
  app.add_option(
         "--rate", options.rate_hz,
         "Minimum frame rate in Hz; the server sends every n-th tick, at least at this rate (default: every "
         "tick)")
      ->check(CLI::Range(5.0, 1000.0));
  app.add_option("--position-bits", options.position_bits,
                 "Bits of positions along the longest side of an elastic object; 18 or 20: finer steps, more "
                 "bandwidth")
      ->check(CLI::IsMember({16, 18, 20}))
      ->capture_default_str();
  app.add_option(
         "--encoding", encoding,
         "Frame contents. drivers: state that drives the kernels, delta-coded; drivers-raw: the same state "
         "as 32-bit floats; kernels: transformed kernels, packed; kernels-exact: the same kernels as "
         "32-bit floats. Kernels need a hundred to a thousand times the bandwidth of drivers")
      ->check(CLI::IsMember({"drivers", "drivers-raw", "kernels", "kernels-exact"}))
      ->capture_default_str();
  app.add_option("--pair", access.pairing_code,
                 "Pairing code displayed by the server; its certificate is stored");
  app.add_option(
         "--token-file", access.token_file,
         "File with the access token in its first line; the token is stored (default: the value of the "
         "variable LIVEGS_TOKEN, else the stored token)")
      ->check(CLI::ExistingFile);
  app.add_option("--state-dir", access.state_dir,
                 "Folder for paired servers (default: $XDG_STATE_HOME/livegs)");
  app.add_flag("--unpair", unpair, "Delete the stored pairing data of the server, and exit");
  app.add_option("--threads", threads, "Rendering threads; 0: one per core")->check(CLI::Range(0, 1024));
  app.add_flag("--verbose", verbose, "Verbose logging");
  app.set_version_flag("--version", LIVEGS_VERSION);
  using livegs::group_options;
  group_options(app, "Display",
                {{"--display", ""},
                 {"--renderer", ""},
                 {"--size", "WxH"},
                 {"--full-size", ""},
                 {"--ui-scale", "NUMBER"},
                 {"--camera", "FILE"},
                 {"--select", "NAME"},
                 {"--seconds", "SECONDS"},
                 {"--threads", ""}});
  group_options(app, "Output",
                {{"--output", "FOLDER"}, {"--every", ""}, {"--video-rate", "HZ"}, {"--no-video", ""}});
  group_options(app, "Input",
                {{"--script", "FILE"}, {"--poke", "NAME"}, {"--force", "NAME:X,Y,Z:FX,FY,FZ:SECONDS"}});
  group_options(app, "Connection",
                {{"--connect-timeout", "SECONDS"},
                 {"--reconnect", "SECONDS"},
                 {"--max-mbit-s", "NUMBER"},
                 {"--rate", "HZ"},
                 {"--position-bits", ""},
                 {"--encoding", ""},
                 {"--cache", "FOLDER"}});
  group_options(app, "Access to other machines",
                {{"--pair", "CODE"}, {"--token-file", "FILE"}, {"--state-dir", "FOLDER"}, {"--unpair", ""}});
  group_options(app, "Recordings and publications",
                {{"--replay", "FILE"}, {"--from", "SECONDS"}, {"--subscribe", "tcp://HOST:PORT"}});
  app.formatter(std::make_shared<livegs::HelpFormatter>());
  app.footer(
      "Examples:\n"
      "  livegs-client 127.0.0.1:9780                     # a window\n"
      "  livegs-client 127.0.0.1:9780 --display offscreen --seconds 5 --poke cup -o out/cup\n"
      "  livegs-client HOST:9780 --pair CODE --token-file my.token    # a server on another machine, once\n"
      "  livegs-client --replay session.lvgrec            # a recording");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (!std::isfinite(options.rate_hz))
    return report(livegs::invalid_argument("--rate: is not a number; give 5 to 1000 Hz"));
  if (!std::isfinite(from_s))
    return report(livegs::invalid_argument("--from: is not a number; give a time in seconds"));
  if (options.address.empty() && replay_file.empty())
    return report(
        livegs::invalid_argument("HOST:PORT: is required; give the server's address, or --replay FILE"));
  livegs::PictureSize parsed;
  if (!size.empty()) {
    if (!parse_size(size, parsed))
      return report(livegs::invalid_argument("--size " + size + ": is not WxH; give 1 to 16384 for each"));
    options.size = parsed;
  }
  options.video = !no_video;
  options.shadows = !no_shadows;
  if (renderer != "auto")
    options.renderer = renderer == "cpu" ? livegs::RendererChoice::Cpu : livegs::RendererChoice::Vulkan;
  options.encoding = kEncodings.at(encoding);
  livegs::set_log_level(verbose ? livegs::LogLevel::Debug : livegs::LogLevel::Info);
  livegs::set_thread_count(threads);
  for (int signal_number : {SIGINT, SIGTERM}) signal(signal_number, [](int) { interrupted = true; });
  if (unpair) {
    const auto unpaired = livegs::unpair_server(options.address, access.state_dir);
    return unpaired ? 0 : report(unpaired.error());
  }
  if (display == "auto") {
    const bool of_files = !options.script_file.empty() || !subscribe.empty() || no_video ||
                          app.count("--video-rate") > 0 ||
                          (!replay_file.empty() && app.count("--output") + app.count("--every") > 0);
    const bool of_window = !forces.empty() || !select.empty() || full_size || ui_scale > 0;
    display = of_window || (!of_files && livegs::WindowDisplay::is_possible()) ? "window" : "offscreen";
  }
  const std::string of = !replay_file.empty() ? "a recording" : !subscribe.empty() ? "publications" : display;
  const std::string not_done =
      what_is_not_done(of, display, [&](const char* option) { return app.count(option) > 0; });
  if (!replay_file.empty() && display == "openxr")
    return report(
        livegs::invalid_argument("--replay: is not supported in a headset; remove --display openxr"));
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
    replayed.shadows = options.shadows;
    replayed.full_size = full_size;
    replayed.ui_scale = ui_scale;
    return run_replayed(replayed, display == "window");
  }
  auto chosen = livegs::choose_access(options.address, access);
  if (!chosen) return report(chosen.error());
  options.access = std::move(*chosen);

  if (!subscribe.empty()) {
    if (display != "offscreen")
      return report(
          livegs::invalid_argument("--subscribe: is not supported in a window; use --display offscreen"));
    const auto watched = livegs::run_spectator(subscribe, options, interrupted);
    if (!watched) return report(watched.error());
    std::fputs(livegs::summary_text(*watched).c_str(), stdout);
    std::fputs(livegs::written_files_text().c_str(), stdout);
    if (watched->stream_error) {
      report(*watched->stream_error);
      return 1;
    }
    return 0;
  }
  livegs::JoinOptions lasting = options;  // defaults of interactive displays
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
    livegs::log_warn("headset: a window is opened instead (%s)", headset.error().message.c_str());
    display = "window";
  }
  if (display == "window") {
    livegs::WindowRunOptions window;
    static_cast<livegs::JoinOptions&>(window) = lasting;
    window.seconds = app.count("--seconds") > 0 ? options.seconds : 0.0;
    window.size = options.size;
    window.camera_file = options.camera_file;
    window.full_size = full_size;
    window.ui_scale = ui_scale;
    window.poke = options.poke;
    window.select = select;
    for (const std::string& force : forces) {
      auto parsed_force = livegs::parse_force(force);
      if (!parsed_force) return report(parsed_force.error());
      window.forces.push_back(std::move(*parsed_force));
    }
    if (app.count("--output") > 0) window.screenshots = options.output;
    if (app.count("--every") > 0) window.screenshot_every = options.png_every;
    const auto done = livegs::run_window(window, interrupted);
    std::fputs(livegs::written_files_text().c_str(), stdout);
    return done ? 0 : report(done.error());
  }
  const auto summary = livegs::run_offscreen(options, interrupted);
  if (!summary) return report(summary.error());
  std::fputs(livegs::summary_text(*summary).c_str(), stdout);
  std::fputs(livegs::written_files_text().c_str(), stdout);
  if (summary->stream_error && !summary->error_logged) report(*summary->stream_error);
  return summary->stream_error ? 1 : 0;
}
