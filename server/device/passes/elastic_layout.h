// SPDX-License-Identifier: GPL-3.0-or-later

// Rows of the elastic passes, shared by C++ and GLSL: std430 and C++ have the same layout, because vec4 is
// aligned to 16 bytes in both and scalars come in groups of four. Positions are relative to the origin of
// their body, world axes, metres. Spare components of vectors are 0.

#ifndef LIVEGS_DEVICE_ELASTIC_LAYOUT_H
#define LIVEGS_DEVICE_ELASTIC_LAYOUT_H
#include "device/passes/shader_math.h"
#ifdef __cplusplus
namespace livegs::shader {
inline constexpr uint kElasticBlock = 64;                    // nodes of a block, and invocations of a group
inline constexpr uint kCellConstants = 24, kCellGains = 36;  // floats a row
inline constexpr uint kBodyHeld = 1, kBodySecondOrder = 2;   // bits of BodyRow::flags
inline constexpr uint kPlane = 0, kBox = 1, kSphere = 2;     // ColliderRow::kind
#else
const uint kElasticBlock = 64;
const uint kCellConstants = 24, kCellGains = 36;
const uint kBodyHeld = 1, kBodySecondOrder = 2;
const uint kPlane = 0, kBox = 1, kSphere = 2;
#endif

// A node between steps: position and inverse mass (0: held), velocity and mass. Padding nodes have neither.
struct NodeStateRow {
  vec4 place;
  vec4 speed;
};
// A node in a step: predicted position and inverse mass; correction by the sweep.
struct NodeSolveRow {
  vec4 predicted;
  vec4 swept;
};
// Predicted velocity and mass; correction by contact.
struct NodeDriftRow {
  vec4 speed;
  vec4 pushed;
};
struct CellRow {
  uint nodes[8];
  uint body;
  uint constants;  // row of constants and gains
  uint rank;       // of its colour
  uint spare;
};
struct SurfaceCellRow {
  uint nodes[8];
  uint body;
  uint begin;  // range of points
  uint end;
  uint rank;
  uint sums;  // its row of ContactSumsRow; those of a body follow one another
  uint spare_0;
  uint spare_1;
  uint spare_2;
};
struct SurfacePointRow {
  vec4 low;       // weights of corners 0 to 3
  vec4 high;      // and 4 to 7
  vec4 mobility;  // x: mobility, 1/kg
};
struct ColliderRow {
  vec4 at;      // position; w: friction with the body
  vec4 axis_x;  // columns of world_from_collider; w of the first: kind
  vec4 axis_y;
  vec4 axis_z;
  vec4 size;  // box: half edges; sphere: radius in x. w: thickness that a point can tunnel through, 0: none
};
// Sums over a block of nodes, about the centre of mass before the step and relative to a mean velocity.
struct NodeSumsRow {
  vec4 first;     // m r
  vec4 momentum;  // m u; w: m u² / 2
  vec4 angular;   // r x m u
  vec4 before;    // r x m times the velocity before the step
  vec4 squares;   // m times xx, yy, zz
  vec4 products;  // m times xy, yz, zx
  vec4 kicked;    // r x impulse of contact
  vec4 load;      // r x load
};
// Sums over the contacts of one surface cell in one step, about the centre of mass before the step.
struct ContactSumsRow {
  vec4 impulse;   // J; w: sum of |J|
  vec4 moment;    // r x J; w: 1 if a point touches
  vec4 at;        // |J| r
  vec4 rolled;    // |J| r, after the contact
  vec4 squares;   // |J| times xx, yy, zz of these
  vec4 products;  // |J| times xy, yz, zx
};

struct BodyRow {
  // Values of the tick.
  vec4 gravity;
  vec4 load_n;    // sum of the loads
  vec4 push_n_s;  // impulse of gravity and loads in a step, in two words
  vec4 push_low;
  vec4 map_x;  // columns of the map from the moments of the nodes to the material's, object frame
  vec4 map_y;
  vec4 map_z;
  float mass_kg;
  float step_s;
  float damping_per_s;
  float weight_n;
  float moving_part;
  float friction;
  float inverse_four_widths;
  float slow_m_s;  // speed of deformation below which a touching body is slow
  float loss_factor;
  float stiffness_pa;  // plane strain modulus
  uint steps;          // of this tick; 0: the body is at rest on the device
  uint flags;
  uint first_block;
  uint block_count;
  uint first_surface;
  uint surface_count;
  uint first_collider;
  uint collider_count;
  uint gains;  // 0: of its own steps, 1: of impact steps
  uint spare_0;
  uint spare_1;
  uint spare_2;
  // State.
  uint first;     // the last step is no basis for BDF2
  uint uneven;    // the last step had another length
  uint strained;  // badly, in the last step
  uint touching;
  uint backward;
  uint slow;
  uint second_order;
  uint ever_strained;  // in this tick
  uint strain_bits;    // of |S - I|², as a float; the largest in this step
  uint bent_bits;
  uint lack_bits;  // of 1 - det F
  float deviation_m_s;
  float pressed_n;
  float carried_n;
  float contact_n_s;  // sum of |J| over the tick
  float memory;       // of the current step: 1/3 or 0
  float solve_s;      // h_e
  float kept;
  vec4 orientation;  // x, y, z, w
  vec4 momentum;     // of the body, and the part below its last digit
  vec4 momentum_low;
  vec4 angular;
  vec4 angular_low;
  vec4 momentum_before;
  vec4 angular_before;
  vec4 velocity_correction;
  vec4 spin_correction;
  vec4 contact_lag_m;
  vec4 between_n_s;
  vec4 centre;
  vec4 inertia_x;  // of the material
  vec4 inertia_y;
  vec4 inertia_z;
  vec4 nodes_x;  // inertia of the nodes
  vec4 nodes_y;
  vec4 nodes_z;
  vec4 load_torque;
  vec4 contact_moment;  // sum of |J| times point over the tick
  // Values of the current step.
  vec4 correction;
  vec4 correction_spin;
  vec4 bias;
  vec4 spin;
  vec4 field_x;
  vec4 field_y;
  vec4 field_z;
  vec4 mean_m_s;    // of the nodes without contact
  vec4 before_m_s;  // of the nodes before the step
  vec4 turning;     // spin before the step
};

// Constants of all elastic passes.
struct ElasticConstants {
  uint count;  // items
  uint step;   // 0, 1, ...; bodies with fewer steps are skipped
  uint first;  // row of the first item, and of the item `split`; the others follow
  uint split;
  uint second;
  uint rank;  // of the colour; bodies that sweep backwards take rank_count - 1 - rank
  uint rank_count;
  uint row_count;  // of constants
  uint begins;     // ledger: only prepares the first step
};

#ifdef __cplusplus
static_assert(sizeof(CellRow) == 48 && sizeof(SurfaceCellRow) == 64);
static_assert(sizeof(BodyRow) % 16 == 0 && sizeof(NodeSumsRow) == 128 && sizeof(ContactSumsRow) == 96);
}  // namespace livegs::shader
#endif
#endif
