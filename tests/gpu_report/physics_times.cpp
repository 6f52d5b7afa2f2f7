// SPDX-License-Identifier: GPL-3.0-or-later
#include "gpu_report/physics_times.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "compute/vulkan_backend.h"
#include "compute/vulkan_commands.h"
#include "core/clock.h"
#include "core/percentile.h"
#include "core/text/format_text.h"
#include "device/device_elastic.h"
#include "device/passes/elastic_layout.h"
#include "server/device/flat_block.h"

namespace livegs::gpu_report {
namespace {

constexpr int kSteps = 16, kTicks = 9, kWarmUp = 2;
constexpr double kMaxTime_s = 20.0;  // of a row
constexpr int kManyAcross = 9;       // cells: bodies of a thousand nodes

// Bytes of a node in a step, with full cells, about as many as nodes: the rows that each pass reads and
// writes, as if caches were perfect within a pass. The sweep reads and writes the nodes once for each of
// eight colours.
double bytes_a_node_step() {
  using namespace shader;
  const double predict =
      2 * sizeof(NodeStateRow) + sizeof(vec4) + sizeof(vec4) + sizeof(NodeSolveRow) + sizeof(NodeDriftRow);
  const double cells = sizeof(CellRow) + 2 * sizeof(vec4) + 8 * (sizeof(NodeSolveRow) + sizeof(vec4));
  const double advance = sizeof(NodeSolveRow) + sizeof(NodeDriftRow) + sizeof(vec4) +
                         2 * sizeof(NodeStateRow) + 2.0 * sizeof(NodeSumsRow) / kElasticBlock;
  return predict + cells + advance;
}

Result<PhysicsRow> measure_row(const std::shared_ptr<VulkanDevice>& device, size_t bodies, int across) {
  auto backend = create_vulkan_backend(device);
  if (!backend) return backend.error();
  std::vector<std::unique_ptr<test::FlatBlock>> blocks;
  for (size_t i = 0; i < bodies; ++i) {
    blocks.push_back(std::make_unique<test::FlatBlock>(
        test::FlatBlock::Options{.cells = {across, across, across}, .steps = kSteps, .touches = false}));
  }
  DeviceElastic elastic(**backend);
  const VulkanCommands::Traffic& traffic = vulkan_commands(**backend)->traffic();
  VulkanCommands::Traffic before;
  PhysicsRow row;
  row.bodies = bodies;
  row.nodes = bodies * blocks.front()->flat_node_count();
  row.steps = kSteps;
  row.bytes_a_node_step = bytes_a_node_step();
  std::vector<double> ms;
  const int64_t start_ns = now_ns();
  for (int tick = 0; tick < kWarmUp + kTicks; ++tick) {
    if (tick > kWarmUp && static_cast<double>(now_ns() - start_ns) > kMaxTime_s * 1e9) break;
    if (tick == kWarmUp) before = traffic;
    std::vector<DeviceBody> all;
    for (const auto& block : blocks) all.push_back({block.get(), {}});
    FlatTick flat;
    flat.duration_s = 1.0 / 90.0;
    flat.start_s = tick * flat.duration_s;
    flat.substeps = 4;
    flat.gravity_m_s2 = {0.0, -9.81, 0.0};
    const int64_t begin_ns = now_ns();
    elastic.step(all, flat);
    if (!elastic.failure().empty()) return Error{ErrorCode::TooLarge, elastic.failure()};
    if (tick >= kWarmUp) ms.push_back(milliseconds_from_ns(now_ns() - begin_ns));
  }
  for (const auto& block : blocks) {
    if (!block->finite()) return Error{ErrorCode::Internal, "physics: a body is not finite"};
  }
  row.ticks = static_cast<int>(ms.size());
  row.tick_ms = percentile(ms, 0.5);
  row.tick_max_ms = percentile(ms, 1.0);
  const auto a_tick = [&](uint64_t now, uint64_t then) {
    return static_cast<double>(now - then) / row.ticks;
  };
  row.dispatches = a_tick(traffic.dispatches, before.dispatches);
  row.submissions = a_tick(traffic.submissions, before.submissions);
  row.barriers = a_tick(traffic.barriers, before.barriers);
  row.uploaded_bytes = a_tick(traffic.uploaded_bytes, before.uploaded_bytes);
  return row;
}

double ns_a_node_step(const PhysicsRow& row) {
  return 1e6 * row.tick_ms / (static_cast<double>(row.nodes) * row.steps);
}

}  // namespace

Result<void> measure_physics(const std::shared_ptr<VulkanDevice>& device, const std::vector<size_t>& nodes,
                             const std::function<void(const PhysicsRow&)>& measured) {
  const auto measure = [&](size_t bodies, int across) -> Result<void> {
    auto row = measure_row(device, bodies, across);
    if (!row && row.error().code != ErrorCode::TooLarge) return row.error();
    if (!row) {
      std::fprintf(stderr, "gpu-report: physics: %s\n", row.error().message.c_str());
      return {};
    }
    std::fprintf(stderr, "gpu-report: physics: %zu bodies, %zu nodes: %.2f ms\n", row->bodies, row->nodes,
                 row->tick_ms);
    measured(*row);
    return {};
  };
  const size_t many_nodes = static_cast<size_t>(std::pow(kManyAcross + 1, 3));
  for (const size_t count : nodes) {
    const int across = std::max(1, static_cast<int>(std::lround(std::cbrt(static_cast<double>(count)))) - 1);
    if (auto done = measure(1, across); !done) return done;
    if (count / many_nodes < 2) continue;
    if (auto done = measure(count / many_nodes, kManyAcross); !done) return done;
  }
  return {};
}

std::string physics_csv(const std::string& device, const std::vector<PhysicsRow>& rows) {
  std::string text =
      "# " + device +
      "\nbodies,nodes,steps,ticks,tick_ms,tick_max_ms,ns_a_node_step,dispatches,submissions,barriers,"
      "uploaded_bytes,bytes_a_node_step\n";
  for (const PhysicsRow& row : rows)
    text +=
        format_text("%zu,%zu,%d,%d,%.3f,%.3f,%.3f,%.1f,%.1f,%.1f,%.0f,%.1f\n", row.bodies, row.nodes,
                    row.steps, row.ticks, row.tick_ms, row.tick_max_ms, ns_a_node_step(row), row.dispatches,
                    row.submissions, row.barriers, row.uploaded_bytes, row.bytes_a_node_step);
  return text;
}

std::string physics_text(const std::vector<PhysicsRow>& rows, bool software) {
  std::string text =
      "A tick of elastic bodies, with the upload and the read-back of their state; nothing touches. Bytes "
      "are "
      "those that the passes have to read and write. All rows are in `physics.csv`.\n\n";
  text += software
              ? "| bodies | nodes | steps | dispatches | submissions | bytes a node and step |\n"
                "|---|---|---|---|---|---|\n"
              : "| bodies | nodes | steps | dispatches | submissions | bytes a node and step | tick, ms | a "
                "node and step, ns |\n|---|---|---|---|---|---|---|---|\n";
  for (const PhysicsRow& row : rows) {
    text += format_text("| %zu | %zu | %d | %.0f | %.0f | %.0f |", row.bodies, row.nodes, row.steps,
                        row.dispatches, row.submissions, row.bytes_a_node_step);
    if (!software) text += format_text(" %.2f | %.2f |", row.tick_ms, ns_a_node_step(row));
    text += "\n";
  }
  return text;
}

}  // namespace livegs::gpu_report
