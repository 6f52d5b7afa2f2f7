// SPDX-License-Identifier: Apache-2.0
// Grabs of fragments: the nearest fragment is held, weighed and reported, also with a gap between it and the
// hand.
#include <algorithm>
#include <limits>

#include "geometry/mesh/triangle_distance.h"
#include "scenes/break_fixtures.h"

namespace livegs {
namespace {

using namespace break_fixtures;

// A spinning cup whose fragments have separated for 0.1 s.
World burst_cup(double rate, uint64_t seed, const std::shared_ptr<const BreakablePieces>& pieces) {
  RigidBodyDescription cup = cup_at(0.0);
  cup.world_from_object.orientation = rotation_about(static_cast<int>(seed));
  cup.angular_velocity_rad_s = {3, 15, -6};
  World world = with_cup(cup, world_at(rate, 4, Vector3d::Zero()), pieces);
  EXPECT_TRUE(world.break_object(kCup, {0.038, 0.05, 0}));
  run_seconds(world, 0.1);
  return world;
}

// Distances from a point to the surface of each body, computed from its triangles.
std::vector<double> distances_m(const World& world, const BreakablePieces& pieces, const Vector3d& point_m) {
  std::vector<double> least(body_count(world, kCup), std::numeric_limits<double>::max());
  const std::vector<BodyState> bodies = world.bodies();
  const RestBody rest = world.rest_body(kCup);
  for (size_t p = 0; p < pieces.cut.pieces.size(); ++p) {
    const uint32_t body = world.piece_bodies(kCup)[p];
    const Vector3d local = bodies[body].world_from_body.inverse() * point_m + rest.bodies[body].position_m;
    const TriangleMesh& mesh = pieces.cut.pieces[p].mesh;
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vector3d on =
          closest_point_on_triangle(local, mesh.vertices_m[a], mesh.vertices_m[b], mesh.vertices_m[c]);
      least[body] = std::min(least[body], (on - local).norm());
    }
  }
  return least;
}

// Places `apart_m` away from points on the outside of some fragments.
std::vector<Vector3d> places_beside(const World& world, const BreakablePieces& pieces, double apart_m) {
  std::vector<Vector3d> places;
  for (size_t p = 0; p < pieces.cut.pieces.size(); p += 3) {
    const VoronoiPiece& piece = pieces.cut.pieces[p];
    const Vector3d surface =
        world.world_point(kCup, piece.mesh.vertices_m[0] * 0.999 + piece.mass.centre_of_mass_m * 0.001);
    places.push_back(surface + apart_m * rotation_about(static_cast<int>(p)).toRotationMatrix().col(1));
  }
  return places;
}

// Index of the body that the hand moves.
uint32_t held_by(World& world, const Pose& hand) {
  const std::vector<BodyState> before = world.bodies();
  world.move_grab(1, {hand.position_m + Vector3d(0, 0.05, 0), hand.orientation}, Vector3d::Zero(),
                  Vector3d::Zero());
  world.step();
  const std::vector<BodyState> after = world.bodies();
  uint32_t moved = 0;
  double most = 0.0;
  for (size_t i = 0; i < after.size(); ++i) {
    const double change = (after[i].velocity_m_s - before[i].velocity_m_s).norm();
    if (change > most) most = change, moved = after[i].body_index;
  }
  return moved;
}

struct Taken {
  int grabs = 0, wrong_held = 0, misreported = 0;
};

// Grabs the fragment at `place_m`, then breaks it further while it is held.
void take(World& world, const BreakablePieces& pieces, const Vector3d& place_m, Taken& taken) {
  const Pose hand{place_m, Eigen::Quaterniond::Identity()};
  const std::vector<double> apart = distances_m(world, pieces, place_m);
  const double least = *std::min_element(apart.begin(), apart.end());
  const auto met = world.nearest(place_m, 0.1);
  ASSERT_TRUE(met && met->piece);
  if (met->distance_m > 0.0) {
    EXPECT_NEAR(met->distance_m, least, 1e-9);
  } else {
    EXPECT_LT(least, 0.0026) << "the point is not within a 5 mm wall or bottom";
  }
  ASSERT_TRUE(world.grab(1, kCup, hand, {}));
  EXPECT_LT((world.grab_state(1)->point_m - place_m).norm(), 1e-9);
  const uint32_t piece = *world.grab_state(1)->piece;
  const double weighed_kg = world.mass_at_kg(kCup, met->rest_point_m, met->piece);
  const uint32_t held = held_by(world, hand);
  ++taken.grabs;
  taken.wrong_held += apart[held] > least + 1e-3;
  const auto misreports = [&](uint32_t body) {
    return world.piece_bodies(kCup)[piece] != body || world.grab_state(1)->piece != piece;
  };
  taken.misreported +=
      met->piece != piece || misreports(held) || std::abs(weighed_kg - world.bodies()[held].mass_kg) > 1e-12;
  const Vector3d struck = pieces.cut.pieces[piece].mesh.vertices_m[0] * 0.99 +
                          pieces.cut.pieces[piece].mass.centre_of_mass_m * 0.01;
  if (!world.break_object(kCup, struck)) return;  // a single piece
  taken.misreported += misreports(held_by(world, hand));
}

TEST(BreakingHands, NearestFragmentIsHeldWeighedAndReported) {
  Taken taken;
  for (const double rate : kRates_hz)
    for (int run = 1; run <= seed_count(6); ++run) {
      const auto seed = static_cast<uint64_t>(run);
      const auto pieces = pieces_of(small_cup(), 8 + seed % 9, seed);
      for (const double apart_m : {0.0, 0.01, 0.03, 0.08}) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed << ", " << apart_m << " m");
        World world = burst_cup(rate, seed, pieces);
        const std::vector<Vector3d> places = places_beside(world, *pieces, apart_m);
        take(world, *pieces, places[seed % places.size()], taken);
      }
    }
  EXPECT_EQ(taken.wrong_held, 0) << "of " << taken.grabs;
  EXPECT_EQ(taken.misreported, 0);
}

// A hand next to an intact cup holds the nearest piece after the cup breaks.
TEST(BreakingHands, HandKeepsNearestPieceOfABreakingCup) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    const auto pieces = pieces_of(small_cup(), 16, seed);
    World world = with_cup(cup_at(0.0), world_at(90, 4, Vector3d::Zero()), pieces);
    const Pose hand{rotation_about(static_cast<int>(seed)) * Vector3d(0.06, 0, 0) + Vector3d(0, 0.05, 0),
                    Eigen::Quaterniond::Identity()};
    ASSERT_TRUE(world.grab(1, kCup, hand, {}));
    EXPECT_FALSE(world.grab_state(1)->piece);
    ASSERT_TRUE(world.break_object(kCup, {0.038, 0.05, 0}));
    const std::vector<double> apart = distances_m(world, *pieces, hand.position_m);
    ASSERT_TRUE(world.grab_state(1)->piece);
    const uint32_t held = world.piece_bodies(kCup)[*world.grab_state(1)->piece];
    EXPECT_LT(apart[held], *std::min_element(apart.begin(), apart.end()) + 1e-9);
    EXPECT_LT((world.grab_state(1)->point_m - hand.position_m).norm(), 1e-9);
  }
}

// The reported piece belongs to the fragment that the ray hits, also where fragments overlap.
TEST(BreakingHands, RayReportsTheHitPiece) {
  const auto pieces = pieces_of(small_cup(), 16, 3);
  World world = burst_cup(90, 3, pieces);
  int met = 0;
  for (const BodyState& body : world.bodies()) {
    const Vector3d from(0, 0.05, 0.6);
    const Vector3d way = (body.world_from_body.position_m - from).normalized();
    const auto hit = world.ray_cast(from, way, 2.0);
    if (!hit) continue;
    ++met;
    ASSERT_TRUE(hit->piece);
    const std::vector<double> apart = distances_m(world, *pieces, from + hit->distance_m * way);
    EXPECT_LT(apart[world.piece_bodies(kCup)[*hit->piece]], 1e-9);
    EXPECT_LT((world.world_point(kCup, hit->rest_point_m, hit->piece) - from - hit->distance_m * way).norm(),
              1e-4);
  }
  EXPECT_GT(met, 3);
}

}  // namespace
}  // namespace livegs
