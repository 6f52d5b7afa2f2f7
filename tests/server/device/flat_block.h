// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "physics/elastic/flat_body.h"

namespace livegs::test {

// A block of full and, below, cut cells as a device receives it, without the solver of server/physics: for
// tests and timings of the passes. Its gains relax half of every strain, which is stable but of no material.
class FlatBlock final : public FlatBody {
 public:
  struct Options {
    std::array<int, 3> cells{4, 4, 4};
    int steps = 4;
    double height_m = 0.0;  // of its middle
    bool held = false;      // at its face x = 0
    bool loaded = false;    // a force on each node of the opposite face
    bool touches = true;    // may touch the colliders of the tick
  };

  explicit FlatBlock(const Options& options) : options_(options) {
    static uint64_t made = 0;
    revision_ = ++made;
    const auto [nx, ny, nz] = options.cells;
    const auto node = [&](int x, int y, int z) {
      return static_cast<uint32_t>(x + (nx + 1) * (y + (ny + 1) * z));
    };
    lattice_.node_count = static_cast<size_t>((nx + 1) * (ny + 1) * (nz + 1));
    for (uint32_t colour = 0; colour < 8; ++colour) {
      for (int z = 0; z < nz; ++z) {
        for (int y = 0; y < ny; ++y) {
          for (int x = 0; x < nx; ++x) {
            if (static_cast<uint32_t>(x % 2 + 2 * (y % 2) + 4 * (z % 2)) != colour) continue;
            FlatLattice::Cell cell{};
            for (int c = 0; c < 8; ++c) cell.nodes[c] = node(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
            cell.colour = colour;
            cell.constants = y == 0 ? 1 : 0;
            lattice_.cells.push_back(cell);
            if (y == 0) add_surface(cell);
          }
        }
      }
    }
    set_gains();
    for (int z = 0; z <= nz; ++z) {
      for (int y = 0; y <= ny; ++y) {
        for (int x = 0; x <= nx; ++x) {
          const Eigen::Vector3d rest = kWidth_m * Eigen::Vector3d(x - 0.5 * nx, y - 0.5 * ny, z - 0.5 * nz);
          add_node(rest, options.held && x == 0, options.loaded && x == nx);
        }
      }
    }
    state_.rotations.assign(lattice_.cells.size(), {0, 0, 0, 1});
    set_motion();
  }

  uint64_t flat_revision() const override { return revision_; }
  size_t flat_node_count() const override { return lattice_.node_count; }
  int flat_steps() const override { return options_.steps; }
  const char* flat_obstacle() const override { return nullptr; }
  void write_flat(FlatLattice& lattice) override { lattice = lattice_; }
  const char* begin_flat_tick(const FlatTick& tick, FlatState& state) override {
    state = state_;
    state.steps = options_.steps;
    state.step_s = tick.duration_s / options_.steps;
    state.weight_n = state.mass_kg * tick.gravity_m_s2.norm();
    state.slow_m_s = 0.1 * std::sqrt(tick.gravity_m_s2.norm() * kWidth_m);
    state.colliders.clear();
    for (const Collider& collider : tick.colliders) {
      if (!options_.touches) break;
      FlatCollider flat;
      flat.at_m = collider.world_from_collider.position_m;
      flat.world_from_collider = collider.world_from_collider.orientation.toRotationMatrix();
      flat.friction = collider.friction;
      if (const auto* box = std::get_if<BoxShape>(&collider.shape)) {
        flat.kind = FlatCollider::Kind::Box;
        flat.half_m = 0.5 * box->size_m;
        flat.thickness_m = box->size_m.minCoeff();
      } else if (const auto* sphere = std::get_if<SphereShape>(&collider.shape)) {
        flat.kind = FlatCollider::Kind::Sphere;
        flat.half_m.setConstant(sphere->radius_m);
        flat.thickness_m = 2.0 * sphere->radius_m;
      }
      state.colliders.push_back(flat);
    }
    return nullptr;
  }
  void end_flat_tick(const FlatTick&, const FlatState& state) override {
    const Eigen::Vector3d load_n = state_.load_n;
    state_ = state;
    state_.load_n = load_n;
    state_.contact_n_s = 0.0;
    state_.contact_moment.setZero();
    touched_ = touched_ || state.touching;
    set_motion();
  }

  const FlatState& state() const { return state_; }
  bool touched() const { return touched_; }
  bool finite() const {
    return std::all_of(state_.now.begin(), state_.now.end(), [](const FlatNode& one) {
      return std::isfinite(one.place[0] + one.place[1] + one.place[2] + one.speed[0] + one.speed[1]);
    });
  }

 private:
  static constexpr double kWidth_m = 0.02, kMass_kg = 0.008;

  void add_surface(const FlatLattice::Cell& cell) {
    FlatLattice::SurfaceCell surface{};
    std::copy(std::begin(cell.nodes), std::end(cell.nodes), surface.nodes);
    surface.colour = cell.colour;
    surface.begin = static_cast<uint32_t>(lattice_.surface_points.size());
    for (const float x : {0.25f, 0.75f}) {  // on the face below
      FlatLattice::SurfacePoint point{};
      float squares = 0.0f;
      for (int c = 0; c < 8; ++c) {
        point.weights[c] = c & 2 ? 0.0f : (c & 1 ? x : 1.0f - x) * 0.5f;
        squares += point.weights[c] * point.weights[c];
      }
      point.mobility = squares / static_cast<float>(kMass_kg);
      lattice_.surface_points.push_back(point);
    }
    surface.end = static_cast<uint32_t>(lattice_.surface_points.size());
    lattice_.surface_cells.push_back(surface);
  }

  void set_gains() {
    const auto mobility = static_cast<float>(0.5 / kMass_kg / (kWidth_m * kWidth_m));
    auto& full = lattice_.constants.emplace_back();
    for (size_t k = 3; k < 6; ++k) full[k] = mobility;
    auto& cut = lattice_.constants.emplace_back(full);  // every number counts
    for (size_t k = 0; k < 3; ++k) cut[k] = 0.1f - 0.07f * static_cast<float>(k);
    for (size_t k = 6; k < 9; ++k) cut[k] = mobility * (0.2f - 0.03f * static_cast<float>(k));
    for (size_t k = 9; k < 21; ++k) cut[k] = 0.001f * mobility * static_cast<float>(k);
    for (auto& of_order : lattice_.gains) {
      auto& gains = of_order.emplace_back();
      for (const size_t diagonal : {0, 6, 11, 15, 18, 20}) gains[diagonal] = 0.5f / mobility;
      gains[21] = mobility;
      for (size_t k = 22; k < 34; ++k) gains[k] = static_cast<float>(0.5 * kMass_kg);
      auto& of_cut = of_order.emplace_back(gains);
      for (size_t k = 0; k < 21; ++k) of_cut[k] += (0.002f * static_cast<float>(k) - 0.02f) / mobility;
      for (size_t k = 22; k < 34; ++k) of_cut[k] *= 1.0f - 0.01f * static_cast<float>(k);
    }
  }

  void add_node(const Eigen::Vector3d& rest_m, bool held, bool loaded) {
    const Eigen::Vector3f x =
        (rest_m + Eigen::Vector3d(0.002 * std::sin(40.0 * rest_m.y()), options_.height_m, 0.0)).cast<float>();
    const Eigen::Vector3f v =
        held ? Eigen::Vector3f::Zero() : Eigen::Vector3f(0.5f - 3.0f * x.y(), -0.5f, 1.5f * x.x());
    const FlatNode node{{x.x(), x.y(), x.z(), held ? 0.0f : static_cast<float>(1.0 / kMass_kg)},
                        {v.x(), v.y(), v.z(), static_cast<float>(kMass_kg)}};
    state_.now.push_back(node);
    state_.before.push_back(node);
    if (options_.loaded)
      state_.loads_n.push_back(loaded ? FlatVector{0.02f, -0.01f, 0.0f, 0.0f} : FlatVector{});
    if (loaded) state_.load_n += Eigen::Vector3d(0.02, -0.01, 0.0);
  }

  // The whole body by its nodes, in double precision.
  void set_motion() {
    state_.held = options_.held;
    state_.mass_kg = kMass_kg * static_cast<double>(state_.now.size());
    state_.damping_per_s = 2.0;
    state_.moving_part = 0.1;
    state_.friction = 0.5;
    state_.loss_factor = 0.1;
    state_.inverse_four_widths = 0.25 / kWidth_m;
    state_.stiffness_pa = 1e5;
    const auto vector = [](const FlatVector& v) { return Eigen::Vector3d(v[0], v[1], v[2]); };
    state_.ledger.motion.centre_m.setZero();
    state_.ledger.motion.momentum.setZero();
    for (const FlatNode& node : state_.now) {
      state_.ledger.motion.centre_m += kMass_kg / state_.mass_kg * vector(node.place);
      state_.ledger.motion.momentum += kMass_kg * vector(node.speed);
    }
    state_.ledger.motion.angular_momentum.setZero();
    state_.load_torque.setZero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (size_t i = 0; i < state_.now.size(); ++i) {
      const Eigen::Vector3d r = vector(state_.now[i].place) - state_.ledger.motion.centre_m;
      second += kMass_kg * r * r.transpose();
      state_.ledger.motion.angular_momentum += kMass_kg * r.cross(vector(state_.now[i].speed));
      if (options_.loaded) state_.load_torque += r.cross(vector(state_.loads_n[i]));
    }
    state_.ledger.node_inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
    state_.ledger.motion.inertia = state_.ledger.node_inertia;
    state_.ledger.momentum_before = state_.ledger.motion.momentum;
    state_.ledger.angular_before = state_.ledger.motion.angular_momentum;
  }

  Options options_;
  uint64_t revision_ = 0;
  FlatLattice lattice_;
  FlatState state_;
  bool touched_ = false;
};

}  // namespace livegs::test
