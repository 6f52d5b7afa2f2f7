// SPDX-License-Identifier: GPL-3.0-or-later
// Fixed, moved and loaded regions. The nodes of cells entirely inside a held region are held directly. If a
// region ends inside a cell, its particles are held individually after the sweep, by the least change of the
// free nodes in the norm of their masses. Lattice planes are snapped to regions if possible.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/log.h"
#include "physics/elastic/cells/cells_body.h"
#include "physics/lattice/region_load.h"

namespace livegs::cells {
namespace {

// A particle with less than this part of its weight on free nodes is not held individually; the held nodes
// suffice.
constexpr double kFreeShare = 0.05;
// Conjugate gradients that hold particles end when the residual is below this part of that at the start of
// the step.
constexpr double kHeldResidual = 1e-3;
// Least singular value of the held particles' weights, over the root of the masses, that is held in full,
// relative to the largest. Below it nodes would move far for a small change of the particles, and a body at
// rest would gain energy. Smaller: thin bodies become unstable. Larger: moved particles lag.
constexpr double kMinHeldSingularValue = 0.03;

bool holds(const BodyRegion& region) { return region.fixed || region.motion.has_value(); }

}  // namespace

// Whether all material of a cell can lie in the region; tests the cell clipped to the body's bounds.
bool CellsBody::in_region(const LatticeCell& cell, const BodyRegion& region) const {
  const double margin = 1e-3 * lattice_.cell_width_m;
  const Vector3d low_m = lattice_.object_from_lattice.position_m,
                 width = Vector3d::Constant(lattice_.cell_width_m);
  const Vector3d low = extent_.object_from_lattice.conjugate() * low_m +
                       lattice_.cell_width_m * cell.coordinates.cast<double>();
  const Vector3d from = low.cwiseMax(extent_.min_m), to = (low + width).cwiseMin(extent_.max_m);
  for (int c = 0; c < 8; ++c) {
    const Vector3d corner(c & 1 ? to.x() : from.x(), c & 2 ? to.y() : from.y(), c & 4 ? to.z() : from.z());
    if (!region.contains(extent_.object_from_lattice * corner, margin)) return false;
  }
  return true;
}

void CellsBody::hold_node(ConstrainedRegion& held, uint32_t node) {
  inverse_masses_[node] = 0.0;
  held.nodes.push_back(node);
  held.node_rest_m.push_back(lattice_.node_position_m(node));
}

void CellsBody::hold_regions(const ElasticBodyDescription& description) {
  std::vector<bool> taken(lattice_.node_coordinates.size(), false);
  const std::vector<uint8_t> cells_around = cells_around_nodes(lattice_);
  for (const BodyRegion& region : description.regions) {
    if (!holds(region)) continue;
    ConstrainedRegion held;
    held.region = region;
    std::vector<bool> own(taken.size(), false);
    const auto take = [&](uint32_t node) {
      if (taken[node]) {
        if (!own[node]) held.nodes_of_others.push_back(node);
        return;
      }
      taken[node] = own[node] = true;
      hold_node(held, node);
    };
    if (region.boundary) {
      // Takes all boundary nodes, and all nodes of boundary cells that are not full: inner nodes of these
      // would be next to a free surface.
      for (uint32_t node = 0; node < taken.size(); ++node) {
        if (cells_around[node] < 8) take(node);
      }
      const double full_m3 = std::pow(lattice_.cell_width_m, 3);
      for (const LatticeCell& cell : lattice_.cells) {
        const bool outer =
            std::ranges::any_of(cell.nodes, [&](uint32_t node) { return cells_around[node] < 8; });
        if (!outer || cell.volume_m3 > (1.0 - 1e-6) * full_m3) continue;
        for (const uint32_t node : cell.nodes) take(node);
      }
    } else {
      for (const LatticeCell& cell : lattice_.cells) {
        if (!(region.fixed ? cell.fixed && in_region(cell, region) : in_region(cell, region))) continue;
        for (const uint32_t node : cell.nodes) take(node);
      }
      for (size_t p = 0; p < particle_rest_m_.size(); ++p) {
        if (!region.contains(particle_rest_m_[p], 1e-6 * lattice_.cell_width_m)) continue;
        const NodeSample sample = sample_at(particle_points_[p]);
        double free_share = 0.0;
        for (int c = 0; c < 8; ++c) free_share += taken[sample.nodes[c]] ? 0.0 : std::abs(sample.weights[c]);
        if (free_share < kFreeShare) continue;
        held.particles.push_back(sample);
      }
      if (held.nodes.empty()) hold_face(description.particles, held);
    }
    if (held.nodes.empty() && held.particles.empty()) {
      log_warn(
          "object %u: region \"%s\" from (%.3g, %.3g, %.3g) to (%.3g, %.3g, %.3g) m holds no material; "
          "check its box",
          object_id_, region.name.c_str(), region.min_m.x(), region.min_m.y(), region.min_m.z(),
          region.max_m.x(), region.max_m.y(), region.max_m.z());
      continue;
    }
    if (held.nodes.empty() && held.particles.size() < 3) {
      log_warn(
          "object %u: region \"%s\" holds only %zu particles and no cell, so the body can rotate about them; "
          "widen the region or reduce spacing_m below %.3g m",
          object_id_, region.name.c_str(), held.particles.size(), extent_.spacing_m);
    }
    number_held_nodes(held);
    holding_.held = true;
    holding_.moved = holding_.moved || region.motion.has_value();
    holding_.regions.push_back(std::move(held));
  }
  measure_held_reach();
}

// The largest distance of a node from the held ones, along the body: in steps from cell to cell, of which a
// diagonal one counts once. It is the length of the beam that sets the lowest mode.
void CellsBody::measure_held_reach() {
  std::vector<int> steps(inverse_masses_.size(), -1);
  for (const ConstrainedRegion& held : holding_.regions) {
    if (held.released) continue;
    for (const uint32_t node : held.nodes) steps[node] = 0;
    for (const uint32_t node : held.particle_nodes) steps[node] = 0;
  }
  int reach = 0;
  for (bool grows = true; grows;) {
    grows = false;
    for (const LatticeCell& cell : lattice_.cells) {
      const bool reached = std::ranges::any_of(
          cell.nodes, [&](uint32_t node) { return steps[node] >= 0 && steps[node] <= reach; });
      if (!reached) continue;
      for (const uint32_t node : cell.nodes) {
        if (steps[node] >= 0) continue;
        steps[node] = reach + 1;
        grows = true;
      }
    }
    reach += grows;
  }
  holding_.reach_m = std::max(reach, 1) * lattice_.cell_width_m;
}

// A grip thinner than a voxel contains little more than the corners of the surface. Its face is then held as
// well, at the points of a traction. This applies only to grips across the whole body; a line of particles
// acts as a hinge.
void CellsBody::hold_face(const ParticleSet& particles, ConstrainedRegion& held) {
  AlignedBox3d body;
  for (const Vector3d& particle : particle_rest_m_) body.extend(particle);
  const Vector3d slack = Vector3d::Constant(1e-6 * lattice_.cell_width_m);
  const auto over = (held.region.min_m - slack).array() <= body.min().array() &&
                    (held.region.max_m + slack).array() >= body.max().array();
  if (over.count() < 2) return;
  const std::vector<LoadPoint> points = load_points(particles, extent_, lattice_, held.region);
  if (points.size() <= held.particles.size()) return;
  for (const LoadPoint& point : points) held.particles.push_back(sample_at(point.point));
}

void CellsBody::load_regions(const ElasticBodyDescription& description) {
  for (const BodyRegion& region : description.regions) {
    if (region.traction_pa.isZero()) continue;
    const std::vector<LoadPoint> points = load_points(description.particles, extent_, lattice_, region);
    if (points.empty()) {
      log_warn("object %u: region \"%s\" has a traction but holds no material; check its box", object_id_,
               region.name.c_str());
    }
    for (const LoadPoint& point : points) {
      loads_.regions.push_back({sample_at(point.point), point.area_m2 * region.traction_pa});
    }
  }
}

Vector3d CellsBody::region_target_m(const ConstrainedRegion& held, const Vector3d& rest_m,
                                    double time_s) const {
  const Vector3d point = held.region.motion ? moved_point(*held.region.motion, rest_m, time_s) : rest_m;
  return holding_.world_from_object * point - origin_m_;
}

bool CellsBody::driven(double from_s, double to_s) const {
  return holding_.moved && std::ranges::any_of(holding_.regions, [&](const ConstrainedRegion& held) {
           return !held.released && held.region.motion && moves_between(*held.region.motion, from_s, to_s);
         });
}

void CellsBody::move_regions(double time_s, double h) {
  step_.driven_m_s = 0.0;
  for (const ConstrainedRegion& held : holding_.regions) {
    if (held.released || !held.region.motion) continue;
    for (size_t i = 0; i < held.nodes.size(); ++i) {
      const Vector3d target = region_target_m(held, held.node_rest_m[i], time_s);
      const Vector3d velocity_m_s = (target - nodes_.position_m(held.nodes[i])) / h;
      nodes_.predict(held.nodes[i], target, velocity_m_s);
      step_.driven_m_s = std::max(step_.driven_m_s, velocity_m_s.norm());
    }
    for (size_t i = 0; i < held.particles.size(); ++i) {
      const Vector3d way_m =
          region_target_m(held, held.particle_rest_m[i], time_s) - nodes_.position_m(held.particles[i]);
      step_.driven_m_s = std::max(step_.driven_m_s, way_m.norm() / h);
    }
  }
}

// Lists the nodes of the particles that are held individually, and the places of the particles at rest: those
// of their weights, so that all targets agree.
void CellsBody::number_held_nodes(ConstrainedRegion& held) const {
  std::vector<uint32_t> nodes;
  for (const NodeSample& sample : held.particles)
    nodes.insert(nodes.end(), std::begin(sample.nodes), std::end(sample.nodes));
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  held.particle_nodes = nodes;
  for (const NodeSample& sample : held.particles) {
    auto& numbers = held.numbers.emplace_back();
    Vector3d& rest_m = held.particle_rest_m.emplace_back(Vector3d::Zero());
    for (int c = 0; c < 8; ++c) {
      rest_m += sample.weights[c] * lattice_.node_position_m(sample.nodes[c]);
      numbers[c] = static_cast<uint32_t>(std::ranges::lower_bound(nodes, sample.nodes[c]) - nodes.begin());
    }
  }
}

// Regularised least squares |W d - r|² + l² sum of m d² (Tikhonov) by conjugate gradients on B = W M^-1/2
// (CGLS; Björck 1996, Numerical methods for least squares problems, 7.4), with r the distances to the
// targets, W the weights of the particles and d the changes of their nodes. The particles can be more than
// the free nodes; their targets agree, because motions are affine in each cell.
void CellsBody::hold_particles(double time_s) {
  for (const ConstrainedRegion& held : holding_.regions) {
    const size_t count = held.particles.size(), node_count = held.particle_nodes.size();
    if (held.released || count == 0) continue;
    std::vector<double> roots(node_count);  // of the inverse masses
    for (size_t n = 0; n < node_count; ++n) roots[n] = std::sqrt(inverse_masses_[held.particle_nodes[n]]);
    std::vector<Vector3d> residual(count), gradient(node_count), direction,
        change(node_count, Vector3d::Zero());
    double square = 0.0;
    for (size_t i = 0; i < count; ++i) {
      residual[i] =
          region_target_m(held, held.particle_rest_m[i], time_s) - nodes_.corrected_m(held.particles[i]);
      square += residual[i].squaredNorm();
    }
    double largest = 0.0;  // square of the largest row of B, about that of the largest singular value
    for (size_t i = 0; i < count; ++i) {
      double row = 0.0;
      for (int c = 0; c < 8; ++c)
        row += std::pow(held.particles[i].weights[c] * roots[held.numbers[i][c]], 2);
      largest = std::max(largest, row);
    }
    const double damping = kMinHeldSingularValue * kMinHeldSingularValue * largest;  // l²
    const auto set_gradient = [&] {                                                  // B^T r - l² M^1/2 d
      std::fill(gradient.begin(), gradient.end(), Vector3d::Zero());
      for (size_t i = 0; i < count; ++i) {
        for (int c = 0; c < 8; ++c)
          gradient[held.numbers[i][c]] += held.particles[i].weights[c] * residual[i];
      }
      double sum = 0.0;
      for (size_t n = 0; n < node_count; ++n) {
        gradient[n] = roots[n] * gradient[n] - damping * change[n];
        sum += gradient[n].squaredNorm();
      }
      return sum;
    };
    const double tolerance_m = 1e-7 * lattice_.cell_width_m;
    const double end = std::max(kHeldResidual * kHeldResidual * square, tolerance_m * tolerance_m * count);
    double slope = set_gradient();
    const double least_slope = kHeldResidual * kHeldResidual * kHeldResidual * slope;
    direction = gradient;
    for (int k = 0; k < 40 && square > end && slope > least_slope; ++k) {
      double length = 0.0;
      std::vector<Vector3d> image(count, Vector3d::Zero());
      for (size_t i = 0; i < count; ++i) {
        for (int c = 0; c < 8; ++c) {
          const uint32_t n = held.numbers[i][c];
          image[i] += held.particles[i].weights[c] * roots[n] * direction[n];
        }
        length += image[i].squaredNorm();
      }
      for (size_t n = 0; n < node_count; ++n) length += damping * direction[n].squaredNorm();
      if (!(length > 0.0)) break;
      const double step = slope / length, before = slope;
      square = 0.0;
      for (size_t i = 0; i < count; ++i) {
        residual[i] -= step * image[i];
        square += residual[i].squaredNorm();
      }
      for (size_t n = 0; n < node_count; ++n) change[n] += step * direction[n];
      slope = set_gradient();
      for (size_t n = 0; n < node_count; ++n) direction[n] = gradient[n] + slope / before * direction[n];
    }
    for (size_t n = 0; n < node_count; ++n) nodes_.correct(held.particle_nodes[n], roots[n] * change[n]);
  }
}

bool CellsBody::release_region(const std::string& name) {
  bool found = false;
  for (ConstrainedRegion& held : holding_.regions) {
    if (held.region.name != name || held.released) continue;
    found = held.released = true;
    for (const uint32_t node : held.nodes) inverse_masses_[node] = 1.0;
  }
  if (!found) return false;
  holding_.held = holding_.moved = false;
  for (ConstrainedRegion& held : holding_.regions) {
    if (held.released) continue;
    holding_.held = true;
    holding_.moved = holding_.moved || held.region.motion;
    // Neighbouring regions have the nodes between them in common.
    for (const uint32_t node : held.nodes_of_others) {
      if (inverse_masses_[node] > 0.0) hold_node(held, node);
    }
  }
  set_masses();
  measure_held_reach();
  restart_motion();  // the last step was not that of a free body
  rebuild_cells();
  wake();
  return true;
}

}  // namespace livegs::cells
