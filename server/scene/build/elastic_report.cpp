// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/elastic_report.h"

#include "core/text/format_text.h"
#include "physics/elastic/resolution/lattice_resolution.h"

namespace livegs {
namespace {

// Compressive strain under its own weight above which a body is reported as too soft. A cube still stands at
// a strain of 0.5.
constexpr double kMaxSag = 0.7;
// Minimum ratio of stiffness across to along that is reported.
constexpr double kMinReportedAnisotropy = 1.02;

v1::ElasticAccuracy::Band band_message(ElasticBand band) {
  switch (band) {
    case ElasticBand::Exact:
      return v1::ElasticAccuracy::EXACT;
    case ElasticBand::Band:
      return v1::ElasticAccuracy::BAND;
    case ElasticBand::Clipped:
      return v1::ElasticAccuracy::CLIPPED;
    case ElasticBand::Unknown:
      break;
  }
  return v1::ElasticAccuracy::UNKNOWN;
}

std::string material_text(const MaterialAccuracy& material) {
  std::string text = format_text("E %.3g Pa %s", material.youngs_modulus_pa, name_of(material.band));
  if (material.clipped) text += format_text(" to %.3g Pa", material.reached_youngs_modulus_pa);
  if (material.modulus_ratio_high > 0) {
    text += format_text(" (simulated at %.3g to %.3g times E", material.modulus_ratio_low,
                        material.modulus_ratio_high);
    if (material.modulus_ratio_across > kMinReportedAnisotropy * material.modulus_ratio_high) {
      text += format_text("; across its shortest side up to %.3g", material.modulus_ratio_across);
    }
    text += ')';
  }
  return text;
}

}  // namespace

v1::ElasticAccuracy accuracy_message(const ElasticAccuracy& accuracy) {
  v1::ElasticAccuracy message;
  message.set_cell_width_m(accuracy.cell_width_m);
  message.set_substeps(static_cast<uint32_t>(accuracy.substeps));
  message.set_courant(accuracy.courant);
  message.set_band(band_message(accuracy.band));
  message.set_youngs_modulus_pa(accuracy.youngs_modulus_pa);
  message.set_reached_youngs_modulus_pa(accuracy.reached_youngs_modulus_pa);
  message.set_modulus_ratio_low(accuracy.modulus_ratio_low);
  message.set_modulus_ratio_high(accuracy.modulus_ratio_high);
  message.set_modulus_ratio_across(accuracy.modulus_ratio_across);
  message.set_nodes(accuracy.nodes);
  message.set_cells(accuracy.cells);
  message.set_particles(accuracy.particles);
  message.set_bytes(accuracy.bytes);
  message.set_node_substeps(accuracy.node_substeps);
  message.set_alone_cell_width_m(accuracy.unbudgeted_cell_width_m);
  message.set_alone_reached_youngs_modulus_pa(accuracy.unbudgeted_reached_pa);
  return message;
}

std::string accuracy_line(const ElasticAccuracy& accuracy) {
  std::string line = material_text(accuracy);
  for (const RegionAccuracy& region : accuracy.regions) {
    line += "; in " + region.name + ' ' + material_text(region);
  }
  if (accuracy.cell_width_m > 0) line += format_text("; cells %.3g mm", 1e3 * accuracy.cell_width_m);
  line += format_text("%s %d substeps", accuracy.cell_width_m > 0 ? "," : ";", accuracy.substeps);
  if (accuracy.cell_width_m > 0) line += format_text(", Courant %.2f", accuracy.courant);
  line += format_text("; %zu nodes, %zu particles, %.0f kB", accuracy.nodes, accuracy.particles,
                      1e-3 * static_cast<double>(accuracy.bytes));
  return line;
}

std::vector<std::string> accuracy_warnings(const ElasticAccuracy& accuracy) {
  std::vector<std::string> warnings;
  const auto warn = [&](const MaterialAccuracy& material, const std::string& where) {
    if (!material.clipped) return;
    warnings.push_back(
        where +
        format_text("stiffness is clipped from %.3g to %.3g Pa, the maximum for cells of %.3g mm and %d "
                    "substeps; raise rate_hz, or use a rigid body",
                    material.youngs_modulus_pa, material.reached_youngs_modulus_pa,
                    1e3 * accuracy.cell_width_m, accuracy.substeps));
  };
  warn(accuracy, "");
  if (accuracy.thin_part > kMaxThinPart) {
    warnings.push_back(format_text(
        "%.0f %% of the volume is sheets or cords thinner than half a cell of %.3g mm that are not aligned "
        "with the cells, so their bending stiffness is %.2g to %.2g of the correct value; lower spacing_m "
        "for smaller cells",
        100.0 * accuracy.thin_part, 1e3 * accuracy.cell_width_m, kThinBendsFrom, kThinBendsTo));
  }
  if (accuracy.over_budget) {
    warnings.push_back(format_text(
        "too thin and wide for the time budget: limited to %zu nodes in cells of %.3g mm, so bending, "
        "folding and contact are coarse; make it smaller or thicker, or split it into several objects",
        accuracy.nodes, 1e3 * accuracy.cell_width_m));
  }
  if (accuracy.unbudgeted_cell_width_m > 0) {
    warnings.push_back(format_text(
        "the elastic budget limits it to cells of %.3g mm and %d substeps, while alone it would have cells "
        "of %.3g mm and reach %.3g Pa; use fewer or smaller elastic objects, or raise elastic_budget_ms",
        1e3 * accuracy.cell_width_m, accuracy.substeps, 1e3 * accuracy.unbudgeted_cell_width_m,
        accuracy.unbudgeted_reached_pa));
  }
  if (accuracy.sag > kMaxSag) {
    warnings.push_back(format_text(
        "too soft to carry its own weight: strain %.2g, inner points may sink through the support; raise "
        "youngs_modulus_pa to %.2g for a strain of 0.1",
        accuracy.sag, 10.0 * accuracy.sag * accuracy.youngs_modulus_pa));
  }
  if (accuracy.recovery_count > 0) {
    warnings.push_back(format_text("simulation diverged: reset to the rest shape %d time%s",
                                   accuracy.recovery_count, accuracy.recovery_count == 1 ? "" : "s"));
  }
  for (const RegionAccuracy& region : accuracy.regions) warn(region, region.name + ": ");
  return warnings;
}

}  // namespace livegs
