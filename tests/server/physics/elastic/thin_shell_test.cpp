// SPDX-License-Identifier: Apache-2.0
// Curved sheets thinner than a cell in the solver itself: a quarter cylinder of radius 0.1 m, 3 mm thick and
// 50 mm wide, compared with beam theory and with plain cells (CellsOptions::thin false).
#include <Eigen/Eigenvalues>
#include <cstdio>

#include "known_gaps.h"
#include "server/physics/elastic/quarter_shell.h"

namespace livegs::test {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;

constexpr double kT = kStripThickness_m, kRho = kStripDensity_kg_m3;
constexpr double kModulus_pa = kQuarterModulus_pa;

// The ends of the quarter cylinder, 5 mm each.
struct Ends {
  std::vector<StripPoint> points = strip_points(kQuarter);
  double volumes[2] = {0, 0}, along[2] = {0, 0};

  Ends() {
    for (const StripPoint& p : points) {
      if (side(p) < 0) continue;
      volumes[side(p)] += p.volume_m3;
      along[side(p)] += p.volume_m3 * p.along_m;
    }
  }
  static int side(const StripPoint& p) {
    return p.along_m < 0.005 ? 0 : p.along_m > kQuarter.length_m - 0.005 ? 1 : -1;
  }

  // Opening under a force of 1 N by Castigliano: F R³/(E I) (h + sin(2h)/2 - 4 cos(h) sin(h) + 2 h cos²(h)).
  double opening_m() const {
    const double h = 0.5 * (along[1] / volumes[1] - along[0] / volumes[0]) / kQuarter.radius_m,
                 c = std::cos(h);
    return std::pow(kQuarter.radius_m / kT, 3) * 12.0 / (kModulus_pa * kQuarter.width_m) *
           (h + 0.5 * std::sin(2 * h) - 4 * c * std::sin(h) + 2 * h * c * c);
  }
  std::vector<PointForce> forces(double force_n) const {
    std::vector<PointForce> forces;
    const Vector3d chord = Vector3d(1, 0, -1).normalized();
    for (const StripPoint& p : points) {
      if (side(p) < 0) continue;
      forces.push_back(
          {p.at_m, (side(p) == 0 ? -1.0 : 1.0) * force_n * p.volume_m3 / volumes[side(p)] * chord});
    }
    return forces;
  }
  double gap_m(const ElasticBody& body) const {
    Vector3d sum[2] = {Vector3d::Zero(), Vector3d::Zero()};
    for (const StripPoint& p : points) {
      if (side(p) >= 0) sum[side(p)] += p.volume_m3 / volumes[side(p)] * body.world_point(p.at_m);
    }
    return (sum[1] - sum[0]).norm();
  }
};

constexpr double kOpened_m = 0.002;

// Apparent over true bending stiffness. The strip settles for 2 s of its own time.
double stiffness_ratio(double cells_t, double poisson_ratio, bool thin) {
  const Ends ends;
  Stage stage;
  stage.make(describe_quarter(cells_t, poisson_ratio, thin));
  const double force_n = kOpened_m / ends.opening_m(), gap_m = ends.gap_m(*stage.body);
  stage.forces = ends.forces(force_n);
  stage.run(80.0);
  const double opened_m = ends.gap_m(*stage.body) - gap_m;
  const BodyEnergy energy = stage.body->energy(kNoGravity);
  // All work is stored as elastic energy, which excludes the compliance of the Gauss-Seidel pass.
  EXPECT_NEAR(energy.elastic_j / (0.5 * force_n * opened_m), 1.0, 0.06) << cells_t;
  EXPECT_LT(energy.kinetic_j, 1e-3 * energy.elastic_j);
  return kOpened_m / opened_m;
}

TEST(ThinShell, QuarterCylinderOpensLikeABeam) {
  for (const double cells_t : gate_or_full<double>({5.0, 10.0}, {3.0, 5.0, 7.0, 10.0})) {
    const double thin = stiffness_ratio(cells_t, 0.3, true), plain = stiffness_ratio(cells_t, 0.3, false);
    std::printf("cells of %g t: stiffness %.2f of a beam's, plain cells %.2f\n", cells_t, thin, plain);
    EXPECT_GT(thin, 0.9) << cells_t;
    EXPECT_LT(thin, 1.2) << cells_t;
    EXPECT_GT(plain, 1.6) << cells_t;
  }
}

// The lowest angular frequency of a free arc in its plane, for unit E I and rho A: a frame of straight
// Euler-Bernoulli beams, axially stiff.
double arc_frequency(double length_m, double radius_m) {
  constexpr int kCount = 48;
  const double axial = 1e4 / (length_m * length_m), step = length_m / kCount;
  MatrixXd stiffness = MatrixXd::Zero(3 * (kCount + 1), 3 * (kCount + 1)), mass = stiffness;
  for (int i = 0; i < kCount; ++i) {
    const auto at = [&](int k) -> Vector2d {
      return radius_m * Vector2d(std::sin(k * step / radius_m), std::cos(k * step / radius_m));
    };
    const Vector2d along = at(i + 1) - at(i);
    const double l = along.norm();
    Eigen::Matrix<double, 6, 6> k, m, turn = Eigen::Matrix<double, 6, 6>::Identity();
    const double a = axial / l * 12.0, b = 12.0 / (l * l * l), c = 6.0 / (l * l), d = 4.0 / l, e = 2.0 / l;
    k << a, 0, 0, -a, 0, 0, 0, b, c, 0, -b, c, 0, c, d, 0, -c, e, -a, 0, 0, a, 0, 0, 0, -b, -c, 0, b, -c, 0,
        c, e, 0, -c, d;
    m << 140, 0, 0, 70, 0, 0, 0, 156, 22 * l, 0, 54, -13 * l, 0, 22 * l, 4 * l * l, 0, 13 * l, -3 * l * l, 70,
        0, 0, 140, 0, 0, 0, 54, 13 * l, 0, 156, -22 * l, 0, -13 * l, -3 * l * l, 0, -22 * l, 4 * l * l;
    m *= l / 420.0;
    const double x = along.x() / l, y = along.y() / l;
    for (const int first : {0, 3}) turn.block<2, 2>(first, first) << x, y, -y, x;
    stiffness.block<6, 6>(3 * i, 3 * i) += turn.transpose() * k * turn;
    mass.block<6, 6>(3 * i, 3 * i) += turn.transpose() * m * turn;
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(stiffness, mass, Eigen::EigenvaluesOnly);
  return std::sqrt(solver.eigenvalues()[3]);
}

TEST(ThinShell, ReleasedArcSwingsAtItsBeamFrequency) {
  EXPECT_NEAR(arc_frequency(1.0, 1e4), 4.730041 * 4.730041, 0.1);  // a straight beam's
  const double beam =
      arc_frequency(kQuarter.length_m, kQuarter.radius_m) * std::sqrt(kModulus_pa * kT * kT / 12.0 / kRho);
  const Ends ends;
  for (const double cells_t : gate_or_full<double>({5.0, 10.0}, {3.0, 5.0, 10.0})) {
    double ratios[2];
    for (const bool thin : {false, true}) {
      Stage stage;
      stage.make(describe_quarter(cells_t, 0.0, thin));
      const double gap_m = ends.gap_m(*stage.body);
      stage.forces = ends.forces(kOpened_m / ends.opening_m());
      stage.run(60.0);
      stage.forces.clear();
      Material undamped = stage.body->material();
      undamped.loss_factor = 0.0;
      stage.body->set_material(undamped);
      std::vector<double> crossings;
      double last = ends.gap_m(*stage.body) - gap_m;
      for (int i = 1; crossings.size() < 7 && i < 3000; ++i) {
        stage.frame();
        const double now = ends.gap_m(*stage.body) - gap_m;
        if ((now > 0.0) != (last > 0.0)) crossings.push_back((i - now / (now - last)) / stage.rate_hz);
        last = now;
      }
      ASSERT_EQ(crossings.size(), 7u);
      ratios[thin] = 2.0 * M_PI * 3.0 / (crossings[6] - crossings[0]) / beam;
    }
    std::printf("cells of %g t: frequency %.3f of a beam's, plain cells %.3f\n", cells_t, ratios[1],
                ratios[0]);
    // The stiffness is right (see above). Nodes are up to a cell away from the sheet and carry its mass
    // there, which adds rotational inertia.
    report_gap("thin_shell.frequency", std::abs(ratios[1] - 1.0));
    EXPECT_LT(ratios[1], 1.1) << cells_t;
    EXPECT_GT(ratios[0], 1.1) << cells_t;
  }
}

TEST(ThinShell, ScrambledArcRecovers) {
  int wound = 0;
  const int seeds = seed_count(3);
  for (int seed = 1; seed <= seeds; ++seed) {
    ElasticBodyDescription body = describe_quarter(5.0, 0.3, true);
    body.material.loss_factor = 0.2;
    body.cells.scramble = static_cast<uint64_t>(seed);
    Stage stage;
    stage.make(body);
    stage.run(60.0);  // 20 periods
    ASSERT_TRUE(all_finite(*stage.body)) << seed;
    if (rms_distance_from_rest_shape(*stage.body, body.particles) < 1e-3 * kQuarter.length_m) continue;
    ++wound;
    for (const ParticleState& p : stage.body->particles())
      ASSERT_GT(p.deformation_gradient.determinant(), 0.0) << seed;
  }
  EXPECT_LE(wound, (seeds + 29) / 30);
}

TEST(ThinShell, FlattenedArcRecovers) {
  // Flattened to a tenth of its height, to zero height, and inverted.
  for (const double height : {0.1, 0.0, -1.0}) {
    ElasticBodyDescription body = describe_quarter(5.0, 0.3, true);
    body.material.loss_factor = 0.2;
    body.initial_deformation = Vector3d(1, 1, height).asDiagonal();
    Stage stage;
    stage.make(body);
    stage.run(60.0);
    ASSERT_TRUE(all_finite(*stage.body));
    EXPECT_LT(rms_distance_from_rest_shape(*stage.body, body.particles), 1e-3 * kQuarter.length_m) << height;
  }
}

TEST(ThinShell, SpinningArcConservesMomentumAndGainsNothing) {
  ElasticBodyDescription body = describe_quarter(5.0, 0.3, true);
  body.material.loss_factor = 0.0;
  body.angular_velocity_rad_s = {1.0, 2.0, 3.0};
  body.velocity_m_s = {0.3, 0.0, 0.0};
  Stage stage;
  stage.make(body);
  const BodyEnergy before = stage.body->energy(kNoGravity);
  for (int i = 0; i < 300; ++i) {
    stage.frame();
    const BodyEnergy now = stage.body->energy(kNoGravity);
    ASSERT_NEAR((now.linear_momentum - before.linear_momentum).norm(), 0.0,
                1e-5 * before.linear_momentum.norm());
    ASSERT_NEAR((now.angular_momentum - before.angular_momentum).norm(), 0.0,
                1e-4 * before.angular_momentum.norm());
    ASSERT_LT(now.kinetic_j + now.elastic_j, 1.01 * (before.kinetic_j + before.elastic_j)) << i;
  }
}

TEST(ThinShell, ArcOfSoftMetalStaysBent) {
  double left[2];
  for (const double plasticity : {0.0, 0.995}) {
    ElasticBodyDescription body = describe_quarter(5.0, 0.3, true);
    body.material.loss_factor = 0.2;
    body.material.plasticity = plasticity;
    body.initial_deformation = Vector3d(1, 1, 0.7).asDiagonal();
    Stage stage;
    stage.make(body);
    double most_j = stage.total_energy_j();
    for (int i = 0; i < 1800; ++i) {
      stage.frame();
      const double now_j = stage.total_energy_j();
      ASSERT_LT(now_j, 1.02 * most_j) << i;
    }
    ASSERT_TRUE(all_finite(*stage.body));
    left[plasticity > 0.0] = rms_distance_from_rest_shape(*stage.body, body.particles);
  }
  EXPECT_LT(left[0], 1e-3 * kQuarter.length_m);
  EXPECT_GT(left[1], 1e-2 * kQuarter.length_m);
}

}  // namespace
}  // namespace livegs::test
