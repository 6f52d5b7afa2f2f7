// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/metrics/run_summary.h"

#include "analysis/estimate/physics_values.h"
#include "core/text/format_text.h"
#include "scene/build/elastic_report.h"

namespace livegs {
namespace {

void append_value(std::string& text, const char* name, const char* unit, const v1::EstimatedValue& value) {
  text += format_text("    %-10s %.3g %s [%.3g .. %.3g]  %s%s%s\n", name, value.best(), unit, value.low(),
                      value.high(), source_name(value.source()), value.reason().empty() ? "" : ": ",
                      value.reason().substr(0, 300).c_str());
}

void append_object(std::string& text, const SceneObject& object) {
  const v1::PhysicalParameters& physics = object.physics;
  text += format_text("  %s: %zu kernels, ", object.name.c_str(), object.asset->size());
  if (object.environment) {
    text += "environment\n";
    return;
  }
  text += object.elastic ? "elastic" : object.mass_kg > 0 ? "rigid" : "static";
  text += format_text("; %s%s%s\n", physics.label().empty() ? "unlabelled" : physics.label().c_str(),
                      physics.material().empty() ? "" : " of ", physics.material().c_str());
  if (object.elastic) text += format_text("    %s\n", accuracy_line(*object.elastic).c_str());
  for (const std::string& warning : object.all_warnings())
    text += format_text("    warning: %s\n", warning.c_str());
  if (object.mass_kg <= 0) return;
  append_value(text, "mass", "kg", physics.mass_kg());
  append_value(text, "stiffness", "Pa", physics.youngs_modulus_pa());
}

}  // namespace

std::string run_summary(const Scene& scene, const SimulationSummary& simulated,
                        const PublisherSummary& published, const SessionTable::Totals& sessions) {
  std::string text = "scene " + scene.name() + "\n";
  for (const SceneObject& object : scene.objects()) {
    if (object.environment || object.facts) append_object(text, object);
  }
  const double rate = simulated.run_s > 0 ? static_cast<double>(simulated.ticks) / simulated.run_s : 0.0;
  text += format_text("simulation: %llu ticks in %.1f s, %.1f per second (target %.1f)\n",
                      static_cast<unsigned long long>(simulated.ticks), simulated.run_s, rate,
                      scene.world().settings().rate_hz);
  text += format_text(
      "  tick p50 %.2f ms, p99 %.2f ms, longest %.2f ms; %llu late ticks, %llu slips; %llu balls shot\n",
      simulated.step_ms_p50, simulated.step_ms_p99, simulated.step_ms_max,
      static_cast<unsigned long long>(simulated.late_ticks), static_cast<unsigned long long>(simulated.slips),
      static_cast<unsigned long long>(simulated.shots));
  text += format_text(
      "stream: %.0f bytes a frame p50, %.0f p99; encoding p50 %.2f ms, p99 %.2f ms; %llu frames skipped\n",
      published.frame_bytes_p50, published.frame_bytes_p99, published.encode_ms_p50, published.encode_ms_p99,
      static_cast<unsigned long long>(published.skipped));
  text += format_text("  %llu sessions, %llu frames sent, %llu dropped because newer ones waited\n",
                      static_cast<unsigned long long>(sessions.sessions),
                      static_cast<unsigned long long>(sessions.frames_sent),
                      static_cast<unsigned long long>(sessions.frames_replaced));
  return text;
}

}  // namespace livegs
