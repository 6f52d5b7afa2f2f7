// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "geometry/fracture/voronoi_pieces.h"

// Bonds between the pieces of a fragile body, and the selection of bonds that an impact breaks. Pure
// functions of the graph and the impact, an impulse in N s, so that the result does not depend on the step.
//
// The rule. The impulse accelerates the whole body; bonds transmit the share of the pieces far from it. Bonds
// are springs of stiffness area / length. One linear solve yields the impulse through each (Newton's law for
// each piece). The load of a bond is that impulse divided by area and integrity.
//   - Nothing breaks below the body's threshold. For the whole body it is J_c = break_impulse_n_s. For a
//     fragment it is scaled by its share of the bond area. It is lower if the most loaded bond is damaged.
//   - Starting with single pieces, the two neighbouring groups with the least mean load between them are
//     merged until one group is left. An impact undoes these merges in reverse order, so cracks run through
//     the body, fine near the impact and coarse far from it.
//   - The energy of the impact, proportional to J², pays for the cracked area (Griffith 1921): merges are
//     undone while the area of faces between groups is within A_0 (J / J_c)²; the first one always is. A_0
//     is the mean cross-section, volume / length: at the threshold one crack divides the body.
//
// Monotonicity: if an impact breaks bonds, a stronger one at the same point and direction breaks them too.
//
// An impact below the threshold damages bonds. Damage accumulates linearly (Palmgren 1924, Miner 1945), and
// only in bonds above an endurance limit (Ritchie 1999, Int. J. Fracture 100, 55), by choice one half.

namespace livegs {

struct BondGraph {
  struct Piece {
    double mass_kg = 0.0;
    Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();     // object frame at rest, like all positions here
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity();  // kg m², about centre_m
    double volume_m3 = 0.0;
  };
  struct Bond {
    uint32_t first = 0, second = 0;
    double area_m2 = 0.0;
    double integrity = 1.0;  // fraction of the original strength, 0 … 1; 0 is broken
  };
  std::vector<Piece> pieces;
  // In the order of VoronoiPieces::bonds, followed by the bonds of isolated parts.
  std::vector<Bond> bonds;
  double break_impulse_n_s = 0.0;  // J_c of the whole body, > 0
  double whole_area_m2 = 0.0;      // sum over all bonds of the intact body
};

// Distributes mass_kg by volume. Parts of the body without a neighbour (a captured leaf) get a bond of the
// smallest area to the nearest piece. Preconditions: mass and break impulse > 0.
BondGraph make_bond_graph(const VoronoiPieces& pieces, double mass_kg, double break_impulse_n_s);

// Impulse on one piece, summed over the impact window (impact_record.h).
struct Impact {
  uint32_t piece = 0;                                     // the struck piece: VoronoiPieces::locate(point_m)
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();      // object frame at rest
  Eigen::Vector3d impulse_n_s = Eigen::Vector3d::Zero();  // object axes
};

// Smallest impulse at this point and direction that breaks the body of the struck piece, N s; infinite for a
// single piece.
double break_threshold_n_s(const BondGraph& graph, const Impact& impact);

// Indices of the bonds that break, in order of breaking; empty below the threshold.
std::vector<uint32_t> broken_bonds(const BondGraph& graph, const Impact& impact);

// Loss of integrity by one impact just below the threshold; it decreases linearly to zero at kEnduranceLimit
// of that impact. Larger: fewer impacts to fracture. With 0.25 a body breaks at the second impact of 0.9 of
// its threshold, the third of 0.8, and the sixth of 0.65.
inline constexpr double kDamagePerCycle = 0.25;
inline constexpr double kEnduranceLimit = 0.5;
// Minimum integrity after damage: only an impact above the threshold breaks a bond.
inline constexpr double kMinIntegrity = 0.1;
// Damages the bonds of the struck piece's body. Precondition: the impact broke no bond.
void accumulate_damage(BondGraph& graph, const Impact& impact);

// For each piece, the smallest index of the pieces connected to it.
std::vector<uint32_t> connected_groups(const BondGraph& graph);

// Mass, volume, centre and inertia of the pieces of one group.
BondGraph::Piece joined_piece(const BondGraph& graph, const std::vector<uint32_t>& group_of_piece,
                              uint32_t group);

}  // namespace livegs
