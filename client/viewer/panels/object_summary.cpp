// SPDX-License-Identifier: Apache-2.0
#include "viewer/panels/object_summary.h"

#include "core/text/format_text.h"

namespace livegs {
namespace {

const char* band_name(v1::ElasticAccuracy::Band band) {
  switch (band) {
    case v1::ElasticAccuracy::EXACT:
      return "exact";
    case v1::ElasticAccuracy::BAND:
      return "band";
    case v1::ElasticAccuracy::CLIPPED:
      return "clipped";
    default:
      return "unknown";
  }
}

}  // namespace

std::string object_summary(const StreamedObject& object) {
  std::string line = object.name;
  if (!object.elastic) {
    line += object.mass_kg > 0 ? format_text(": rigid, %.3g kg", object.mass_kg) : ": static";
    if (!object.fragility) return line;
    const v1::Fragility& fragility = *object.fragility;
    if (object.rest.revision > 0) return line + format_text(", broken into %u", fragility.bodies());
    return line + format_text(", fragile: breaks at %.3g N s, a drop of %.2f m",
                              fragility.break_impulse_n_s(), fragility.drop_height_m());
  }
  const v1::ElasticAccuracy& elastic = *object.elastic;
  line += format_text(": elastic, %.3g kg, E %.3g Pa %s", object.mass_kg, elastic.youngs_modulus_pa(),
                      band_name(elastic.band()));
  if (elastic.band() == v1::ElasticAccuracy::CLIPPED) {
    line += format_text(" to %.3g Pa", elastic.reached_youngs_modulus_pa());
  }
  if (elastic.modulus_ratio_high() > 0) {
    line += format_text(" (simulated at %.3g to %.3g times E", elastic.modulus_ratio_low(),
                        elastic.modulus_ratio_high());
    if (elastic.modulus_ratio_across() > 1.02 * elastic.modulus_ratio_high()) {
      line += format_text("; across its shortest side up to %.3g", elastic.modulus_ratio_across());
    }
    line += ')';
  }
  return line + format_text("; cells %.3g mm, %u substeps, Courant %.2f, %llu nodes, %.0f kB",
                            1e3 * elastic.cell_width_m(), elastic.substeps(), elastic.courant(),
                            static_cast<unsigned long long>(elastic.nodes()),
                            1e-3 * static_cast<double>(elastic.bytes()));
}

}  // namespace livegs
