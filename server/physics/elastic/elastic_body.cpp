// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic_body.h"

#include <cmath>
#include <cstdlib>

#include "core/text/format_text.h"
#include "physics/check/check_values.h"
#include "physics/surface_friction.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

// Larger coordinates, m, and velocities indicate wrong units. Below this limit every lattice index fits its
// type. Also the maximum ratio of body extent to particle edge, which bounds the lattice by the input's size.
constexpr double kMaxValue = 1e6;

Error not_physical(const ElasticBodyDescription& description, const std::string& what) {
  return object_error(description.object_id, what);
}

bool finite(const Vector3d& v) { return v.allFinite() && v.cwiseAbs().maxCoeff() <= kMaxValue; }

Result<void> check_particles(const ElasticBodyDescription& d) {
  const ParticleSet& set = d.particles;
  const size_t count = set.positions_m.size();
  if (count == 0) return not_physical(d, "no particles; an elastic body needs at least one");
  if (set.volumes_m3.size() != count) return not_physical(d, "volumes_m3 must have one entry per particle");
  if (!set.on_surface.empty() && set.on_surface.size() != count) {
    return not_physical(d, "on_surface must have one entry per particle");
  }
  if (!d.particle_velocities_m_s.empty() && d.particle_velocities_m_s.size() != count) {
    return not_physical(d, "particle_velocities_m_s must have one entry per particle");
  }
  Eigen::AlignedBox3d box;
  double volume = 0.0;
  for (size_t i = 0; i < count; ++i) {
    if (!finite(set.positions_m[i]))
      return not_physical(d, "a particle position is not finite or beyond 1e6 m; check the unit");
    if (!std::isfinite(set.volumes_m3[i]) || set.volumes_m3[i] <= 0.0) {
      return not_physical(d,
                          "a particle volume is " + number_text(set.volumes_m3[i]) + "; it must be above 0");
    }
    volume += set.volumes_m3[i];
    box.extend(set.positions_m[i]);
  }
  for (const Vector3d& velocity : d.particle_velocities_m_s) {
    if (!finite(velocity))
      return not_physical(d, "a particle velocity is not finite or beyond 1e6 m/s; check the unit");
  }
  if (!std::isfinite(set.spacing_m) || set.spacing_m < 0.0)
    return not_physical(d, "spacing_m must be 0 or above");
  const double edge =
      set.spacing_m > 0.0 ? std::min(set.spacing_m, std::cbrt(volume / count)) : std::cbrt(volume / count);
  if (box.sizes().maxCoeff() > kMaxValue * edge || std::cbrt(volume) > kMaxValue) {
    return not_physical(d, "the extent is over a million times the particle size; check spacing_m");
  }
  return {};
}

Result<void> check_motion(const ElasticBodyDescription& d) {
  LIVEGS_RETURN_IF_ERROR(check_finite(d.object_id, "velocity_m_s", d.velocity_m_s));
  LIVEGS_RETURN_IF_ERROR(check_finite(d.object_id, "angular_velocity_rad_s", d.angular_velocity_rad_s));
  if (!finite(d.world_from_object.position_m) || !finite(d.velocity_m_s) || !finite(d.angular_velocity_rad_s))
    return not_physical(d, "position or velocity is beyond 1e6; check the unit");
  if (!d.initial_deformation.allFinite())
    return not_physical(d, "initial_deformation is not finite; check the input");
  for (const BodyRegion& region : d.regions) {
    if (!region.min_m.allFinite() || !region.max_m.allFinite() || !region.traction_pa.allFinite()) {
      return not_physical(d, "region " + region.name + " is not finite; check its box and traction");
    }
    if (!region.material) continue;
    const std::string name = "region " + region.name + ": ";
    LIVEGS_RETURN_IF_ERROR(check_range(d.object_id, (name + "friction").c_str(),
                                       region.material->friction.value_or(0.0), 0.0, kMaxFriction));
    LIVEGS_RETURN_IF_ERROR(check_range(d.object_id, (name + "friction_factor").c_str(),
                                       region.material->friction_factor, 0.0, kMaxFrictionFactor));
  }
  if (!(d.cell_width_m >= 0.0) || !std::isfinite(d.cell_width_m)) {
    return not_physical(
        d, "cell_width_m is " + number_text(d.cell_width_m) + "; it must be 0 (chosen) or above");
  }
  return {};
}

}  // namespace

const char* name_of(ElasticBand band) {
  const char* const names[] = {"exact", "band", "clipped", "unknown"};
  return names[static_cast<size_t>(band)];
}

Result<void> check_elastic_body(const ElasticBodyDescription& description) {
  LIVEGS_RETURN_IF_ERROR(check_particles(description));
  LIVEGS_RETURN_IF_ERROR(check_material(description.object_id, description.material));
  LIVEGS_RETURN_IF_ERROR(check_stiffness(description.object_id, description.material));
  LIVEGS_RETURN_IF_ERROR(check_pose(description.object_id, description.world_from_object));
  return check_motion(description);
}

Result<void> check_elastic_body(const ElasticBodyDescription& description, double rate_hz, int substeps) {
  LIVEGS_RETURN_IF_ERROR(check_elastic_body(description));
  if (!(rate_hz > 0.0) || !std::isfinite(rate_hz))
    return not_physical(description, format_text("rate_hz is %g; it must be above 0", rate_hz));
  if (substeps < 1 || substeps > 10000)
    return not_physical(description, format_text("substeps is %d; it must be 1 to 10000", substeps));
  return {};
}

void ElasticBody::surface_elements(const Eigen::AlignedBox3d&, std::vector<SurfaceElement>&) const {}
ContactAnchor ElasticBody::anchor_at(uint32_t, const Vector3d&) const { return {}; }
ContactParticipant& ElasticBody::contact_participant() { std::abort(); }
void ElasticBody::defer_sleep(bool) {}

}  // namespace livegs
