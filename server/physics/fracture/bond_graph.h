// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "geometry/fracture/voronoi_pieces.h"

// What holds the pieces of a fragile body together, and which bonds an impact breaks. Pure functions of the
// graph and the impact: an impulse in N s, never a force, so that the step has no say in what breaks.
//
// The rule. An impact's impulse has to set the whole body in motion, and what it gives to the pieces far from
// the impact passes through bonds. Bonds are springs in parallel, stiffness area / length; the impulse
// through each follows from one linear solve (Newton's law for each piece as a node: what comes in minus what
// goes out is the momentum of its rigid motion). A bond's load is that impulse by area and integrity.
//   - Nothing breaks below the threshold of the body, J_c = break_impulse_n_s for the whole, scaled by its
//   share of the
//     bond area for a fragment, and lower where the most loaded bond is weak.
//   - Pieces across faces of little load stay together: from single pieces on, the two neighbouring groups
//   with the
//     least mean load between them become one, until all are. An impact undoes these joins from the last on,
//     so cracks run right across, fine near the impact and coarse far from it.
//   - Cracked area is paid for by the energy of the impact, which goes with J² (Griffith 1921): joins are
//   undone while the
//     area of the faces between groups stays within A_0 (J / J_c)², the first one always. A_0 is the mean
//     cross-section of the body, volume by length: at the threshold one crack goes right through, however
//     finely it was cut.
// What an impact breaks, a stronger one at the same place and direction breaks too.
//
// An impact that breaks nothing wears bonds. Damage adds up linearly (Palmgren 1924, Miner 1945), and only of
// bonds that bear more than half of what breaks them: under some part of their toughness cracks in brittle
// solids do not grow from cycle to cycle (Ritchie 1999, Int. J. Fracture 100, 55); one half is our choice. So
// a thing that is struck hard again and again breaks, along bonds that were struck before.

namespace livegs {

struct BondGraph {
  struct Piece {
    double mass_kg = 0.0;
    Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();     // object frame at rest, as are all lengths here
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity();  // kg m², about its centre
    double volume_m3 = 0.0;
  };
  struct Bond {
    uint32_t first = 0, second = 0;
    double area_m2 = 0.0;
    double integrity = 1.0;  // of its strength, 0 … 1; 0 is broken
  };
  std::vector<Piece> pieces;
  std::vector<Bond>
      bonds;  // in the order of VoronoiPieces::bonds; after them, those of parts that touch nothing
  double break_impulse_n_s = 0.0;  // of the whole, > 0
  double whole_area_m2 = 0.0;      // of all bonds when whole
};

// mass_kg is shared by volume. Parts of the body that touch nothing (a captured leaf) are held by a bond to
// the piece nearest to them, of the smallest area there is. Preconditions: mass and break impulse > 0.
BondGraph make_bond_graph(const VoronoiPieces& pieces, double mass_kg, double break_impulse_n_s);

// An impulse on one piece, summed over the frame.
struct Impact {
  uint32_t piece = 0;  // the one that was struck: VoronoiPieces::locate(point_m)
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();      // object frame at rest
  Eigen::Vector3d impulse_n_s = Eigen::Vector3d::Zero();  // the same axes
};

// The least impulse at this place and in this direction that breaks the body the struck piece belongs to, N
// s; infinite for a lone piece.
double break_threshold_n_s(const BondGraph& graph, const Impact& impact);

// Numbers of the bonds that break, in the order they do; empty below the threshold.
std::vector<uint32_t> broken_bonds(const BondGraph& graph, const Impact& impact);

// Of a bond's integrity, what one impact takes that just does not break it; in proportion from
// kEnduranceLimit of that impact on. Larger: fewer impacts break. A cup that bears 0.9 of what breaks it
// breaks at the second such impact, at 0.8 the third, at 0.65 the sixth.
inline constexpr double kDamagePerCycle = 0.25;
inline constexpr double kEnduranceLimit = 0.5;
// Wear leaves this much: only an impact breaks.
inline constexpr double kMinIntegrity = 0.1;
// Wears the bonds of the body that the struck piece belongs to. Precondition: the impact broke nothing.
void accumulate_damage(BondGraph& graph, const Impact& impact);

// For each piece the lowest number of a piece it hangs together with.
std::vector<uint32_t> connected_groups(const BondGraph& graph);

// Mass, volume, centre and inertia of pieces that move as one.
BondGraph::Piece joined_piece(const BondGraph& graph, const std::vector<uint32_t>& group_of_piece,
                              uint32_t group);

}  // namespace livegs
