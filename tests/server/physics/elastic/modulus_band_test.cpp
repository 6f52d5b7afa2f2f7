// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "geometry/surface/shape_mesh.h"
#include "physics/elastic/resolution/lattice_resolution.h"
#include "physics/elastic_body.h"
#include "scenes/elastic_bodies.h"
#include "server/physics/elastic/quarter_shell.h"

namespace livegs {
namespace {

using test::particle_grid;
using test::Vector3d;

// Mean pass compliance of a long bar `cells_across` cells wide. Node masses follow node volumes.
double mean_of_bar(int cells_across, double courant) {
  const double width = 0.025, size = cells_across * width, density = 1000.0, step = 1e-3;
  const Lattice lattice =
      build_lattice(measure_extent(particle_grid({64 * width, size, size}, width)), width, {});
  std::vector<double> inverse;
  for (const double volume : lattice.node_volumes_m3) inverse.push_back(1.0 / (density * volume));
  const double speed = courant * width / step;  // sqrt(E / rho)
  return mean_pass_compliance(lattice, inverse, density * speed * speed, step);
}

TEST(ModulusBand, MeanComplianceOfBarHasClosedForm) {
  // Along one axis of n cells each end cell has a corner of half the mass, so the mean of 1 / A0 is (2/1.5 +
  // n - 2)/n, or 1/2 for one cell. The factor occurs twice across; along the bar it is close to 1.
  const double along = (2 / 1.5 + 62.0) / 64.0;
  for (const double courant : {0.5, 1.0}) {
    const double inside = 2.0 / (courant * courant);
    EXPECT_NEAR(mean_of_bar(1, courant) / (inside * along * 0.25), 1.0, 0.01);
    EXPECT_NEAR(mean_of_bar(2, courant) / (inside * along * 4.0 / 9.0), 1.0, 0.01);
    EXPECT_NEAR(mean_of_bar(4, courant) / (inside * along * 25.0 / 36.0), 1.0, 0.01);
  }
}

TEST(ModulusBand, ThresholdsDependOnPoissonRatio) {
  EXPECT_EQ(band_of({.mean_pass_compliance = 4.01, .poisson_ratio = 0.3, .ceiling_ratio = 2}).band,
            ElasticBand::Exact);
  EXPECT_EQ(band_of({.mean_pass_compliance = 3.99, .poisson_ratio = 0.3, .ceiling_ratio = 2}).band,
            ElasticBand::Band);
  EXPECT_EQ(band_of({.mean_pass_compliance = 9.1, .poisson_ratio = 0.45, .ceiling_ratio = 2}).band,
            ElasticBand::Exact);
  EXPECT_EQ(band_of({.mean_pass_compliance = 8.9, .poisson_ratio = 0.45, .ceiling_ratio = 2}).band,
            ElasticBand::Band);
  EXPECT_EQ(band_of({.mean_pass_compliance = 46, .poisson_ratio = 0.49, .ceiling_ratio = 2}).band,
            ElasticBand::Exact);
  EXPECT_EQ(band_of({.mean_pass_compliance = 44, .poisson_ratio = 0.49, .ceiling_ratio = 2}).band,
            ElasticBand::Band);
  EXPECT_EQ(band_of({.mean_pass_compliance = 1.11, .poisson_ratio = 0.3, .ceiling_ratio = 2}).band,
            ElasticBand::Band);
  EXPECT_EQ(band_of({.mean_pass_compliance = 1.09, .poisson_ratio = 0.3, .ceiling_ratio = 0.5}).band,
            ElasticBand::Clipped);
}

TEST(ModulusBand, FewCellsAreExactInShorterSteps) {
  const auto band = [](double cells_along, double courant) {
    return band_of({.mean_pass_compliance = 8, .cells_along = cells_along, .courant = courant * 2 / 3});
  };
  for (const double cells_along : {1, 2, 3, 6}) {
    const double exact_to = 1.5 * std::sqrt(0.5 * kMaxEndExcess * cells_along);
    EXPECT_EQ(band(cells_along, exact_to - 1e-6).band, ElasticBand::Exact) << cells_along;
    EXPECT_EQ(band(cells_along, exact_to + 1e-3).band, ElasticBand::Band) << cells_along;
  }
  EXPECT_EQ(band(8, courant_limit(0.0, 4.0)).band, ElasticBand::Exact);
  EXPECT_GT(band(2, courant_limit(0.0, 4.0)).ratio_high, 1.16);  // apparent ratio of two cells
}

TEST(ModulusBand, ClippedBodyIsBetweenHalfAndFullCeiling) {
  const ModulusBand band = band_of({.mean_pass_compliance = 0.5, .poisson_ratio = 0.3, .ceiling_ratio = 0.4});
  EXPECT_DOUBLE_EQ(band.ratio_low, 0.18);
  EXPECT_DOUBLE_EQ(band.ratio_high, 0.44 * (1 + 4.5 / 16));
}

TEST(ModulusBand, ContainsEveryFigureOfThePrototype) {
  // Measured on a prototype of the solver: cells across, nu, Courant number with h, E_app / E. For BDF2 h_e
  // is 2/3 h.
  struct Row {
    int across;
    double nu, courant, ratio;
  };
  const Row rows[] = {{4, 0, .5, .999},    {4, 0, .75, 1.0},    {4, 0, 1, 1.003},    {4, 0, 1.2, 1.011},
                      {4, 0, 1.5, .964},   {4, .3, .5, .999},   {4, .3, .75, .998},  {4, .3, 1, .999},
                      {4, .3, 1.2, .982},  {4, .3, 1.5, .885},  {4, .45, .5, .998},  {4, .45, .75, .989},
                      {4, .45, 1, .955},   {4, .45, 1.2, .917}, {4, .45, 1.5, .83},  {8, .3, .5, .999},
                      {8, .3, 1, .972},    {8, .45, .5, .999},  {8, .45, .75, .985}, {2, .3, .25, .999},
                      {2, .3, .5, 1.003},  {2, .3, .75, 1.022}, {2, .3, 1, 1.078},   {2, .3, 1.2, 1.09},
                      {2, .45, .5, 1.003}, {2, .45, .75, .998}, {1, .3, .25, 1.0},   {1, .3, .5, 1.018},
                      {1, .3, .75, 1.13},  {1, .3, 1, 1.39},    {1, .45, .5, 1.01},  {1, .45, .75, 1.028}};
  for (const Row& row : rows) {
    const double y = mean_of_bar(row.across, row.courant * 2 / 3);
    if (y < 1.1) continue;
    const ModulusBand band = band_of({.mean_pass_compliance = y,
                                      .poisson_ratio = row.nu,
                                      .cells_across = 1.0 * row.across,
                                      .cells_along = 64,
                                      .courant = row.courant * 2 / 3});
    EXPECT_LE(band.ratio_low, row.ratio) << row.across << " across, nu " << row.nu << ", Co " << row.courant;
    EXPECT_GE(band.ratio_high, row.ratio) << row.across << " across, nu " << row.nu << ", Co " << row.courant;
    EXPECT_GE(band.ratio_low, 0.79);  // the band must also be narrow
    EXPECT_LE(band.ratio_high, 2.3);
  }
}

TEST(ModulusBand, ContainsMeasuredRatiosOfThisSolver) {
  // Tension at nu 0 with given cells: cells across, Courant number, E_app / E as measured by accuracy_test.
  struct Row {
    int across;
    double courant, ratio;
  };
  for (const Row& row : {Row{4, 0.6, 1.005}, Row{4, 0.75, 1.015}, Row{4, 0.9, 1.034}, Row{4, 1.05, 1.069},
                         Row{4, 1.2, 1.138}, Row{4, 1.35, 1.371}, Row{2, 0.6, 1.011}, Row{2, 0.75, 1.030},
                         Row{2, 0.9, 1.068}, Row{2, 1.05, 1.143}}) {
    const ModulusBand band = band_of({.mean_pass_compliance = mean_of_bar(row.across, row.courant * 2 / 3),
                                      .cells_across = 1.0 * row.across,
                                      .cells_along = 64,
                                      .courant = row.courant * 2 / 3,
                                      .ceiling_ratio = 2.0});
    EXPECT_LE(band.ratio_low, row.ratio) << row.across << " across, Co " << row.courant;
    EXPECT_GE(band.ratio_high, row.ratio) << row.across << " across, Co " << row.courant;
  }
}

// The bending stiffness of a curved shell thinner than half its cells is off; that of a flat plate along the
// cells is right.
TEST(ModulusBand, CurvedThinShellsAreNotReportedAsExact) {
  ElasticBodyDescription plate = test::describe(sample_particles(box_mesh({0.5, 0.01, 0.5})), 1e6, 0.3);
  for (const auto& [body, thin] : {std::pair{test::describe_quarter(10, 0.3, true), true}, {plate, false}}) {
    const auto made = make_elastic_body(body, 60, 4, false);
    ASSERT_TRUE(made) << made.error().message;
    const ElasticAccuracy accuracy = (*made)->accuracy();
    EXPECT_EQ(accuracy.thin_part > kMaxThinPart, thin) << accuracy.thin_part;
    EXPECT_EQ(accuracy.band == ElasticBand::Exact, !thin) << name_of(accuracy.band);
    if (thin) {
      EXPECT_LE(accuracy.modulus_ratio_low, kThinBendsFrom);
      EXPECT_GE(accuracy.modulus_ratio_high, kThinBendsTo);
    }
  }
}

TEST(ModulusBand, CeilingHasItsClosedForm) {
  // For one cell: 4.15 rho a² / h² * 1/8.
  const Lattice lattice = build_lattice(measure_extent(particle_grid(Vector3d::Constant(0.1), 0.1)), 0.1, {});
  EXPECT_NEAR(modulus_ceiling_pa(lattice, 1000, 0.01), 4.15 * 1000 * 100 / 8, 1e-6);
}

}  // namespace
}  // namespace livegs
