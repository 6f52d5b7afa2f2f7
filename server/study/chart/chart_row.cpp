// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/chart/chart_row.h"

#include <cstdarg>
#include <cstdio>

namespace livegs::study {
namespace {

constexpr const char* kHeader =
    "scene,solver,skinning,backend,precision,rate,substeps,nodes,particles,bodies,ns_per_node_substep,wall_s,"
    "error,"
    "error_unit,bar,quantity,measured,reference,variant,youngs_modulus_pa,poisson_ratio,spacing_m,cell_width_"
    "m,"
    "scene_substeps,courant,band,ratio_low,ratio_high,reached_youngs_modulus_pa,simulated_s,cpu_s,"
    "cpu_ns_per_simulated_s,finite,parameter,end\n";

__attribute__((format(printf, 2, 3))) void append(std::string& text, const char* format, ...) {
  char buffer[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  text += buffer;
}

const char* precision(Engine engine) {
  return engine == Engine::LivegsV1 || engine == Engine::LivegsV1Steady ? "double" : "float";
}

}  // namespace

std::string chart_csv(const std::vector<ChartRow>& rows) {
  std::string text = kHeader;
  for (const ChartRow& row : rows) {
    const ElasticAccuracy& a = row.outcome.accuracy;
    const Cost& cost = row.outcome.cost;
    // Unit of work of a substep: nodes, or particles for solvers without nodes.
    const double work =
        static_cast<double>(a.nodes > 0 ? a.nodes : a.particles) * static_cast<double>(cost.substeps);
    for (const Measurement& m : row.outcome.measurements) {
      append(text, "%s,%s,none,cpu,%s,%g,%d,%zu,%zu,1,%.2f,%.4f,%.6g,%s,%g,", row.scene.c_str(),
             solver_name(row.setup).c_str(), precision(row.setup.engine), row.setup.rate_hz, a.substeps,
             a.nodes, a.particles, work > 0.0 ? 1e9 * cost.cpu_s / work : 0.0, cost.wall_s, m.error,
             m.unit.c_str(), m.bar);
      append(text, "%s,%.9g,%.9g,%s,%g,%g,%g,%g,%d,%.4g,%s,%.4g,%.4g,%.4g,%.6g,%.6g,%.6g,%d,,\n",
             m.quantity.c_str(), m.measured, m.reference, row.variant.c_str(), row.setup.youngs_modulus_pa,
             row.setup.poisson_ratio, row.setup.spacing_m, a.cell_width_m, row.setup.substeps, a.courant,
             name_of(a.band), a.modulus_ratio_low, a.modulus_ratio_high, a.reached_youngs_modulus_pa,
             cost.simulated_s, cost.cpu_s, cost.cpu_ns_per_simulated_s(), row.outcome.finite ? 1 : 0);
    }
  }
  return text;
}

}  // namespace livegs::study
