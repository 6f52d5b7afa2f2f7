// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid/contact/contact_lanes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "physics/rigid/contact/contact_friction.h"
#include "physics/rigid/contact/contact_point.h"
#include "physics/rigid/rigid_body.h"

namespace livegs {
namespace {

constexpr int kLanes = 4;
using Wide = double __attribute__((vector_size(32)));  // one value of four contacts
using WideMask = int64_t __attribute__((vector_size(32)));

struct Wide3 {
  Wide x, y, z;
};

inline Wide all(double value) { return Wide{value, value, value, value}; }
inline Wide3 operator+(const Wide3& a, const Wide3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Wide3 operator-(const Wide3& a, const Wide3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Wide3 operator*(const Wide& s, const Wide3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Wide dot(const Wide3& a, const Wide3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Wide3 cross(const Wide3& a, const Wide3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Wide larger(const Wide& a, const Wide& b) { return a > b ? a : b; }
inline Wide inverse_or_zero(const Wide& a) { return a > 0.0 ? 1.0 / a : all(0.0); }
inline bool any(const WideMask& mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }
inline void set(Wide3& lanes, int lane, const Eigen::Vector3d& value) {
  lanes.x[lane] = value.x(), lanes.y[lane] = value.y(), lanes.z[lane] = value.z();
}
inline Eigen::Vector3d get(const Wide3& lanes, int lane) {
  return {lanes.x[lane], lanes.y[lane], lanes.z[lane]};
}

// Four rows of four values, one row a body, to four values of four bodies, or back.
inline void transpose(Wide& a, Wide& b, Wide& c, Wide& d) {
  const Wide even_ab = __builtin_shufflevector(a, b, 0, 4, 2, 6);
  const Wide odd_ab = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Wide even_cd = __builtin_shufflevector(c, d, 0, 4, 2, 6);
  const Wide odd_cd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  a = __builtin_shufflevector(even_ab, even_cd, 0, 1, 4, 5);
  b = __builtin_shufflevector(odd_ab, odd_cd, 0, 1, 4, 5);
  c = __builtin_shufflevector(even_ab, even_cd, 2, 3, 6, 7);
  d = __builtin_shufflevector(odd_ab, odd_cd, 2, 3, 6, 7);
}

// A symmetric matrix of each lane.
struct WideInertia {
  Wide xx, xy, xz, yy, yz, zz;
  Wide3 operator*(const Wide3& a) const {
    return {xx * a.x + xy * a.y + xz * a.z, xy * a.x + yy * a.y + yz * a.z, xz * a.x + yz * a.y + zz * a.z};
  }
};

// Response of two bodies to an impulse along one direction at one point, as ContactRow.
struct RowLanes {
  Wide3 lever_a, lever_b;  // arm x direction
  Wide3 turn_a, turn_b;    // inverse inertia times lever
};

struct PointLanes {
  Wide3 normal, arm_a_m, arm_body_m;
  WideMask turns;  // the arm turns with the first body
  RowLanes row;
  Wide mass_kg;
  Wide separation_m;
  Wide impulse_n_s, counted_n_s;  // counted: in the angular momentum
  // Towards the surface, by gravity and forces; closing speed from which a contact is an impact.
  Wide acceleration_m_s2, impact_speed_m_s, restitution_speed_m_s;
};

}  // namespace

template <>
struct FrictionMath<Wide> {
  static bool every(const WideMask& mask) { return (mask[0] & mask[1] & mask[2] & mask[3]) != 0; }
  static Wide root(Wide a) {
    for (int i = 0; i < kLanes; ++i) a[i] = std::sqrt(a[i]);
    return a;
  }
  static Wide size(const Wide& a) { return a > 0.0 ? a : -a; }
};

// The velocities of a body, and the angular momentum that impulses have given it since store_motion.
struct ContactLanes::Motion {
  Wide velocity;  // x, y, z, inverse mass
  Wide spin;      // x, y, z, 0
  Wide momentum;  // x, y, z, 0
};

struct ContactLanes::BodyPose {
  Wide inertia[3];  // inverse: xx, xy, xz, px; yy, yz, zz, py; 0, 0, 0, pz, with the position p
  Wide turn[3];     // columns of the rotation, 0
};

struct ContactLanes::Batch {
  std::array<uint32_t, kLanes> a{}, b{};  // slots of bodies
  std::array<uint32_t, kLanes> contact{};
  int count = 0, points = 0;

  PointLanes point[kMaxManifoldPoints];
  // Friction acts at the mean of the points, along two tangents, and about the normal.
  Wide3 normal, tangent, bitangent, arm_a_m, arm_body_m;
  WideMask turns;
  RowLanes along, across;
  Wide3 twist_turn_a, twist_turn_b;
  ContactFriction<Wide> friction;
  InPlane<Wide> friction_counted;
  Wide push_speed_m_s;
};

namespace {

// The motion of the four first or second bodies of a batch.
struct MotionLanes {
  Wide3 velocity, spin;
  Wide inverse_mass;

  void push(const Wide& impulse, const Wide3& direction, const Wide3& turn) {
    velocity = velocity + (impulse * inverse_mass) * direction;
    spin = spin + impulse * turn;
  }
};

template <typename Motion>
inline MotionLanes gather(const std::vector<Motion>& from, const std::array<uint32_t, kLanes>& slots) {
  Wide v0 = from[slots[0]].velocity, v1 = from[slots[1]].velocity, v2 = from[slots[2]].velocity,
       v3 = from[slots[3]].velocity;
  transpose(v0, v1, v2, v3);
  Wide s0 = from[slots[0]].spin, s1 = from[slots[1]].spin, s2 = from[slots[2]].spin, s3 = from[slots[3]].spin;
  transpose(s0, s1, s2, s3);
  return {{v0, v1, v2}, {s0, s1, s2}, v3};
}

template <typename Motion>
inline void scatter(const MotionLanes& motion, std::vector<Motion>& to,
                    const std::array<uint32_t, kLanes>& slots) {
  Wide v0 = motion.velocity.x, v1 = motion.velocity.y, v2 = motion.velocity.z, v3 = motion.inverse_mass;
  transpose(v0, v1, v2, v3);
  to[slots[0]].velocity = v0, to[slots[1]].velocity = v1, to[slots[2]].velocity = v2,
  to[slots[3]].velocity = v3;
  Wide s0 = motion.spin.x, s1 = motion.spin.y, s2 = motion.spin.z, s3 = all(0.0);
  transpose(s0, s1, s2, s3);
  to[slots[0]].spin = s0, to[slots[1]].spin = s1, to[slots[2]].spin = s2, to[slots[3]].spin = s3;
}

// Separating speed along a row.
inline Wide speed_along(const MotionLanes& a, const MotionLanes& b, const Wide3& direction,
                        const RowLanes& row) {
  return dot(direction, a.velocity - b.velocity) + dot(row.lever_a, a.spin) - dot(row.lever_b, b.spin);
}

inline void apply(MotionLanes& a, MotionLanes& b, const Wide3& direction, const RowLanes& row,
                  const Wide& impulse) {
  a.push(impulse, direction, row.turn_a);
  b.push(-impulse, direction, row.turn_b);
}

template <typename Batch>
inline void apply_friction(MotionLanes& a, MotionLanes& b, const Batch& batch, const InPlane<Wide>& impulse) {
  apply(a, b, batch.tangent, batch.along, impulse.x);
  apply(a, b, batch.bitangent, batch.across, impulse.y);
  a.spin = a.spin + impulse.turn * batch.twist_turn_a;
  b.spin = b.spin - impulse.turn * batch.twist_turn_b;
}

// Deviation of a rotating point from its straight path in a step, along the normal. Without it, the next
// facets of a rolling body would be stopped before they land, and a body pivoting on a corner would rise.
inline Wide way_off_line_m(const MotionLanes& a, const PointLanes& point, double step_s) {
  const Wide3& w = a.spin;
  const Wide inward =
      dot(point.normal, w) * dot(w, point.arm_a_m) - dot(point.normal, point.arm_a_m) * dot(w, w);
  return point.turns ? 0.5 * step_s * step_s * inward : all(0.0);
}

}  // namespace

template <typename Each>
void ContactLanes::for_contacts(const Each& each) const {
  for (const Batch& batch : batches_) {
    for (int lane = 0; lane < batch.count; ++lane) {
      each(island_.contacts[batch.contact[static_cast<size_t>(lane)]], batch, lane);
    }
  }
}

ContactLanes::ContactLanes(const RigidIsland& island, double step_s)
    : island_(island), step_s_(step_s), soft_(contact_softness(step_s)) {
  spare_batches().swap(batches_);
  schedule();
  read_manifolds();
  motion_.resize(bodies_.size());
  poses_.resize(bodies_.size());
  for (Motion& motion : motion_) motion.velocity = motion.spin = motion.momentum = all(0.0);
  for (BodyPose& pose : poses_) {
    for (Wide& row : pose.inertia) row = all(0.0);
    for (Wide& row : pose.turn) row = all(0.0);
  }
}

ContactLanes::~ContactLanes() { spare_batches().swap(batches_); }

// Memory that a thread uses again: it is too large to be taken from the system for each substep.
std::vector<ContactLanes::Batch>& ContactLanes::spare_batches() {
  thread_local std::vector<Batch> spare;
  return spare;
}

// Each contact goes to the first batch with room after the last one of its bodies.
void ContactLanes::schedule() {
  bodies_.push_back(nullptr);
  for (RigidBody* body : island_.bodies) {
    body->slot = static_cast<uint32_t>(bodies_.size());
    bodies_.push_back(body);
  }
  std::unordered_map<const RigidBody*, uint32_t> sleepers;
  const auto slot_of = [&](RigidBody* body) {
    if (!body) return uint32_t{0};
    if (!body->asleep) return body->slot;
    const auto [found, added] = sleepers.try_emplace(body, static_cast<uint32_t>(bodies_.size()));
    if (added) bodies_.push_back(body);
    return found->second;
  };
  std::vector<uint32_t> next(island_.bodies.size() + 1, 0);  // of each awake body, the first free batch
  std::vector<uint32_t> open;  // open[i]: the first batch from i on that may have room
  const auto first_open = [&](uint32_t from) {
    while (from < open.size() && open[from] != from) {
      if (open[from] < open.size()) open[from] = open[open[from]];
      from = open[from];
    }
    return from;
  };
  for (Batch& batch : batches_) batch.count = batch.points = 0;
  for (size_t i = 0; i < island_.contacts.size(); ++i) {
    const RigidIsland::Contact& contact = island_.contacts[i];
    const uint32_t a = slot_of(contact.owner), b = slot_of(contact.manifold->other);
    const auto moves = [&](uint32_t slot) { return slot > 0 && slot < next.size(); };
    const uint32_t at = first_open(std::max(moves(a) ? next[a] : 0, moves(b) ? next[b] : 0));
    if (at == open.size()) {
      open.push_back(at);
      if (at == batches_.size()) batches_.emplace_back();
    }
    Batch& batch = batches_[at];
    const auto lane = static_cast<size_t>(batch.count++);
    if (batch.count == kLanes) open[at] = at + 1;
    if (moves(a)) next[a] = at + 1;
    if (moves(b)) next[b] = at + 1;
    batch.a[lane] = a;
    batch.b[lane] = b;
    batch.contact[lane] = static_cast<uint32_t>(i);
    batch.points = std::max(batch.points, contact.manifold->point_count);
  }
  batches_.resize(open.size());
  for (Batch& batch : batches_) {
    for (auto lane = static_cast<size_t>(batch.count); lane < kLanes; ++lane)
      batch.a[lane] = batch.b[lane] = 0;
  }
}

void ContactLanes::read_manifolds() {
  for (Batch& batch : batches_) {
    // Lanes without a contact, and points that a contact does not have, receive no impulse.
    if (batch.count < kLanes) {
      batch.normal = {all(1.0), all(0.0), all(0.0)};
      batch.tangent = {all(0.0), all(1.0), all(0.0)};
      batch.bitangent = {all(0.0), all(0.0), all(1.0)};
      batch.arm_a_m = batch.arm_body_m = {all(0.0), all(0.0), all(0.0)};
      batch.turns = WideMask{};
      batch.push_speed_m_s = all(0.0);
    }
    batch.friction = {};
    batch.friction_counted = {};
    for (int p = 0; p < batch.points; ++p) {
      batch.point[p] = PointLanes{};
      batch.point[p].separation_m = all(1.0);
    }
    for (int lane = 0; lane < batch.count; ++lane) {
      const RigidIsland::Contact& contact = island_.contacts[batch.contact[static_cast<size_t>(lane)]];
      const ContactManifold& manifold = *contact.manifold;
      const Eigen::Vector3d tangent = manifold.normal.unitOrthogonal();
      const Eigen::Vector3d bitangent = manifold.normal.cross(tangent);
      set(batch.normal, lane, manifold.normal);
      set(batch.tangent, lane, tangent);
      set(batch.bitangent, lane, bitangent);
      set(batch.arm_a_m, lane, manifold.arm_a_m);
      set(batch.arm_body_m, lane, manifold.arm_body_m);
      batch.turns[lane] = manifold.turns ? -1 : 0;
      batch.friction.impulse.x[lane] = tangent.dot(manifold.friction_impulse_n_s);
      batch.friction.impulse.y[lane] = bitangent.dot(manifold.friction_impulse_n_s);
      batch.friction.impulse.turn[lane] = manifold.twist_impulse;
      batch.push_speed_m_s[lane] = manifold.push_speed_m_s;
      for (int p = 0; p < manifold.point_count; ++p) {
        const ContactPoint& from = manifold.points[static_cast<size_t>(p)];
        PointLanes& point = batch.point[p];
        set(point.normal, lane, from.normal);
        set(point.arm_a_m, lane, from.arm_a_m);
        set(point.arm_body_m, lane, from.arm_body_m);
        point.turns[lane] = from.turns ? -1 : 0;
        point.separation_m[lane] = from.separation_m;
        point.impulse_n_s[lane] = from.impulse_n_s;
        auto& friction = batch.friction.points[static_cast<size_t>(p)];
        friction.friction[lane] = from.friction;
        friction.x_n_s[lane] = tangent.dot(from.friction_impulse_n_s);
        friction.y_n_s[lane] = bitangent.dot(from.friction_impulse_n_s);
        const double acceleration = closing_acceleration_m_s2(*contact.owner, manifold, from);
        point.acceleration_m_s2[lane] = acceleration;
        point.restitution_speed_m_s[lane] = manifold.restitution_speed_m_s;
        point.impact_speed_m_s[lane] = impact_speed_m_s(manifold, acceleration, step_s_);
      }
    }
  }
}

void ContactLanes::load_poses() {
  for (size_t i = 1; i < bodies_.size(); ++i) {
    const RigidBody& body = *bodies_[i];
    const Eigen::Matrix3d& inertia = body.inverse_inertia;
    const Eigen::Vector3d& at = body.world_from_body.position_m;
    BodyPose& pose = poses_[i];
    pose.inertia[0] = Wide{inertia(0, 0), inertia(0, 1), inertia(0, 2), at.x()};
    pose.inertia[1] = Wide{inertia(1, 1), inertia(1, 2), inertia(2, 2), at.y()};
    pose.inertia[2] = Wide{0.0, 0.0, 0.0, at.z()};
    const Eigen::Matrix3d turn = body.world_from_body.orientation.toRotationMatrix();
    for (int column = 0; column < 3; ++column)
      pose.turn[column] = Wide{turn(0, column), turn(1, column), turn(2, column), 0.0};
  }
}

void ContactLanes::load_motion() {
  for (size_t i = 1; i < bodies_.size(); ++i) {
    const RigidBody& body = *bodies_[i];
    const Eigen::Vector3d &v = body.velocity_m_s, &w = body.angular_velocity_rad_s;
    motion_[i].velocity = Wide{v.x(), v.y(), v.z(), body.inverse_mass};
    motion_[i].spin = Wide{w.x(), w.y(), w.z(), 0.0};
  }
}

void ContactLanes::store_motion() {
  count_momentum();
  for (size_t i = 1; i < bodies_.size(); ++i) {
    RigidBody& body = *bodies_[i];
    if (body.asleep) continue;
    const Wide &v = motion_[i].velocity, &w = motion_[i].spin, &l = motion_[i].momentum;
    body.velocity_m_s = {v[0], v[1], v[2]};
    body.angular_velocity_rad_s = {w[0], w[1], w[2]};
    body.angular_momentum += Eigen::Vector3d(l[0], l[1], l[2]);
    motion_[i].momentum = all(0.0);
  }
}

// Adds the angular momentum of the impulses that are not yet counted. The rows must be those that the
// impulses were applied along.
void ContactLanes::count_momentum() {
  for (Batch& batch : batches_) {
    const auto take = [](const Wide& impulse, Wide& counted) {
      const Wide given = impulse - counted;
      counted = impulse;
      return given;
    };
    const InPlane<Wide> friction = batch.friction.impulse - batch.friction_counted;
    batch.friction_counted = batch.friction.impulse;
    Wide3 sum_a =
        friction.x * batch.along.lever_a + friction.y * batch.across.lever_a + friction.turn * batch.normal;
    Wide3 sum_b =
        friction.x * batch.along.lever_b + friction.y * batch.across.lever_b + friction.turn * batch.normal;
    for (int p = 0; p < batch.points; ++p) {
      PointLanes& point = batch.point[p];
      const Wide given = take(point.impulse_n_s, point.counted_n_s);
      sum_a = sum_a + given * point.row.lever_a;
      sum_b = sum_b + given * point.row.lever_b;
    }
    for (int lane = 0; lane < batch.count; ++lane) {
      Wide& a = motion_[batch.a[static_cast<size_t>(lane)]].momentum;
      Wide& b = motion_[batch.b[static_cast<size_t>(lane)]].momentum;
      a += Wide{sum_a.x[lane], sum_a.y[lane], sum_a.z[lane], 0.0};
      b -= Wide{sum_b.x[lane], sum_b.y[lane], sum_b.z[lane], 0.0};
    }
  }
}

void ContactLanes::store_points() const {
  for_contacts([](const RigidIsland::Contact& contact, const Batch& batch, int lane) {
    for (int p = 0; p < contact.manifold->point_count; ++p) {
      ContactPoint& point = contact.manifold->points[static_cast<size_t>(p)];
      point.impulse_n_s = batch.point[p].impulse_n_s[lane];
      point.separation_m = batch.point[p].separation_m[lane];
    }
  });
}

void ContactLanes::store_friction() const {
  for_contacts([](const RigidIsland::Contact& contact, const Batch& batch, int lane) {
    ContactManifold& manifold = *contact.manifold;
    const Eigen::Vector3d tangent = get(batch.tangent, lane), bitangent = get(batch.bitangent, lane);
    for (int p = 0; p < manifold.point_count; ++p) {
      ContactPoint& point = manifold.points[static_cast<size_t>(p)];
      const auto& friction = batch.friction.points[static_cast<size_t>(p)];
      point.arm_a_m = get(batch.point[p].arm_a_m, lane);
      point.friction_impulse_n_s = friction.x_n_s[lane] * tangent + friction.y_n_s[lane] * bitangent;
    }
    const InPlane<Wide>& impulse = batch.friction.impulse;
    manifold.friction_impulse_n_s = impulse.x[lane] * tangent + impulse.y[lane] * bitangent;
    manifold.twist_impulse = impulse.turn[lane];
    manifold.arm_a_m = manifold.arm_b_m = get(batch.arm_a_m, lane);
    if (manifold.other)
      manifold.arm_b_m +=
          contact.owner->world_from_body.position_m - manifold.other->world_from_body.position_m;
  });
}

void ContactLanes::prepare() {
  struct Side {
    WideInertia inertia;
    Wide3 position_m;
  };
  const auto side = [&](const std::array<uint32_t, kLanes>& slots) {
    Wide rows[3][kLanes];
    for (int r = 0; r < 3; ++r) {
      for (size_t lane = 0; lane < kLanes; ++lane) rows[r][lane] = poses_[slots[lane]].inertia[r];
      transpose(rows[r][0], rows[r][1], rows[r][2], rows[r][3]);
    }
    return Side{{rows[0][0], rows[0][1], rows[0][2], rows[1][0], rows[1][1], rows[1][2]},
                {rows[0][3], rows[1][3], rows[2][3]}};
  };
  for (Batch& batch : batches_) {
    const Side a = side(batch.a), b = side(batch.b);
    const Wide3 between = a.position_m - b.position_m;
    Wide3 turn[3];
    for (int column = 0; column < 3; ++column) {
      Wide rows[kLanes];
      for (size_t lane = 0; lane < kLanes; ++lane) rows[lane] = poses_[batch.a[lane]].turn[column];
      transpose(rows[0], rows[1], rows[2], rows[3]);
      turn[column] = {rows[0], rows[1], rows[2]};
    }
    const auto turned = [&](const WideMask& turns, const Wide3& arm, const Wide3& arm_body) {
      const Wide3 now = arm_body.x * turn[0] + arm_body.y * turn[1] + arm_body.z * turn[2];
      return Wide3{turns ? now.x : arm.x, turns ? now.y : arm.y, turns ? now.z : arm.z};
    };
    Wide inverse_mass_a, inverse_mass_b;
    for (int lane = 0; lane < kLanes; ++lane) {
      inverse_mass_a[lane] = motion_[batch.a[static_cast<size_t>(lane)]].velocity[3];
      inverse_mass_b[lane] = motion_[batch.b[static_cast<size_t>(lane)]].velocity[3];
    }
    const Wide inverse_mass = inverse_mass_a + inverse_mass_b;
    // Returns the inverse of the effective mass. Both bodies are pushed at the same point, which conserves
    // angular momentum.
    const auto make_row = [&](RowLanes& row, const Wide3& direction, const Wide3& arm_a) {
      row.lever_a = cross(arm_a, direction);
      row.lever_b = cross(arm_a + between, direction);
      row.turn_a = a.inertia * row.lever_a;
      row.turn_b = b.inertia * row.lever_b;
      return inverse_mass + dot(row.lever_a, row.turn_a) + dot(row.lever_b, row.turn_b);
    };
    for (int p = 0; p < batch.points; ++p) {
      PointLanes& point = batch.point[p];
      point.arm_a_m = turned(point.turns, point.arm_a_m, point.arm_body_m);
      const Wide response = make_row(point.row, point.normal, point.arm_a_m);
      // Points that a contact does not have have no normal.
      point.mass_kg = dot(point.normal, point.normal) > 0.0 ? inverse_or_zero(response) : all(0.0);
    }
    batch.arm_a_m = turned(batch.turns, batch.arm_a_m, batch.arm_body_m);
    const Wide xx = make_row(batch.along, batch.tangent, batch.arm_a_m);
    const Wide yy = make_row(batch.across, batch.bitangent, batch.arm_a_m);
    batch.twist_turn_a = a.inertia * batch.normal;
    batch.twist_turn_b = b.inertia * batch.normal;
    const auto twisted = [&](const Wide3& on_a, const Wide3& on_b) {
      return dot(on_a, batch.twist_turn_a) + dot(on_b, batch.twist_turn_b);
    };
    const Wide xy =
        dot(batch.along.lever_a, batch.across.turn_a) + dot(batch.along.lever_b, batch.across.turn_b);
    batch.friction.set_response({xx, xy, twisted(batch.along.lever_a, batch.along.lever_b), yy,
                                 twisted(batch.across.lever_a, batch.across.lever_b),
                                 twisted(batch.normal, batch.normal)});
    for (int p = 0; p < batch.points; ++p) {
      auto& point = batch.friction.points[static_cast<size_t>(p)];
      const Wide3 arm_m = batch.point[p].arm_a_m - batch.arm_a_m;
      point.x_m = dot(batch.tangent, arm_m);
      point.y_m = dot(batch.bitangent, arm_m);
    }
  }
}

bool ContactLanes::any_impact() const {
  WideMask found{};
  for (const Batch& batch : batches_) {
    const MotionLanes a = gather(motion_, batch.a), b = gather(motion_, batch.b);
    for (int p = 0; p < batch.points; ++p) {
      const PointLanes& point = batch.point[p];
      const Wide closing = -speed_along(a, b, point.normal, point.row);
      const Wide separation = point.separation_m + way_off_line_m(a, point, step_s_);
      const Wide reach = step_s_ * (closing + step_s_ * point.acceleration_m_s2);
      found |= (closing > 0.0) & (closing >= point.impact_speed_m_s) & (separation <= reach);
    }
  }
  return any(found);
}

void ContactLanes::warm_start() {
  for (Batch& batch : batches_) {
    MotionLanes a = gather(motion_, batch.a), b = gather(motion_, batch.b);
    for (int p = 0; p < batch.points; ++p) {
      PointLanes& point = batch.point[p];
      apply(a, b, point.normal, point.row, point.impulse_n_s);
      point.counted_n_s = all(0.0);
    }
    apply_friction(a, b, batch, batch.friction.impulse);
    batch.friction_counted = {};
    scatter(a, motion_, batch.a);
    scatter(b, motion_, batch.b);
  }
}

void ContactLanes::sweep(ContactPhase phase) {
  const double step_s = step_s_;
  for (Batch& batch : batches_) {
    MotionLanes a = gather(motion_, batch.a), b = gather(motion_, batch.b);
    std::array<Wide, kMaxManifoldPoints> pressed_n_s;
    for (int p = 0; p < batch.points; ++p) pressed_n_s[static_cast<size_t>(p)] = batch.point[p].impulse_n_s;
    const InPlane<Wide> slip{speed_along(a, b, batch.tangent, batch.along),
                             speed_along(a, b, batch.bitangent, batch.across),
                             dot(batch.normal, a.spin - b.spin)};
    apply_friction(a, b, batch, batch.friction.solve(batch.points, pressed_n_s, slip));

    for (int p = 0; p < batch.points; ++p) {
      PointLanes& point = batch.point[p];
      const Wide opening = speed_along(a, b, point.normal, point.row);
      const Wide separation = point.separation_m + way_off_line_m(a, point, step_s);
      const WideMask apart = separation > 0.0;
      Wide bias = apart ? separation / step_s : all(0.0);  // may close the gap but not overlap
      Wide scale = all(1.0), softness = all(0.0);
      WideMask solved = WideMask{-1, -1, -1, -1};
      if (phase == ContactPhase::Push) {
        bias = apart ? bias : larger(soft_.bias_rate * separation, -batch.push_speed_m_s);
        scale = apart ? all(1.0) : all(soft_.mass_scale);
        softness = apart ? all(0.0) : all(soft_.impulse_scale);
      } else {
        // The rest is left to the impact at the start of the next step.
        solved = (opening > -point.restitution_speed_m_s) | (-opening < point.impact_speed_m_s);
      }
      const Wide change = -point.mass_kg * scale * (opening + bias) - softness * point.impulse_n_s;
      const Wide wanted = larger(point.impulse_n_s + change, all(0.0));
      const Wide impulse = solved ? wanted : point.impulse_n_s;
      apply(a, b, point.normal, point.row, impulse - point.impulse_n_s);
      point.impulse_n_s = impulse;
    }
    scatter(a, motion_, batch.a);
    scatter(b, motion_, batch.b);
  }
}

void ContactLanes::update_separations() {
  for (Batch& batch : batches_) {
    const MotionLanes a = gather(motion_, batch.a), b = gather(motion_, batch.b);
    for (int p = 0; p < batch.points; ++p) {
      PointLanes& point = batch.point[p];
      point.separation_m +=
          way_off_line_m(a, point, step_s_) + step_s_ * speed_along(a, b, point.normal, point.row);
    }
  }
}

}  // namespace livegs
