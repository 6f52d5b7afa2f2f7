// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/too_stiff_for_lattice.h"

#include <numeric>

#include "physics/elastic/resolution/lattice_resolution.h"

namespace livegs {

std::optional<std::string> too_stiff_for_lattice(const ElasticBodyDescription& body, double rate_hz,
                                                 int substeps) {
  const std::vector<double>& volumes_m3 = body.particles.volumes_m3;
  const double volume_m3 = std::accumulate(volumes_m3.begin(), volumes_m3.end(), 0.0);
  if (body.particles.positions_m.empty() || !(volume_m3 > 0.0)) return std::nullopt;
  const ResolutionRequest request = resolution_request(body, rate_hz, substeps);
  const double reached_pa = choose_resolution(request).youngs_modulus_pa;
  if (!(request.youngs_modulus_pa > kMaxStiffnessRatio * reached_pa)) return std::nullopt;
  char reason[160];
  std::snprintf(
      reason, sizeof reason,
      "E* = %.3g Pa is %.0f times the maximum of its cells at %g Hz (%.3g Pa): built as a rigid body",
      request.youngs_modulus_pa, request.youngs_modulus_pa / reached_pa, rate_hz, reached_pa);
  return reason;
}

}  // namespace livegs
