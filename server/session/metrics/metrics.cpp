// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/metrics/metrics.h"

#include <prometheus/collectable.h>
#include <prometheus/exposer.h>
#include <prometheus/metric_family.h>
#include <unistd.h>

#include <cstdlib>
#include <exception>
#include <fstream>
#include <sstream>
#include <utility>

#include "session/support/version.h"

namespace livegs {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;
using Labels = std::vector<ClientMetric::Label>;

MetricFamily family(const char* name, const char* help, MetricType type) {
  MetricFamily made;
  made.name = name;
  made.help = help;
  made.type = type;
  return made;
}

void add(MetricFamily& to, double value, Labels labels = {}) {
  ClientMetric metric;
  metric.label = std::move(labels);
  (to.type == MetricType::Counter ? metric.counter.value : metric.gauge.value) = value;
  to.metric.push_back(std::move(metric));
}

struct Quantiles {
  uint64_t count = 0;
  double sum = 0;  // 0 if not recorded
  std::vector<ClientMetric::Quantile> at;
};

void add(MetricFamily& to, const Quantiles& quantiles, Labels labels = {}) {
  ClientMetric metric;
  metric.label = std::move(labels);
  metric.summary.sample_count = quantiles.count;
  metric.summary.sample_sum = quantiles.sum;
  metric.summary.quantile = quantiles.at;
  to.metric.push_back(std::move(metric));
}

Quantiles of(const DurationHistogram& histogram, double unit) {
  return {histogram.count(),
          histogram.sum() * unit,
          {{0.5, histogram.percentile(0.5) * unit}, {0.99, histogram.percentile(0.99) * unit}}};
}

constexpr double kMs = 1e-3;

void collect_simulation(const SimulationSummary& simulation, std::vector<MetricFamily>& families) {
  auto& ticks = families.emplace_back(family("livegs_ticks_total", "Ticks simulated", MetricType::Counter));
  add(ticks, static_cast<double>(simulation.ticks));
  auto& late = families.emplace_back(family(
      "livegs_late_ticks_total", "Ticks that finished after the next one was due", MetricType::Counter));
  add(late, static_cast<double>(simulation.late_ticks));
  auto& slips = families.emplace_back(family("livegs_schedule_slips_total",
                                             "Times the tick schedule was reset because ticks were late",
                                             MetricType::Counter));
  add(slips, static_cast<double>(simulation.slips));
  auto& seconds =
      families.emplace_back(family("livegs_tick_seconds", "Wall time of a tick's step", MetricType::Summary));
  add(seconds, {simulation.ticks,
                simulation.step_ms_total * kMs,
                {{0.5, simulation.step_ms_p50 * kMs},
                 {0.99, simulation.step_ms_p99 * kMs},
                 {1.0, simulation.step_ms_max * kMs}}});
}

void collect_publisher(const PublisherSummary& publisher, std::vector<MetricFamily>& families) {
  auto& frames =
      families.emplace_back(family("livegs_frames_total", "Ticks offered to clients", MetricType::Counter));
  add(frames, static_cast<double>(publisher.frames));
  auto& skipped = families.emplace_back(family("livegs_frames_skipped_total",
                                               "Ticks replaced by newer ones before they were offered",
                                               MetricType::Counter));
  add(skipped, static_cast<double>(publisher.skipped));
  auto& encode = families.emplace_back(
      family("livegs_encode_seconds", "Encoding a frame against one baseline", MetricType::Summary));
  add(encode, {publisher.encoded,
               publisher.encode_ms_total * kMs,
               {{0.5, publisher.encode_ms_p50 * kMs}, {0.99, publisher.encode_ms_p99 * kMs}}});
  auto& bytes =
      families.emplace_back(family("livegs_frame_bytes", "Size of an encoded frame", MetricType::Summary));
  add(bytes, {publisher.encoded,
              publisher.frame_bytes_total,
              {{0.5, publisher.frame_bytes_p50}, {0.99, publisher.frame_bytes_p99}}});
}

void collect_sessions(const SessionTable& table, std::vector<MetricFamily>& families) {
  const SessionTable::Status status = table.status();
  auto& serving = families.emplace_back(family("livegs_serving", "1 if clients may join", MetricType::Gauge));
  add(serving, status.open ? 1 : 0);
  auto& sessions = families.emplace_back(family("livegs_sessions", "Sessions by state", MetricType::Gauge));
  add(sessions, static_cast<double>(status.streaming), {{"state", "streaming"}});
  add(sessions, static_cast<double>(status.clients - status.streaming), {{"state", "waiting"}});
  auto& total =
      families.emplace_back(family("livegs_sessions_total", "Sessions since the start", MetricType::Counter));
  add(total, static_cast<double>(table.totals().sessions));

  auto sent = family("livegs_client_frames_sent_total", "Frames written to a client", MetricType::Counter);
  auto replaced = family("livegs_client_frames_replaced_total",
                         "Frames replaced by newer ones before they were written", MetricType::Counter);
  auto bytes =
      family("livegs_client_bytes_total", "Bytes of messages written to a client", MetricType::Counter);
  auto send =
      family("livegs_client_send_seconds", "Time until the transport accepts a message", MetricType::Summary);
  auto answer =
      family("livegs_client_round_trip_seconds",
             "Time from writing a frame to its acknowledgement: network round trip plus client decoding",
             MetricType::Summary);
  auto stale = family(
      "livegs_client_staleness_seconds",
      "Time from the end of a step to the acknowledgement of its frame: staleness plus half a round trip",
      MetricType::Summary);
  auto window = family("livegs_client_window_frames", "Maximum number of frames in flight to a client",
                       MetricType::Gauge);
  for (const auto& session : table.sessions_now()) {
    const Labels client = {{"client", session->id.substr(0, 8)}};
    const ClientTimes times = session->times();
    add(sent, static_cast<double>(session->frames_sent()), client);
    add(replaced, static_cast<double>(session->frames_replaced()), client);
    add(bytes, static_cast<double>(session->bytes_sent), client);
    add(window, static_cast<double>(session->window()), client);
    add(send, of(times.send_ms, kMs), client);
    add(answer, of(times.round_trip_ms, kMs), client);
    add(stale, of(times.staleness_ms, kMs), client);
  }
  for (MetricFamily* one : {&sent, &replaced, &bytes, &window, &send, &answer, &stale})
    families.push_back(std::move(*one));
}

// Memory and start of this process, by the names that the client libraries of Prometheus use.
void collect_process(std::vector<MetricFamily>& families) {
  // Resident pages are the second number of statm; the start is field 22 of stat, in clock ticks since boot,
  // counted after the name, which may contain spaces.
  std::ifstream statm("/proc/self/statm");
  double pages = 0, resident_pages = 0;
  if (statm >> pages >> resident_pages) {
    const auto page_bytes = static_cast<double>(::sysconf(_SC_PAGESIZE));
    auto& resident = families.emplace_back(
        family("process_resident_memory_bytes", "Memory of the process in RAM", MetricType::Gauge));
    add(resident, resident_pages * page_bytes);
    auto& virtual_size = families.emplace_back(
        family("process_virtual_memory_bytes", "Address space of the process", MetricType::Gauge));
    add(virtual_size, pages * page_bytes);
  }
  std::ifstream stat("/proc/self/stat"), system("/proc/stat");
  std::string line, word;
  double ticks = 0, boot_s = 0;
  if (std::getline(stat, line) && line.rfind(')') != std::string::npos) {
    std::istringstream fields(line.substr(line.rfind(')') + 1));  // from field 3 on
    for (int field = 3; field < 22; ++field) fields >> word;
    fields >> ticks;
  }
  while (std::getline(system, line)) {
    if (line.starts_with("btime ")) boot_s = std::strtod(line.c_str() + 6, nullptr);
  }
  if (ticks <= 0 || boot_s <= 0) return;
  auto& start = families.emplace_back(
      family("process_start_time_seconds", "Start of the process, Unix time", MetricType::Gauge));
  add(start, boot_s + ticks / static_cast<double>(::sysconf(_SC_CLK_TCK)));
}

class Collector final : public prometheus::Collectable {
 public:
  explicit Collector(Metrics::Sources sources) : sources_(std::move(sources)) {}
  std::vector<MetricFamily> Collect() const override {
    std::vector<MetricFamily> families;
    auto& about = families.emplace_back(family("livegs_info", "Version of the server", MetricType::Gauge));
    add(about, 1, {{"version", kVersion}});
    collect_process(families);
    collect_simulation(sources_.simulation(), families);
    collect_publisher(sources_.publisher(), families);
    collect_sessions(sources_.sessions, families);
    auto& assets = families.emplace_back(
        family("livegs_asset_bytes_total", "Bytes of assets sent to clients by this server, not by a store",
               MetricType::Counter));
    add(assets, static_cast<double>(sources_.asset_bytes()));
    return families;
  }

 private:
  const Metrics::Sources sources_;
};

}  // namespace

Result<HostPort> parse_metrics_address(const std::string& text) {
  const bool only_port = text.find(':') == std::string::npos;
  auto where = parse_host_port(only_port ? "127.0.0.1:" + text : text);
  if (!where)
    return invalid_argument("metrics address \"" + text +
                            "\": is not valid; give PORT or HOST:PORT with a port from 0 to 65535");
  return where;
}

struct Metrics::Parts {
  std::shared_ptr<Collector> collector;
  std::string host;
  std::unique_ptr<prometheus::Exposer> exposer;
};

Metrics::Metrics(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Metrics::~Metrics() = default;

Result<std::unique_ptr<Metrics>> Metrics::serve(const HostPort& where, Sources sources) {
  const std::string address = where.host + ":" + std::to_string(where.port);
  auto parts = std::make_unique<Parts>();
  parts->host = where.host;
  parts->collector = std::make_shared<Collector>(std::move(sources));
  try {
    parts->exposer = std::make_unique<prometheus::Exposer>(address, 1);
  } catch (const std::exception&) {  // civetweb gives no reason
    return Error{ErrorCode::Unavailable, "metrics: cannot listen on " + address +
                                             ": the port is in use; give another with --metrics PORT"};
  }
  parts->exposer->RegisterCollectable(parts->collector);
  return std::unique_ptr<Metrics>(new Metrics(std::move(parts)));
}

std::string Metrics::url() const {
  const auto ports = parts_->exposer->GetListeningPorts();
  return "http://" + parts_->host + ":" + std::to_string(ports.empty() ? 0 : ports.front()) + "/metrics";
}

}  // namespace livegs
