// SPDX-License-Identifier: GPL-3.0-or-later
#include "device/measure_elastic_cost.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <vector>

#include "core/clock.h"
#include "core/file.h"
#include "core/log.h"
#include "core/percentile.h"
#include "device/device_elastic.h"
#include "physics/elastic_body.h"

namespace livegs {
namespace {

constexpr int kRuns = 5;  // ticks of each size; the median counts
constexpr double kRate_hz = 90.0;
constexpr int kSubsteps = 4;
constexpr const char* kFormat = "elastic cost 1";

// A cube of `across` cells of 1 cm.
Result<std::unique_ptr<ElasticBody>> make_block(int across, int substeps) {
  constexpr double kWidth_m = 0.01;
  ElasticBodyDescription block;
  ParticleSet& set = block.particles;
  set.spacing_m = kWidth_m;
  for (int k = 0; k < across; ++k) {
    for (int j = 0; j < across; ++j) {
      for (int i = 0; i < across; ++i) set.positions_m.push_back(kWidth_m * Eigen::Vector3d(i, j, k));
    }
  }
  set.volumes_m3.assign(set.positions_m.size(), kWidth_m * kWidth_m * kWidth_m);
  set.on_surface.assign(set.positions_m.size(), false);
  block.material.behavior = Behavior::Elastic;
  block.material.mass_kg = 1000.0 * static_cast<double>(set.positions_m.size()) * set.volumes_m3[0];
  block.material.youngs_modulus_pa = 1e4;
  block.material.poisson_ratio = 0.3;
  block.cell_width_m = kWidth_m;
  block.substeps = substeps;
  block.angular_velocity_rad_s = {1.0, 2.0, 3.0};
  return make_elastic_body(block, kRate_hz, kSubsteps, false);
}

struct Measured {
  ElasticWork work;
  double device_ms = 0, cpu_ms = 0;
};

Result<Measured> measure(Backend& backend, int across, int substeps) {
  auto made = make_block(across, substeps);
  if (!made) return made.error();
  ElasticBody& body = **made;
  auto* flat = dynamic_cast<FlatBody*>(&body);
  DeviceElastic device(backend);
  FlatTick tick;
  tick.duration_s = 1.0 / kRate_hz;
  tick.substeps = kSubsteps;
  std::vector<double> on_device, on_cpu;
  for (int run = 0; run <= kRuns; ++run) {
    int64_t begin_ns = now_ns();
    for (int substep = 0; substep < kSubsteps; ++substep) {
      SubstepContext context;
      context.duration_s = tick.duration_s / kSubsteps;
      context.start_s = tick.start_s + substep * context.duration_s;
      context.gravity_m_s2.setZero();
      body.substep(context);
    }
    on_cpu.push_back(milliseconds_from_ns(now_ns() - begin_ns));
    body.end_frame(tick.duration_s);
    tick.start_s += tick.duration_s;
    begin_ns = now_ns();
    DeviceBody one{flat, {}};
    device.step({&one, 1}, tick);
    on_device.push_back(milliseconds_from_ns(now_ns() - begin_ns));
    if (!device.failure().empty()) return Error{ErrorCode::Unavailable, device.failure()};
    body.end_frame(tick.duration_s);
    tick.start_s += tick.duration_s;
  }
  on_device.erase(on_device.begin());  // compiles the passes and uploads the lattice
  on_cpu.erase(on_cpu.begin());
  Measured result;
  result.work = {1, flat->flat_steps(), static_cast<double>(flat->flat_node_count()) * flat->flat_steps()};
  result.device_ms = percentile(on_device, 0.5);
  result.cpu_ms = percentile(on_cpu, 0.5);
  return result;
}

Result<ElasticCost> read_cost(const std::filesystem::path& file, const std::string& device) {
  auto text = read_text_file(file, 4096);
  if (!text) return text.error();
  std::istringstream in(*text);
  std::string format, name;
  ElasticCost cost;
  if (!std::getline(in, format) || !std::getline(in, name) || format != kFormat || name != device ||
      !(in >> cost.device_tick_ms >> cost.device_step_ms >> cost.device_node_step_ms >>
        cost.cpu_node_step_ms))
    return Error{ErrorCode::NotFound, file.string() + ": no cost of this device"};
  for (const double one :
       {cost.device_tick_ms, cost.device_step_ms, cost.device_node_step_ms, cost.cpu_node_step_ms}) {
    if (!std::isfinite(one) || one < 0.0)
      return Error{ErrorCode::InvalidData, file.string() + ": a cost is not a number >= 0"};
  }
  return cost;
}

}  // namespace

Result<ElasticCost> measure_elastic_cost(Backend& backend) {
  // Few nodes and few steps, few nodes and many steps, many nodes: three equations for three times.
  std::array<Measured, 3> at;
  const std::array<std::array<int, 2>, 3> sizes{{{4, 4}, {4, 32}, {24, 4}}};
  for (size_t i = 0; i < at.size(); ++i) {
    auto measured = measure(backend, sizes[i][0], sizes[i][1]);
    if (!measured) return measured.error();
    at[i] = *measured;
  }
  ElasticCost cost;
  const double more_nodes = at[2].work.node_steps - at[0].work.node_steps;
  cost.device_node_step_ms = std::max(0.0, (at[2].device_ms - at[0].device_ms) / more_nodes);
  const auto without_nodes = [&](const Measured& one) {
    return one.device_ms - one.work.node_steps * cost.device_node_step_ms;
  };
  cost.device_step_ms =
      std::max(0.0, (without_nodes(at[1]) - without_nodes(at[0])) / (at[1].work.steps - at[0].work.steps));
  cost.device_tick_ms = std::max(0.0, without_nodes(at[0]) - at[0].work.steps * cost.device_step_ms);
  cost.cpu_node_step_ms = at[2].cpu_ms / at[2].work.node_steps;
  return cost;
}

Result<ElasticCost> known_elastic_cost(Backend& backend, const std::string& device,
                                       const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "elastic-cost.txt";
  if (!folder.empty()) {
    if (auto known = read_cost(file, device)) return known;
  }
  auto cost = measure_elastic_cost(backend);
  if (!cost || folder.empty()) return cost;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  std::ostringstream out;
  out.precision(9);
  out << kFormat << '\n'
      << device << '\n'
      << cost->device_tick_ms << ' ' << cost->device_step_ms << ' ' << cost->device_node_step_ms << ' '
      << cost->cpu_node_step_ms << '\n';
  if (auto written = write_file_atomically(file, out.str()); !written)
    log_warn("the cost of the device is measured at each start: %s", written.error().message.c_str());
  return cost;
}

}  // namespace livegs
