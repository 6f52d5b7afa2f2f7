// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "common/skin/kernels/rest_bodies.h"

namespace livegs {
namespace {

using namespace livegs::testing;

std::string message_of(const RestBody& rest, const ObjectDrivers& drivers) {
  const Result<void> checked = check_drivers(rest, drivers);
  return checked ? "" : checked.error().message;
}

TEST(CheckDrivers, AcceptsFittingDrivers) {
  RestBody rest = lattice_body(2, 2, 2, 0.1);
  EXPECT_TRUE(check_drivers(rest, rest_drivers(rest)));
  rest.kind = DriverKind::Particles;
  rest.particles_m = {{0, 0, 0}, {1, 0, 0}};
  EXPECT_TRUE(check_drivers(rest, rest_drivers(rest)));
  rest.kind = DriverKind::Rigid;
  rest.bodies = {Pose{}};
  ObjectDrivers drivers;
  drivers.poses = {Pose{}};
  EXPECT_TRUE(check_drivers(rest, drivers));
}

TEST(CheckDrivers, ReportsEachMismatch) {
  const RestBody rest = lattice_body(2, 2, 2, 0.1);
  ObjectDrivers drivers = rest_drivers(rest);
  drivers.object_id = 42;
  drivers.kind = DriverKind::Rigid;
  EXPECT_NE(message_of(rest, drivers).find("object 42: are rigid"), std::string::npos);
  drivers.kind = DriverKind::Lattice;
  drivers.positions_m.pop_back();
  EXPECT_NE(message_of(rest, drivers).find("26 positions instead of 27"), std::string::npos);
  drivers.positions_m.emplace_back(0.0f, NAN, 0.0f);
  EXPECT_NE(message_of(rest, drivers).find("position 26 is not finite"), std::string::npos);
  drivers.positions_m.back()[1] = 0.0f;
  drivers.poses.emplace_back();
  EXPECT_NE(message_of(rest, drivers).find("1 poses"), std::string::npos);
}

TEST(CheckDrivers, PosesAndRotationsMustBeFinite) {
  RestBody rest;
  rest.bodies = {Pose{}};
  ObjectDrivers drivers;
  drivers.poses = {Pose{}};
  drivers.poses[0].orientation.w() = INFINITY;
  EXPECT_NE(message_of(rest, drivers).find("pose 0"), std::string::npos);
  rest.kind = DriverKind::Particles;
  rest.particles_m = {{0, 0, 0}};
  drivers = rest_drivers(rest);
  drivers.rotations[0].x() = NAN;
  EXPECT_NE(message_of(rest, drivers).find("rotation 0"), std::string::npos);
}

}  // namespace
}  // namespace livegs
