// SPDX-License-Identifier: GPL-3.0-or-later
// livegs-server: simulates a scene and streams it. Exit codes: 0 success, 1 failure, 2 bad usage or input.
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>

#include "analysis/model/endpoint_choice.h"
#include "core/clock.h"
#include "core/log.h"
#include "core/log_format.h"
#include "core/parallel_for.h"
#include "core/require_processor.h"
#include "core/text/format_text.h"
#include "core/text/help_format.h"
#include "device/choose_physics.h"
#include "ending_signals.h"
#include "scene/build/build_cache.h"
#include "scene/scene.h"
#include "service_notice.h"
#include "session/access/fleet_token.h"
#include "session/access/server_security.h"
#include "session/fleet/agones_sdk.h"
#include "session/fleet/fleet_member.h"
#include "session/live/analysis_controller.h"
#include "session/live/run_controller.h"
#include "session/live/scene_author.h"
#include "session/metrics/metrics.h"
#include "session/metrics/run_summary.h"
#include "session/recording/session_recorder.h"
#include "session/rpc/grpc_server.h"
#include "session/sessions/session_table.h"
#include "session/simulation/simulation_loop.h"
#include "session/stored/stored_scene.h"
#include "session/support/scene_memory.h"
#include "store/object_store.h"
#include "trust/fingerprint.h"
#include "trust/state_folder.h"
#include "web/qr_text.h"

namespace {

struct Options {
  std::string scene, asset_store, client_store;
  std::string listen = "127.0.0.1:9780";
  std::string tls = "auto";
  std::string state_dir, certificate, key;
  std::vector<std::string> allowed_origins;
  std::optional<livegs::HostPort> metrics;
  std::optional<double> client_mbit_s;
  size_t clients = livegs::kDefaultSessions;
  std::string log_format = "text";
  std::optional<double> rate_hz;
  std::optional<int> substeps;
  bool drop = false;
  int threads = 0;
  std::string physics = "cpu";
  double seconds = 0;
  std::string publish;
  std::string record;
  livegs::RecordingOptions recording;
  bool print_port = false;
  bool fresh = false;  // --new
  bool wait_for_client = false;
  bool verbose = false;
  livegs::EndpointChoice endpoint;
  int views = 1;
  std::string fleet;
  double fleet_empty_s = livegs::kFleetEmpty_s;
  std::string fleet_key;
  std::string server_name;
};

int report(const livegs::Error& error) {
  std::fprintf(stderr, "livegs-server: %s\n", error.message.c_str());
  return error.code == livegs::ErrorCode::Unavailable || error.code == livegs::ErrorCode::Internal ? 1 : 2;
}

// Certificate and tokens for remote clients; null without TLS.
livegs::Result<std::unique_ptr<livegs::ServerSecurity>> open_security(const Options& options) {
  using namespace livegs;
  const bool on =
      options.tls == "on" || (options.tls == "auto" && !check_listen_address(options.listen, false));
  if (auto checked = check_listen_address(options.listen, on); !checked) return checked.error();
  if (!on) return std::unique_ptr<ServerSecurity>();
  auto folder = state_folder(options.state_dir);
  if (!folder) return folder.error();
  std::optional<CertificateFiles> own;
  if (!options.certificate.empty()) own = CertificateFiles{options.certificate, options.key};
  return ServerSecurity::open(*folder, system_wall_clock(), own);
}

// Empty if `text` is the origin of a site (RFC 6454), else the reason.
std::string check_origin(const std::string& text) {
  const size_t host = text.starts_with("https://") ? 8 : text.starts_with("http://") ? 7 : 0;
  const std::string_view name = std::string_view(text).substr(host);
  const bool good =
      host > 0 && !name.empty() &&
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789.-:[]") == std::string_view::npos;
  return good ? "" : text + ": is not an origin; give scheme and host only, such as https://example.org";
}

// Address of the store for clients, without a slash at the end; empty: they fetch from the server.
std::string client_store(const Options& options) {
  std::string place = options.client_store;
  if (place.empty()) {
    place = options.asset_store;
    if (place.empty()) place = options.scene.substr(0, options.scene.rfind('/'));
    const bool open = place.starts_with("http://") || place.starts_with("https://");
    if (!open || livegs::shown_url(place) != place) return "";  // never passes a key on
  }
  while (place.ends_with('/')) place.pop_back();
  return place;
}

// Address at which clients reach the server.
std::string client_address(const Options& options, int port) {
  const std::string host = options.listen.substr(0, options.listen.rfind(':'));
  std::array<char, 256> name{};
  const bool any = host == "0.0.0.0" || host == "[::]";
  if (any && gethostname(name.data(), name.size() - 1) != 0) name = {};
  return (any && name[0] != 0 ? std::string(name.data()) : host) + ":" + std::to_string(port);
}

// Logs that clients may join, and prints the commands for it, each on a line of its own, to be copied.
void announce(const Options& options, livegs::GrpcServer& server, const livegs::ServerSecurity* security) {
  const int port = server.port();
  const std::string address = client_address(options, port);
  const std::string ctl = "livegs ctl --server 127.0.0.1:" + std::to_string(port) +
                          (options.state_dir.empty() ? "" : " --state-dir '" + options.state_dir + "'");
  std::string client = "livegs-client " + address, token;
  if (security) {
    client += " --pair " + livegs::pairing_code(security->fingerprint()) + " --token-file client.token";
    token = ctl + " tokens add client > client.token";
  }
  if (options.log_format == "json") {
    livegs::log_info("ready on %s: %s", address.c_str(), client.c_str());
    return;
  }
  livegs::log_info("ready on %s", address.c_str());
  if (security) std::fprintf(stderr, "Create a token for a client, here:\n  %s\n", token.c_str());
  std::fprintf(stderr, "Connect a client:\n  %s\n", client.c_str());
  // The code in the link is a secret for ten minutes, so it is printed to terminals only, not to a log.
  if (security && ::isatty(STDERR_FILENO) == 0) {
    std::fprintf(stderr, "Print a link for a browser:\n  %s link\n", ctl.c_str());
    return;
  }
  const livegs::v1::BrowserLink link = server.new_browser_link();
  std::fprintf(stderr, "Or open in a browser%s:\n", security ? ", once, within ten minutes" : "");
  for (const std::string& url : link.urls()) std::fprintf(stderr, "  %s\n", url.c_str());
  if (!security || link.urls().empty()) return;
  std::fputs(livegs::qr_text(link.urls(0)).c_str(), stderr);
  std::fprintf(stderr, "  The browser warns about the certificate. Its SHA-256 fingerprint is\n  %s\n",
               link.fingerprint().c_str());
}

// Joins the fleet, if there is one, and accepts its tokens. Null without a fleet, and after a signal, whose
// reason is then in `stopped`.
livegs::Result<std::unique_ptr<livegs::FleetMember>> join_fleet(const Options& options,
                                                                livegs::ServerSecurity* security,
                                                                const sigset_t& signals,
                                                                std::string& stopped) {
  using namespace livegs;
  std::string key, name = options.server_name;
  if (!options.fleet_key.empty()) {
    if (!security) return invalid_argument("--fleet-key: needs TLS; use --tls on");
    if (options.fleet.empty() && name.empty())
      return invalid_argument(
          "--fleet-key: needs the name for which tokens are signed; add --server-name NAME");
    auto read = read_fleet_key(options.fleet_key);
    if (!read) return read.error();
    key = std::move(*read);
  }
  std::unique_ptr<FleetMember> fleet;
  if (!options.fleet.empty()) {
    const auto port = AgonesSdk::port_of_environment();
    if (!port) return port.error();
    fleet =
        std::make_unique<FleetMember>(FleetMember::Options{.port = *port, .empty_s = options.fleet_empty_s});
    stopped = wait_for_signal(signals, [&] { return fleet->name().has_value(); });
    if (!stopped.empty()) return std::unique_ptr<FleetMember>();
    const auto found = *fleet->name();
    if (!found) return found.error();
    if (name.empty()) name = *found;
  }
  if (!key.empty()) security->tokens().accept_fleet(std::move(key), std::move(name));
  return fleet;
}

// Fetches the scene of a store. After a signal its reason is in `stopped`, and the result is not used.
livegs::Result<livegs::StoredScene> fetch_scene(const Options& options, const sigset_t& signals,
                                                std::string& stopped) {
  using namespace livegs;
  std::stop_source stop;
  auto fetched = std::async(std::launch::async, [&] {
    return StoredScene::fetch(options.scene, options.asset_store, stop.get_token());
  });
  stopped = wait_for_signal(
      signals, [&] { return fetched.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
  if (!stopped.empty()) stop.request_stop();
  return fetched.get();
}

// Exit code of a server that a signal ends before it has a scene. `fleet` may be null.
int end_of_start(livegs::FleetMember* fleet, const std::string& reason) {
  if (fleet) (void)fleet->leave();
  livegs::log_info("server: shutting down: %s", reason.c_str());
  return 0;
}

// Empty if `text` is an address that clients may fetch from, else the reason.
std::string check_store(const std::string& text) {
  const bool good = (text.starts_with("http://") || text.starts_with("https://")) &&
                    text.find_first_of(" ?#;,@'\"") == std::string::npos;
  return good ? ""
              : livegs::shown_url(text) +
                    ": is not a store for clients; give an http:// or https:// address without a user";
}

int run(const Options& options) {
  using namespace livegs;
  // A range check accepts NaN.
  if (!std::isfinite(options.seconds) || !std::isfinite(options.rate_hz.value_or(1.0)) ||
      !std::isfinite(options.client_mbit_s.value_or(1.0))) {
    return report(invalid_argument("--seconds, --rate, --client-mbit-s: must be finite numbers"));
  }
  const sigset_t signals = block_ending_signals();
  set_log_level(options.verbose ? LogLevel::Debug : LogLevel::Info);
  if (options.log_format == "json") log_as_json();
  set_thread_count(options.threads);
  auto physics = choose_physics(options.physics);
  if (!physics) return report(physics.error());
  set_elastic_device(*physics);

  auto endpoint = choose_endpoint(options.endpoint);
  if (!endpoint) return report(endpoint.error());

  ServiceNotice notice;
  // Bind the port first: an error is reported at once, and early clients get UNAVAILABLE.
  const auto security = open_security(options);
  if (!security) return report(security.error());
  auto server = GrpcServer::listen(options.listen, security->get());
  if (!server) return report(server.error());
  (*server)->admit(options.clients);
  (*server)->allow_origins(options.allowed_origins);
  if (options.client_mbit_s) (*server)->cap_clients(*options.client_mbit_s);
  if (!options.publish.empty()) {
    const auto published = (*server)->publish(options.publish);
    if (!published) return report(published.error());
    log_info("publishing on %s", published->c_str());
  }

  std::string stopped;
  const auto fleet = join_fleet(options, security->get(), signals, stopped);
  if (!fleet) return report(fleet.error());
  if (!stopped.empty()) return end_of_start(fleet->get(), stopped);

  const int64_t begun_ns = now_ns();
  SceneOptions scene_options;
  scene_options.rate_hz = options.rate_hz;
  scene_options.substeps = options.substeps;
  scene_options.drop = options.drop;
  scene_options.wait_for_pieces = options.wait_for_client;
  scene_options.cache = std::make_shared<BuildCache>();
  // Files that come from a store. They are fetched while the port is bound, so that early clients wait.
  std::optional<StoredScene> stored;
  std::string scene_path = options.scene;
  if (!options.asset_store.empty() || is_store_url(options.scene)) {
    const std::string place = client_store(options);
    if (place.empty())
      log_info(
          "store: clients fetch assets from this server; give --client-store URL to have them fetched there");
    else
      (*server)->allow_store(place);
    auto fetched = fetch_scene(options, signals, stopped);
    if (!stopped.empty()) return end_of_start(fleet->get(), stopped);
    if (!fetched) return report(fetched.error());
    stored.emplace(*std::move(fetched));
    scene_path = stored->path();
    if (!place.empty()) (*server)->use_store({place + "/assets", stored->assets()});
  }
  auto text = options.fresh ? new_scene(scene_path) : read_scene(scene_path, options.drop);
  if (!text) return report(text.error());
  if (auto fits = check_scene_memory(scene_path, options.clients); !fits) return report(fits.error());
  auto document = SceneDocument::open(*std::move(text));
  if (!document) return report(document.error());
  auto scene = Scene::build(document->scene(), document->folder(), document->name(), scene_options);
  if (!scene) {
    return report({scene.error().code, document->name() + ": " + scene.error().message});
  }
  log_info("scene %s: %zu objects, built in %.1f s", scene->name().c_str(), scene->objects().size(),
           seconds_from_ns(now_ns() - begun_ns));

  const std::string label = scene_label(document->scene());

  auto analysed = SceneAnalysis::of(*scene, *endpoint != nullptr);
  if (!analysed) return report(analysed.error());
  SimulationLoop loop(std::move(*scene), (*server)->ticks());
  AnalysisControllerOptions analysis_options;
  analysis_options.views = options.views;
  // Without a cache, so that a recording of answers is complete.
  if (options.endpoint.recorded.empty() && options.endpoint.record.empty() && !cache_folder().empty()) {
    analysis_options.answers = cache_folder() / "answers";
  }
  AnalysisController analysis(std::move(*analysed), std::move(*endpoint), loop, analysis_options);
  SceneAuthor author(std::move(*document), scene_options, loop, analysis);
  RunController run(
      loop,
      [&](uint32_t first_object_id) -> Result<Scene> {
        if (auto fits = check_scene_memory(scene_path, options.clients); !fits) return fits.error();
        return author.build(first_object_id);
      },
      [&](Scene loaded) {
        (*server)->encode_ahead(loaded);
        analysis.replace(std::move(loaded));
        author.installed();
      });
  loop.record_with((*server)->recorder());
  if (!options.record.empty()) {
    if (auto begun = (*server)->recorder().start(options.record, options.recording); !begun)
      return report(begun.error());
  }
  // Before clients can join, so that a port in use ends the server without disconnecting them.
  std::unique_ptr<Metrics> metrics;
  if (options.metrics) {
    auto served =
        Metrics::serve(*options.metrics, {(*server)->session_table(), [&] { return loop.summary(); },
                                          [&] { return (*server)->published(); },
                                          [&] { return (*server)->asset_bytes_sent(); }});
    if (!served) return report(served.error());
    metrics = std::move(*served);
    log_info("metrics: %s", metrics->url().c_str());
  }
  (*server)->open(loop.scene(), loop);
  (*server)->open_analysis(analysis);
  (*server)->open_run(run);
  (*server)->open_author(author);
  std::mutex drain_mutex;
  std::string drained;  // the reason, once requested
  (*server)->open_drain([&](const std::string& reason) {
    std::lock_guard lock(drain_mutex);
    drained = reason;
  });
  const auto drain_reason = [&] {
    std::lock_guard lock(drain_mutex);
    return drained;
  };
  announce(options, **server, security->get());
  if (options.print_port) {
    std::printf("%d\n", (*server)->port());
    std::fflush(stdout);
  }
  notice.say("READY=1\nSTATUS=Serving " + loop.scene().name());

  std::string reason;
  if (options.wait_for_client) {
    reason =
        wait_for_signal(signals, [&] { return (*server)->streaming_count() > 0 || !drain_reason().empty(); });
    if (reason.empty()) reason = drain_reason();
  }
  if (reason.empty()) {
    if (options.wait_for_client && (*server)->starter_joined()) loop.wait_to_start();
    loop.start();
    analysis.begin();
    if (*fleet) {
      (*fleet)->open(label, [&]() -> FleetMember::Facts {
        return {(*server)->published().frames, (*server)->client_count(), options.clients,
                loop.summary().step_ms_p99};
      });
    }
    const int64_t end_ns = now_ns() + static_cast<int64_t>(options.seconds * 1e9);
    reason = wait_for_signal(signals, [&] {
      notice.feed((*server)->published().frames, now_ns());
      return (options.seconds > 0 && now_ns() >= end_ns) || !drain_reason().empty() ||
             (*fleet && (*fleet)->empty());
    });
    if (reason.empty()) reason = drain_reason();
    if (reason.empty() && *fleet && (*fleet)->empty())
      reason = format_text("no person for %.0f s", options.fleet_empty_s);
    if (reason.empty()) reason = "the time limit is reached";
  }
  log_info("server: shutting down: %s", reason.c_str());
  notice.say("STOPPING=1");
  (*server)->shut_down(reason, *fleet ? (*fleet)->leave() : Successor());
  loop.stop();
  if (const auto recorded = (*server)->recorder().stop();
      !recorded && recorded.error().code != ErrorCode::NotFound)
    log_warn("%s", recorded.error().message.c_str());
  std::fputs(run_summary(loop.scene(), loop.summary(), (*server)->published(), (*server)->sessions()).c_str(),
             stdout);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  livegs::require_processor();
  Options options;
  CLI::App app("Simulates a scene of Gaussian splats and streams it to livegs-client", "livegs-server");
  app.add_option(
         "SCENE", options.scene,
         "A *.scene.json file, a folder of assets, or the address of a scene that livegs publish stored")
      ->required();
  app.add_option("--asset-store", options.asset_store,
                 "Folder, http(s):// or s3://BUCKET/PREFIX of livegs publish. Missing files of SCENE and the "
                 "clients' assets are fetched from it (default: the folder of SCENE)")
      ->type_name("PLACE");
  app.add_option("--client-store", options.client_store,
                 "Address of the same store for clients, if it differs (default: the http(s):// address "
                 "of --asset-store or SCENE; else clients fetch from this server)")
      ->check(check_store);
  app.add_option(
         "--listen", options.listen,
         "Address; port 0 lets the system choose. 0.0.0.0 accepts other machines, with TLS and a token")
      ->capture_default_str();
  app.add_option("--tls", options.tls,
                 "on; off: local clients only; auto: on unless the listen address is local")
      ->check(CLI::IsMember({"auto", "on", "off"}))
      ->capture_default_str();
  app.add_option("--state-dir", options.state_dir,
                 "Folder of the certificate and the tokens (default: $XDG_STATE_HOME/livegs)");
  auto* certificate =
      app.add_option("--certificate", options.certificate,
                     "PEM file of a certificate that browsers trust, with the certificates of "
                     "its issuers (default: a self-signed certificate, which browsers "
                     "warn about)")
          ->check(CLI::ExistingFile);
  certificate->needs(app.add_option("--key", options.key, "PEM file of the key of --certificate")
                         ->check(CLI::ExistingFile)
                         ->needs(certificate));
  app.add_option("--allow-origin", options.allowed_origins,
                 "Origin, such as https://example.org, of pages that may embed the scene by <livegs-view>; "
                 "may be repeated (default: none)")
      ->check(check_origin);
  app.add_option("--rate", options.rate_hz, "Ticks per second (default: set by the scene)")
      ->check(CLI::Range(1.0, 2000.0));
  app.add_flag("--drop", options.drop,
               "Folder of assets: drop the objects onto the floor instead of placing them on it");
  app.add_option("--substeps", options.substeps, "Substeps per tick (default: set by the scene)")
      ->check(CLI::Range(1, 1024));
  app.add_option("--threads", options.threads, "Simulation threads; 0: one per core")
      ->check(CLI::Range(0, 1024));
  app.add_option("--physics", options.physics, livegs::kPhysicsHelp)
      ->check(CLI::IsMember(livegs::kPhysicsChoices))
      ->capture_default_str();
  app.add_option("--seconds", options.seconds, "Stop after this time; 0: run until stopped (default: 0)")
      ->check(CLI::NonNegativeNumber);
  app.add_option_function<std::string>(
         "--metrics",
         [&options](const std::string& text) { options.metrics = *livegs::parse_metrics_address(text); },
         "Serve Prometheus metrics on this port of 127.0.0.1, or at this address, in clear text; with port "
         "0, "
         "the system chooses (default: off)")
      ->check([](const std::string& text) {
        const auto where = livegs::parse_metrics_address(text);
        return where ? std::string() : where.error().message;
      });
  app.add_option(
         "--client-mbit-s", options.client_mbit_s,
         "Bandwidth limit per client in Mbit/s, of frames and assets together; the least visible objects "
         "are delayed (default: no limit)")
      ->check(CLI::Range(0.1, 1e5));
  app.add_option("--clients", options.clients,
                 "Maximum number of clients; a disconnected client keeps its slot for 30 s")
      ->check(CLI::Range(size_t{1}, livegs::kMaxSessions))
      ->capture_default_str();
  app.add_option("--publish", options.publish,
                 "Publish frames to local subscribers (livegs-client --subscribe), "
                 "without tokens; port 0 lets the system choose (default: off)");
  app.add_option("--record", options.record,
                 "Record the session to this new file, *.lvgrec, from the first tick on (livegs ctl record "
                 "starts later)");
  app.add_flag("--record-inputs-only", options.recording.inputs_only,
               "Record inputs without frames: the recording can be verified but not played");
  app.add_flag("--record-assets", options.recording.assets,
               "Include assets and scene files, so that the recording can be played and verified anywhere");
  app.add_option("--log-format", options.log_format, "text, or json: one object per line")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
  app.add_flag("--print-port", options.print_port, "Print the port to standard output when clients can join");
  auto* waits = app.add_flag(
      "--wait-for-client", options.wait_for_client,
      "Delay the first tick until a client has drawn its first picture and starts the simulation");
  auto* fleet = app.add_option("--fleet", options.fleet,
                               "agones: run as a GameServer and report the state to the sidecar on port "
                               "AGONES_SDK_HTTP_PORT. The sidecar must reply within 30 s")
                    ->check(CLI::IsMember({"agones"}))
                    ->excludes(waits);  // without ticks there is no Health
  app.add_option("--fleet-empty-s", options.fleet_empty_s,
                 "Shut down after this time without a person, if the server was allocated")
      ->check(CLI::Range(1.0, 1e6))
      ->capture_default_str()
      ->needs(fleet);
  app.add_option("--fleet-key", options.fleet_key,
                 "Also accept tokens that livegs token signed with this key for this server");
  app.add_option("--server-name", options.server_name,
                 "Name for which tokens are signed (default: the name of the GameServer)");
  app.add_flag(
      "--new", options.fresh,
      "Begin an empty scene: SCENE is a folder of assets, or a *.scene.json that does not exist yet");
  app.add_option(
      "--endpoint", options.endpoint.url,
      "URL of a chat completions server that estimates materials. Default: the variable "
      "OPENAI_BASE_URL, with LIVEGS_MODEL and OPENAI_API_KEY. Without a URL, estimates are offline");
  app.add_option("--model", options.endpoint.model,
                 "Name of the model (default: the value of the variable LIVEGS_MODEL)");
  app.add_option("--recorded", options.endpoint.recorded,
                 "Replay recorded answers from this folder instead of querying a model")
      ->check(CLI::ExistingDirectory);
  app.add_option("--record-answers", options.endpoint.record,
                 "Record answers to this folder, for --recorded");
  app.add_option("--prompts", options.endpoint.prompts,
                 "Folder of prompts; its files replace built-in prompts of the same names")
      ->check(CLI::ExistingDirectory);
  app.add_option("--price", options.endpoint.price,
                 "Price in US dollars per million tokens sent and received, for cost reports "
                 "(default: the value of the variable LIVEGS_PRICE)");
  app.add_option("--model-deadline", options.endpoint.deadline_s,
                 "Time limit of one question including retries (default: the value of the variable "
                 "LIVEGS_MODEL_DEADLINE_S, else 60, or 300 for Ollama and llama.cpp)")
      ->check(CLI::Range(1.0, 3600.0))
      ->type_name("SECONDS");
  app.add_flag("--web-search", options.endpoint.web_search,
               "Allow one web search per object, if the endpoint supports it");
  app.add_option("--views", options.views, "Views per object; the answers to 3 views are combined by vote")
      ->check(CLI::IsMember({1, 3}));
  app.add_flag("--offline", options.endpoint.offline, "Disable the language model");
  app.add_flag("--verbose", options.verbose, "Log simulation statistics every second");
  app.set_version_flag("--version", LIVEGS_VERSION);
  using livegs::group_options;
  group_options(app, "Simulation",
                {{"--rate", "HZ"},
                 {"--substeps", ""},
                 {"--drop", ""},
                 {"--threads", ""},
                 {"--physics", ""},
                 {"--seconds", "SECONDS"},
                 {"--wait-for-client", ""}});
  group_options(app, "Clients",
                {{"--listen", "HOST:PORT"},
                 {"--tls", ""},
                 {"--state-dir", "FOLDER"},
                 {"--certificate", "FILE"},
                 {"--key", "FILE"},
                 {"--allow-origin", "ORIGIN"},
                 {"--clients", ""},
                 {"--client-mbit-s", "NUMBER"},
                 {"--asset-store", "PLACE"},
                 {"--client-store", "URL"},
                 {"--publish", "tcp://127.0.0.1:PORT"}});
  group_options(
      app, "Fleet",
      {{"--fleet", ""}, {"--fleet-empty-s", "SECONDS"}, {"--fleet-key", "FILE"}, {"--server-name", "NAME"}});
  group_options(app, "Recording",
                {{"--record", "FILE"}, {"--record-inputs-only", ""}, {"--record-assets", ""}});
  group_options(
      app, "Monitoring",
      {{"--metrics", "[HOST:]PORT"}, {"--log-format", ""}, {"--print-port", ""}, {"--verbose", ""}});
  group_options(app, "Analysis by a model",
                {{"--offline", ""},
                 {"--endpoint", "URL"},
                 {"--model", "NAME"},
                 {"--views", ""},
                 {"--web-search", ""},
                 {"--model-deadline", "SECONDS"},
                 {"--price", "IN,OUT"},
                 {"--prompts", "FOLDER"},
                 {"--recorded", "FOLDER"},
                 {"--record-answers", "FOLDER"}});
  app.formatter(std::make_shared<livegs::HelpFormatter>());
  app.footer(
      "Examples:\n"
      "  livegs-server scene/sample.scene.json                       # for clients on this machine\n"
      "  livegs-server FOLDER --listen 0.0.0.0:9780 --record out/session.lvgrec    # also for others\n"
      "  livegs-server https://store.example.org/rooms/hall.scene.json    # published by livegs publish");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return run(options);
}
