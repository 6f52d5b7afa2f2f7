// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/part_materials.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "analysis/division/part_places.h"
#include "analysis/knowledge/tables.h"
#include "core/text/shown_text.h"
#include "geometry/field/sample_particles.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/mesh/triangle_pieces.h"

namespace livegs {
namespace {

// Samples along the longest side for the mass of rigid parts: a centre of mass within a hundredth of it.
constexpr int kMassSamplesAlong = 64;
// Largest E* of a part over that of the body.
constexpr double kMaxPartStiffnessRatio = 10.0;

struct MassSample {
  Eigen::Vector3d point_m;
  double extent;  // volume, m³, or area of a shell, m²
};

std::vector<MassSample> mass_samples(const TriangleMesh& mesh, bool shell) {
  std::vector<MassSample> samples;
  if (shell) {
    const double edge_m = mesh_bounds_m(mesh).sizes().maxCoeff() / kMassSamplesAlong;
    for_each_triangle_piece(mesh, edge_m, [&](const Eigen::Vector3d& centre_m, double area_m2) {
      samples.push_back({centre_m, area_m2});
    });
    return samples;
  }
  const ParticleSet particles = sample_particles(mesh, kMassSamplesAlong);
  for (size_t i = 0; i < particles.positions_m.size(); ++i)
    samples.push_back({particles.positions_m[i], particles.volumes_m3[i]});
  return samples;
}

// Mass per extent of each part for a total of `mass_kg`, and of parts without extent 0.
std::vector<double> part_densities(const MaterialParts& parts, const std::vector<double>& extents,
                                   double mass_kg) {
  double placed = 0;
  for (size_t i = 0; i < extents.size(); ++i)
    placed += extents[i] > 0 ? parts[static_cast<int>(i)].mass_share() : 0;
  std::vector<double> densities(extents.size(), 0.0);
  for (size_t i = 0; i < extents.size(); ++i) {
    if (extents[i] > 0 && placed > 0)
      densities[i] = parts[static_cast<int>(i)].mass_share() / placed * mass_kg / extents[i];
  }
  return densities;
}

// Friction of a part over that of the object; 1 if a material is not in the table.
double friction_factor(const v1::PhysicalParameters& parameters, size_t part) {
  const MaterialRow* own = find_material_row(parameters.material());
  const MaterialRow* row = find_material_row(parameters.parts(static_cast<int>(part)).material());
  return own && row && own->friction > 0 ? row->friction / own->friction : 1.0;
}

// Lines for the parts that have no extent: their boxes are outside the body or in later ones, or they have
// none and an earlier part has the rest. The rest itself may be empty.
std::vector<std::string> without_material(const MaterialParts& parts, const std::vector<double>& extents) {
  std::vector<std::string> lines;
  const size_t rest = PartPlaces(parts).rest();
  for (size_t i = 0; i < extents.size(); ++i) {
    const v1::MaterialPart& part = parts[static_cast<int>(i)];
    if (extents[i] > 0 || (i == rest && part.boxes().empty())) continue;
    lines.push_back("part \"" + shown_text(part.name(), 60) +
                    (part.boxes().empty()
                         ? "\" has no box, and its mass goes to the others; give it a box, or remove the part"
                         : "\" has no material in its boxes, and its mass goes to the others; move the boxes "
                           "into the object and out of later ones, or remove the part"));
  }
  return lines;
}

}  // namespace

std::vector<FrictionBox> part_friction(const v1::PhysicalParameters& parameters) {
  const PartPlaces places(parameters.parts());
  std::vector<FrictionBox> boxes;
  if (!places.divided()) return boxes;
  const auto all = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  boxes.push_back({{-all, all}, friction_factor(parameters, places.rest())});
  for (const PartPlaces::Box& one : places.boxes())
    boxes.push_back({one.box, friction_factor(parameters, one.part)});
  const bool even =
      std::all_of(boxes.begin(), boxes.end(), [](const FrictionBox& one) { return one.factor == 1.0; });
  return even ? std::vector<FrictionBox>() : boxes;
}

std::vector<std::string> weigh_parts(const TriangleMesh& mesh, bool shell, v1::PhysicalParameters& parameters,
                                     MassProperties& properties) {
  MaterialParts& parts = *parameters.mutable_parts();
  const PartPlaces places(parts);
  if (!places.divided()) return {};
  const std::vector<MassSample> samples = mass_samples(mesh, shell);
  std::vector<double> extents(static_cast<size_t>(parts.size()), 0.0);
  for (const MassSample& sample : samples) extents[places.at(sample.point_m)] += sample.extent;
  const std::vector<double> densities = part_densities(parts, extents, 1.0);
  double mass = 0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (const MassSample& sample : samples) {
    const double one = densities[places.at(sample.point_m)] * sample.extent;
    mass += one;
    moment += one * sample.point_m;
  }
  if (!(mass > 0)) return without_material(parts, extents);
  const Eigen::Vector3d centre = moment / mass;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (const MassSample& sample : samples) {
    const Eigen::Vector3d arm = sample.point_m - centre;
    const double one = densities[places.at(sample.point_m)] * sample.extent / mass;
    // A sample of volume V is a cube of edge cbrt(V): edge² / 6 about each axis.
    const double own_m2 = shell ? 0.0 : std::pow(std::cbrt(sample.extent), 2) / 6;
    inertia += one * ((arm.squaredNorm() + own_m2) * Eigen::Matrix3d::Identity() - arm * arm.transpose());
  }
  properties.centre_of_mass_m = centre;
  properties.inertia_m2 = inertia;
  for (int i = 0; i < parts.size(); ++i) {
    // A shell has mass per area; its density follows from the wall.
    const double wall_m = shell ? parameters.wall_thickness_m().best() : 1.0;
    parts[i].set_density_kg_m3(
        wall_m > 0 ? densities[static_cast<size_t>(i)] * parameters.mass_kg().best() / wall_m : 0.0);
  }
  return without_material(parts, extents);
}

std::vector<std::string> add_part_regions(v1::PhysicalParameters& parameters, ElasticBodyDescription& body) {
  MaterialParts& parts = *parameters.mutable_parts();
  const PartPlaces places(parts);
  if (!places.divided()) return {};
  const ParticleSet& particles = body.particles;
  std::vector<double> extents(static_cast<size_t>(parts.size()), 0.0);
  for (size_t i = 0; i < particles.positions_m.size(); ++i)
    extents[places.at(particles.positions_m[i])] += particles.volumes_m3[i];
  const std::vector<double> densities = part_densities(parts, extents, body.material.mass_kg);
  const double volume_m3 = std::accumulate(extents.begin(), extents.end(), 0.0);
  const MaterialRow* own = find_material_row(parameters.material());
  const double body_pa = body.material.effective_youngs_modulus_pa();
  const auto material_of = [&](size_t part) {
    const v1::MaterialPart& written = parts[static_cast<int>(part)];
    const MaterialRow* row = find_material_row(written.material());
    double modulus_pa = body_pa;
    if (written.youngs_modulus_pa() > 0) {
      modulus_pa = body.material.structure_coefficient * written.youngs_modulus_pa();
    } else if (row && !(own && own->material_class == row->material_class)) {
      modulus_pa = body.material.structure_coefficient * row->youngs_modulus_pa.best;
    }
    RegionMaterial material;
    material.youngs_modulus_factor = std::min(modulus_pa / body_pa, kMaxPartStiffnessRatio);
    if (densities[part] > 0) material.density_factor = densities[part] * volume_m3 / body.material.mass_kg;
    if (row) {
      material.poisson_ratio = std::clamp(row->poisson_ratio, 0.0, 0.49);
      material.plasticity = row->plasticity;
    }
    material.friction_factor = friction_factor(parameters, part);
    return material;
  };
  std::vector<BodyRegion> regions;
  const auto add = [&](size_t part, const Eigen::Vector3d& min_m, const Eigen::Vector3d& max_m) {
    if (!(extents[part] > 0)) return;
    BodyRegion region;
    region.name = "part " + parts[static_cast<int>(part)].name();
    region.min_m = min_m;
    region.max_m = max_m;
    region.material = material_of(part);
    regions.push_back(std::move(region));
  };
  const Eigen::Vector3d far = Eigen::Vector3d::Constant(1e4);  // farther than any body
  add(places.rest(), -far, far);
  for (const PartPlaces::Box& box : places.boxes())
    add(box.part, box.box.min().cwiseMax(-far), box.box.max().cwiseMin(far));
  body.regions.insert(body.regions.begin(), regions.begin(), regions.end());
  for (int i = 0; i < parts.size(); ++i) parts[i].set_density_kg_m3(densities[static_cast<size_t>(i)]);
  return without_material(parts, extents);
}

}  // namespace livegs
