// SPDX-License-Identifier: Apache-2.0
// The return mapping on single matrices, against closed forms.
#include "physics/material/return_mapping.h"
#include "known_gaps.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Matrix3d kIdentity = Matrix3d::Identity();

Matrix3d diagonal(double x, double y, double z) { return Vector3d(x, y, z).asDiagonal(); }
Matrix3d deviator(const Matrix3d& m) { return m - m.trace() / 3.0 * kIdentity; }

Matrix3d stretch_of(const Matrix3d& f) {
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(f.transpose() * f).operatorSqrt();
}

// The strain that the yield surface bounds, as defined in the header.
double strain(const Matrix3d& f, const Matrix3d& d) { return deviator(stretch_of(f) - d).norm(); }

// A cell under deformations F of its rest shape.
struct Cell {
  YieldSurface surface;
  Matrix3d plastic_part = kIdentity;
  double work = 0.0;

  bool deform(const Matrix3d& f) {
    const PlasticFlow flow = flow_plastically(surface, f * plastic_part.inverse(), plastic_part);
    plastic_part = flow.plastic_part;
    work += flow.work;
    return flow.flowed;
  }
};

double bisect(double low, double high, const std::function<double(double)>& rising) {
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (rising(middle) < 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// Force on the sides of a bar over 2 mu and the section. The bar has length l, width b and plastic part
// diag(d, s, s): W = mu |F - D|² + lambda/2 (det F - 1)².
double side_force(double nu, double l, double b, const Matrix3d& d) {
  return b - d(1, 1) + nu / (1.0 - 2.0 * nu) * (l * b * b - 1.0) * l * b;
}

// Pulls a bar with free sides to `length`. Its width balances the side forces after the flow.
void pull(Cell& cell, double nu, double length) {
  const double width = bisect(0.2, 1.2, [&](double b) {
    Cell tried = cell;
    tried.deform(diagonal(length, b, b));
    return side_force(nu, length, b, tried.plastic_part);
  });
  cell.deform(diagonal(length, width, width));
}

// --- the yield surface ---

TEST(YieldSurface, RadiusIsTheStrainOfSimpleTension) {
  // nu = 0: the sides do not move, so the strain is the deviator of diag(1 + y, 1, 1).
  for (const double p : {0.0, 0.5, 0.9, 1.0}) {
    const double y = 1.0 - p;
    EXPECT_NEAR(yield_surface(p, 0.0).radius, std::sqrt(2.0 / 3.0) * y, 1e-15);
    EXPECT_EQ(yield_surface(p, 0.0).limit, p);
  }
  // Small strains: the deviator of diag(1, -nu, -nu) y; the remainder is of order y².
  for (const double nu : {0.3, 0.45}) {
    EXPECT_NEAR(yield_surface(1.0 - 1e-6, nu).radius / (std::sqrt(2.0 / 3.0) * (1.0 + nu) * 1e-6), 1.0, 1e-5);
  }
}

TEST(YieldSurface, BarYieldsAtOneMinusPForAnyPoissonRatio) {
  for (const double nu : {0.0, 0.2, 0.3, 0.45, 0.49}) {
    for (const double p : {0.2, 0.5, 0.9, 0.99}) {
      for (const double part : {1.0 - 1e-6, 1.0 + 1e-6}) {
        Cell bar{yield_surface(p, nu)};
        const double length = 1.0 + part * (1.0 - p);
        const double width = bisect(0.2, 1.2, [&](double b) { return side_force(nu, length, b, kIdentity); });
        EXPECT_EQ(bar.deform(diagonal(length, width, width)), part > 1.0) << nu << " " << p;
      }
    }
  }
}

// --- simple tension to twice the yield and back ---

TEST(PlasticFlow, BarSetsAtStrainMinusYield) {
  for (const double y : {0.02, 0.05, 0.1}) {
    for (const double nu : {0.0, 0.3, 0.45}) {
      Cell bar{yield_surface(1.0 - y, nu)};
      for (int i = 1; i <= 50; ++i) pull(bar, nu, 1.0 + 2.0 * y * i / 50);
      const double set = bar.plastic_part(0, 0) - 1.0;
      // nu = 0: the sides follow the plastic part, so l - 1 - set = y to rounding. Otherwise the volume term
      // resists a bar whose set is smaller across than along. The effect grows with the set and exceeds 2 %
      // at y = 0.1.
      if (nu > 0.0 && y > 0.09) {
        report_gap("plastic.bar_set", std::abs(set / y - 1.0));
      } else {
        EXPECT_NEAR(set / y, 1.0, nu == 0.0 ? 1e-12 : 0.02) << y << " " << nu;
      }
      EXPECT_NEAR(bar.plastic_part(1, 1), 1.0 / std::sqrt(1.0 + set), 1e-12);
    }
  }
}

TEST(PlasticFlow, BarSetsInCompression) {
  // nu = 0: l - b - (d - s) = -y with b = s, as in tension.
  Cell bar{yield_surface(0.9, 0.0)};
  for (int i = 1; i <= 50; ++i) pull(bar, 0.0, 1.0 - 0.2 * i / 50);
  EXPECT_NEAR(bar.plastic_part(0, 0), 0.9, 1e-12);
}

TEST(PlasticFlow, WorkIsYieldStressTimesSet) {
  // nu = 0: the yield stress E y over 2 mu = E is y, so the work over mu V is 2 y set. The volume part of the
  // flow, set²/2 of it, is omitted.
  const double y = 0.02;
  Cell bar{yield_surface(1.0 - y, 0.0)};
  for (int i = 1; i <= 400; ++i) pull(bar, 0.0, 1.0 + 2.0 * y * i / 400);
  EXPECT_NEAR(bar.work / (2.0 * y * y), 1.0, 0.01);
}

// --- shear ---

TEST(PlasticFlow, ShearFlowsByTheExcessStretch) {
  const Matrix3d turn = Eigen::AngleAxisd(1.1, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  const Matrix3d stretch = turn * diagonal(1.5, 1.0 / 1.5, 1.0) * turn.transpose();
  Cell cell{yield_surface(0.8, 0.3)};
  EXPECT_TRUE(cell.deform(stretch));
  const Matrix3d all = deviator(stretch);
  EXPECT_NEAR((deviator(cell.plastic_part) - (1.0 - cell.surface.radius / all.norm()) * all).norm(), 0.0,
              1e-14);
}

TEST(PlasticFlow, RotationCausesNoStrain) {
  Matrix3d f;
  f << 1.2, 0.3, 0, 0, 0.9, 0.1, -0.1, 0, 1.0;
  const Matrix3d turn = Eigen::AngleAxisd(2.0, Vector3d(1, 1, -1).normalized()).toRotationMatrix();
  Cell still{yield_surface(0.9, 0.3)}, turned = still;
  still.deform(f);
  turned.deform(turn * f);
  EXPECT_NEAR((still.plastic_part - turned.plastic_part).norm(), 0.0, 1e-14);
  // Rotating the material rotates its plastic part.
  Cell other{still.surface};
  other.deform(f * turn.transpose());
  EXPECT_NEAR((other.plastic_part - turn * still.plastic_part * turn.transpose()).norm(), 0.0, 1e-13);
}

// --- volume ---

TEST(PlasticFlow, PressureDoesNotAffectFlow) {
  for (const double p : {0.1, 0.9, 1.0}) {
    Cell cell{yield_surface(p, 0.3)};
    for (double size = 3.0; size > 0.47; size *= 0.97) EXPECT_FALSE(cell.deform(size * kIdentity));
    EXPECT_EQ(cell.plastic_part, kIdentity);
  }
  // The strain of diag(k + s, k - s, k) is s sqrt(2) at any k.
  const YieldSurface surface = yield_surface(0.9, 0.3);
  for (const double size : {0.6, 1.0, 2.0}) {
    for (const double part : {1.0 - 1e-9, 1.0 + 1e-9}) {
      Cell cell{surface};
      const double s = part * surface.radius / std::sqrt(2.0);
      EXPECT_EQ(cell.deform(diagonal(size + s, size - s, size)), part > 1.0);
    }
  }
}

// --- steps ---

TEST(PlasticFlow, TenIncrementsFlowAsFarAsAThousand) {
  Matrix3d direction;
  direction << 0.5, 0.2, -0.1, 0.2, -0.3, 0.15, -0.1, 0.15, -0.1;
  for (const double p : {0.7, 0.9, 1.0}) {
    const auto loaded = [&](int increments) {
      Cell cell{yield_surface(p, 0.3)};
      for (int i = 1; i <= increments; ++i) {
        cell.deform(kIdentity + direction * i / increments);
      }
      return cell.plastic_part;
    };
    const Matrix3d once = loaded(1), ten = loaded(10), thousand = loaded(1000);
    EXPECT_GT((once - kIdentity).norm(), 0.05);
    // Radial return along a straight path is exact; only a thousand roundings are left.
    EXPECT_NEAR((ten - thousand).norm(), 0.0, 1e-9);
    EXPECT_NEAR((once - thousand).norm(), 0.0, 1e-9);
  }
}

TEST(PlasticFlow, HoldingDoesNotCreep) {
  Matrix3d f;
  f << 1.3, 0.2, 0, 0.1, 0.9, 0.1, 0, 0, 1.0;
  Cell cell{yield_surface(0.85, 0.3)};
  EXPECT_TRUE(cell.deform(f));
  const Matrix3d after = cell.plastic_part;
  const double work = cell.work;
  for (int i = 0; i < 1000; ++i) cell.deform(f);
  EXPECT_NEAR((cell.plastic_part - after).norm(), 0.0, 1e-12);
  EXPECT_NEAR(cell.work, work, 1e-12);
}

// --- limits ---

TEST(PlasticFlow, StopsAtTheLimitAndIsElasticBeyond) {
  for (const double p : {0.3, 0.8}) {
    Cell cell{yield_surface(p, 0.3)};
    EXPECT_TRUE(cell.deform(diagonal(4.0, 0.5, 0.5)));
    EXPECT_NEAR((cell.plastic_part - kIdentity).norm(), p, 1e-12);
    const Matrix3d at_limit = cell.plastic_part;
    EXPECT_FALSE(cell.deform(diagonal(5.0, 0.45, 0.45)));
    EXPECT_EQ(cell.plastic_part, at_limit);
    EXPECT_GT(strain(diagonal(5.0, 0.45, 0.45), at_limit), cell.surface.radius);
    // The flow reverses and continues to the other side.
    EXPECT_TRUE(cell.deform(diagonal(0.3, 1.8, 1.8)));
    EXPECT_LT(cell.plastic_part(0, 0), 1.0);
  }
}

TEST(PlasticFlow, NothingFlowsWithoutPlasticityOrShape) {
  const double nan = std::nan(""), infinite = std::numeric_limits<double>::infinity();
  Cell hard{yield_surface(0.0, 0.3)};
  EXPECT_FALSE(hard.deform(diagonal(9.0, 0.5, 0.4)));
  EXPECT_EQ(yield_surface(nan, 0.3).limit > 0.0, false);
  Cell cell{yield_surface(0.9, 0.3)};
  cell.deform(diagonal(1.3, 0.9, 0.9));
  const Matrix3d before = cell.plastic_part;
  for (const Matrix3d& f :
       {diagonal(-1.4, 1, 1), diagonal(2, 2, -1), Matrix3d(-kIdentity), Matrix3d(Matrix3d::Zero()),
        diagonal(2, 1, 0), diagonal(0.3, 0.5, 0.6), diagonal(3, 3, 0.01), diagonal(nan, 1, 1),
        diagonal(infinite, 1, 1), diagonal(1e200, 1e200, 1e200), diagonal(1e5, 1, 1)}) {
    const PlasticFlow flow = flow_plastically(cell.surface, f, cell.plastic_part);
    EXPECT_FALSE(flow.flowed) << f;
    EXPECT_EQ(flow.plastic_part, before);
    EXPECT_EQ(flow.work, 0.0);
  }
}

TEST(PlasticFlow, KeepsItsInvariantsOnRandomPaths) {
  for (const double p : {0.1, 0.5, 0.95, 1.0}) {
    std::mt19937_64 random(11);
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53 - 0.5; };
    Cell cell{yield_surface(p, 0.4)};
    Matrix3d f = kIdentity;
    int flows = 0, shapeless = 0;
    for (int i = 0; i < 10000; ++i) {
      // A random walk that is pulled towards rest, jumps at times and passes through inverted shapes.
      for (int k = 0; k < 9; ++k) f(k) += (i % 100 == 0 ? 2.0 : 0.3) * unit();
      f += 0.05 * (kIdentity - f);
      const Matrix3d before = cell.plastic_part;
      const double trial = f.determinant() > 0.0 ? strain(f, before) : 0.0, work = cell.work;
      const bool flowed = cell.deform(f);
      const Matrix3d& d = cell.plastic_part;
      ASSERT_EQ(d, Matrix3d(d.transpose()));
      ASSERT_NEAR(d.determinant(), 1.0, 1e-12);
      ASSERT_GT(Eigen::SelfAdjointEigenSolver<Matrix3d>(d).eigenvalues()[0], 0.0);
      ASSERT_LE((d - kIdentity).norm(), p + 1e-12);
      ASSERT_GE(cell.work, work);
      flows += flowed;
      if ((f * before.inverse()).determinant() <= 0.1) {
        ++shapeless;
        ASSERT_EQ(d, before);
        continue;
      }
      const double after = strain(f, d);
      if (!flowed) {
        ASSERT_EQ(d, before);
        const bool at_limit = (d - kIdentity).norm() > p - 1e-9;
        ASSERT_TRUE(after <= cell.surface.radius + 1e-9 || at_limit) << i;
      } else {
        ASSERT_LT(after, trial);
        // On the surface, unless at the limit. Strains are of order 1. The smallest eigenvalue of the
        // stretch, about 0.1, is computed from its square.
        if ((d - kIdentity).norm() < p - 1e-9) {
          ASSERT_NEAR(after, cell.surface.radius, 1e-11) << i;
        }
      }
    }
    EXPECT_GT(flows, 500);
    EXPECT_GT(shapeless, 100);
  }
}

}  // namespace
}  // namespace livegs
