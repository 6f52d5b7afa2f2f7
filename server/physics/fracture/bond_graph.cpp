// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/fracture/bond_graph.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/assert.h"
#include "core/disjoint_sets.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Bonds of the body of the struck piece, with the load of each per unit impulse.
struct LoadedGroup {
  std::vector<uint32_t> bonds;   // unbroken, by index
  std::vector<double> impulses;  // through each of `bonds`, divided by its integrity
  double area_m2 = 0.0;
  double cross_section_m2 = 0.0;  // volume / length
  double integrity = 1.0;         // factor on the threshold due to damaged bonds
};

// Longest side of the solid box with the same moments of inertia.
double length_of(const BondGraph::Piece& body) {
  const Matrix3d spread = 0.5 * body.inertia.trace() * Matrix3d::Identity() - body.inertia;
  const double variance =
      Eigen::SelfAdjointEigenSolver<Matrix3d>(spread, Eigen::EigenvaluesOnly).eigenvalues()[2] / body.mass_kg;
  return std::sqrt(12.0 * std::max(variance, 1e-18));
}

LoadedGroup loads_of(const BondGraph& graph, const Impact& impact) {
  LoadedGroup group;
  const std::vector<uint32_t> groups = connected_groups(graph);
  std::vector<uint32_t> pieces;
  std::vector<int> number(graph.pieces.size(), -1);
  for (uint32_t p = 0; p < graph.pieces.size(); ++p) {
    if (groups[p] != groups[impact.piece]) continue;
    number[p] = static_cast<int>(pieces.size());
    pieces.push_back(p);
  }
  const double impulse = impact.impulse_n_s.norm();
  if (!(impulse > 0.0)) return group;
  for (uint32_t b = 0; b < graph.bonds.size(); ++b) {
    if (graph.bonds[b].integrity > 0.0 && number[graph.bonds[b].first] >= 0) group.bonds.push_back(b);
  }
  if (group.bonds.empty()) return group;

  const BondGraph::Piece body = joined_piece(graph, groups, groups[impact.piece]);
  const Vector3d unit = impact.impulse_n_s / impulse;
  const Vector3d velocity = unit / body.mass_kg;
  const Vector3d turning = body.inertia.inverse() * (impact.point_m - body.centre_m).cross(unit);

  const auto count = static_cast<Eigen::Index>(pieces.size());
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(count, count);
  Eigen::MatrixX3d momentum = Eigen::MatrixX3d::Zero(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const BondGraph::Piece& piece = graph.pieces[pieces[i]];
    momentum.row(i) = -piece.mass_kg * (velocity + turning.cross(piece.centre_m - body.centre_m));
  }
  momentum.row(number[impact.piece]) += unit;
  const auto spring = [&](const BondGraph::Bond& bond) {
    const double length = (graph.pieces[bond.second].centre_m - graph.pieces[bond.first].centre_m).norm();
    return bond.area_m2 / std::max(length, 1e-9);
  };
  for (uint32_t b : group.bonds) {
    const int i = number[graph.bonds[b].first], j = number[graph.bonds[b].second];
    const double k = spring(graph.bonds[b]);
    stiffness(i, i) += k, stiffness(j, j) += k;
    stiffness(i, j) -= k, stiffness(j, i) -= k;
  }
  // Displacements are defined up to a translation: fix the first piece.
  Eigen::MatrixX3d displacement = Eigen::MatrixX3d::Zero(count, 3);
  displacement.bottomRows(count - 1) =
      stiffness.bottomRightCorner(count - 1, count - 1).ldlt().solve(momentum.bottomRows(count - 1));

  double most = 0.0, max_by_integrity = 0.0;
  for (uint32_t b : group.bonds) {
    const BondGraph::Bond& bond = graph.bonds[b];
    const Vector3d stretch = displacement.row(number[bond.first]) - displacement.row(number[bond.second]);
    const double through = spring(bond) * stretch.norm();
    group.impulses.push_back(through / bond.integrity);
    most = std::max(most, through / bond.area_m2);
    max_by_integrity = std::max(max_by_integrity, through / bond.area_m2 / bond.integrity);
    group.area_m2 += bond.area_m2;
  }
  group.integrity = max_by_integrity > 0.0 ? most / max_by_integrity : 1.0;
  group.cross_section_m2 = body.volume_m3 / length_of(body);
  return group;
}

double threshold_n_s(const BondGraph& graph, const LoadedGroup& group) {
  if (group.bonds.empty()) return std::numeric_limits<double>::infinity();
  return graph.break_impulse_n_s * group.area_m2 / graph.whole_area_m2 * group.integrity;
}

// Faces between two groups of pieces.
struct Seam {
  uint32_t first, second;
  double impulse, area_m2;
  std::vector<uint32_t> bonds;
};

// Seams in the order in which groups are merged across them, least mean load first (average linkage, Sokal
// and Michener 1958). The lower bond wins ties.
std::vector<Seam> joined_seams(const BondGraph& graph, const LoadedGroup& group) {
  std::vector<Seam> open, closed;
  for (size_t k = 0; k < group.bonds.size(); ++k) {
    const BondGraph::Bond& bond = graph.bonds[group.bonds[k]];
    open.push_back({bond.first, bond.second, group.impulses[k], bond.area_m2, {group.bonds[k]}});
  }
  std::vector<int> seam_to(graph.pieces.size());
  while (!open.empty()) {
    size_t least = 0;
    for (size_t s = 1; s < open.size(); ++s) {
      if (open[s].impulse * open[least].area_m2 < open[least].impulse * open[s].area_m2) least = s;
    }
    const uint32_t kept = open[least].first, gone = open[least].second;
    closed.push_back(std::move(open[least]));
    open.erase(open.begin() + static_cast<std::ptrdiff_t>(least));
    // Seams of `gone` become seams of `kept`; two seams with the same neighbour are merged.
    std::fill(seam_to.begin(), seam_to.end(), -1);
    size_t count = 0;
    for (size_t s = 0; s < open.size(); ++s) {
      Seam& seam = open[s];
      if (seam.first == gone) seam.first = kept;
      if (seam.second == gone) seam.second = kept;
      if (seam.first == kept || seam.second == kept) {
        int& other = seam_to[seam.first == kept ? seam.second : seam.first];
        if (other >= 0) {
          Seam& into = open[static_cast<size_t>(other)];
          into.impulse += seam.impulse;
          into.area_m2 += seam.area_m2;
          into.bonds.insert(into.bonds.end(), seam.bonds.begin(), seam.bonds.end());
          continue;
        }
        other = static_cast<int>(count);
      }
      if (count != s) open[count] = std::move(seam);
      ++count;
    }
    open.resize(count);
  }
  return closed;
}

}  // namespace

BondGraph make_bond_graph(const VoronoiPieces& pieces, double mass_kg, double break_impulse_n_s) {
  LIVEGS_ASSERT(mass_kg > 0.0 && break_impulse_n_s > 0.0);
  BondGraph graph;
  graph.break_impulse_n_s = break_impulse_n_s;
  double volume = 0.0;
  for (const VoronoiPiece& piece : pieces.pieces) volume += piece.mass.volume_m3;
  for (const VoronoiPiece& piece : pieces.pieces) {
    const double piece_kg = mass_kg * piece.mass.volume_m3 / volume;
    graph.pieces.push_back(
        {piece_kg, piece.mass.centre_of_mass_m, piece_kg * piece.mass.inertia_m2, piece.mass.volume_m3});
  }
  double least_m2 = std::numeric_limits<double>::max();
  for (const VoronoiBond& bond : pieces.bonds) {
    graph.bonds.push_back({bond.first, bond.second, bond.area_m2});
    least_m2 = std::min(least_m2, bond.area_m2);
  }
  if (graph.bonds.empty()) least_m2 = 1e-6;
  for (;;) {
    // Connects the nearest two pieces of different groups.
    const std::vector<uint32_t> groups = connected_groups(graph);
    double nearest = std::numeric_limits<double>::max();
    BondGraph::Bond bond{0, 0, least_m2};
    for (uint32_t a = 0; a < groups.size(); ++a) {
      for (uint32_t b = a + 1; b < groups.size(); ++b) {
        const double distance = (graph.pieces[a].centre_m - graph.pieces[b].centre_m).norm();
        if (groups[a] == groups[b] || distance >= nearest) continue;
        nearest = distance;
        bond.first = a, bond.second = b;
      }
    }
    if (bond.first == bond.second) break;
    graph.bonds.push_back(bond);
  }
  for (const BondGraph::Bond& bond : graph.bonds) graph.whole_area_m2 += bond.area_m2;
  return graph;
}

double break_threshold_n_s(const BondGraph& graph, const Impact& impact) {
  return threshold_n_s(graph, loads_of(graph, impact));
}

std::vector<uint32_t> broken_bonds(const BondGraph& graph, const Impact& impact) {
  const LoadedGroup group = loads_of(graph, impact);
  const double threshold = threshold_n_s(graph, group);
  const double impulse = impact.impulse_n_s.norm();
  if (!(impulse >= threshold)) return {};
  const double paid_m2 = group.cross_section_m2 * (impulse / threshold) * (impulse / threshold);
  const std::vector<Seam> seams = joined_seams(graph, group);
  std::vector<uint32_t> bonds;
  double area_m2 = 0.0;
  for (size_t s = seams.size(); s-- > 0;) {
    area_m2 += seams[s].area_m2;
    if (!bonds.empty() && area_m2 > paid_m2) break;
    bonds.insert(bonds.end(), seams[s].bonds.begin(), seams[s].bonds.end());
  }
  return bonds;
}

void accumulate_damage(BondGraph& graph, const Impact& impact) {
  const LoadedGroup group = loads_of(graph, impact);
  const auto load = [&](size_t k) {
    const BondGraph::Bond& bond = graph.bonds[group.bonds[k]];
    return group.impulses[k] * bond.integrity / bond.area_m2;
  };
  double most = 0.0;
  for (size_t k = 0; k < group.bonds.size(); ++k) most = std::max(most, load(k));
  if (!(most > 0.0)) return;
  // Impulse that breaks the most loaded bond at full integrity.
  const double breaks_n_s = graph.break_impulse_n_s * group.area_m2 / graph.whole_area_m2;
  for (size_t k = 0; k < group.bonds.size(); ++k) {
    const double borne = impact.impulse_n_s.norm() / breaks_n_s * load(k) / most;
    const double loss = kDamagePerCycle * std::max(0.0, borne - kEnduranceLimit) / (1.0 - kEnduranceLimit);
    double& integrity = graph.bonds[group.bonds[k]].integrity;
    if (loss > 0.0) integrity = std::min(integrity, std::max(kMinIntegrity, integrity - loss));
  }
}

std::vector<uint32_t> connected_groups(const BondGraph& graph) {
  DisjointSets sets(graph.pieces.size());
  for (const BondGraph::Bond& bond : graph.bonds) {
    if (bond.integrity > 0.0) sets.join(bond.first, bond.second);
  }
  std::vector<uint32_t> groups(graph.pieces.size());
  for (uint32_t p = 0; p < groups.size(); ++p) groups[p] = sets.find(p);
  return groups;
}

BondGraph::Piece joined_piece(const BondGraph& graph, const std::vector<uint32_t>& group_of_piece,
                              uint32_t group) {
  BondGraph::Piece whole;
  whole.inertia.setZero();
  for (size_t p = 0; p < graph.pieces.size(); ++p) {
    if (group_of_piece[p] != group) continue;
    whole.mass_kg += graph.pieces[p].mass_kg;
    whole.volume_m3 += graph.pieces[p].volume_m3;
    whole.centre_m += graph.pieces[p].mass_kg * graph.pieces[p].centre_m;
  }
  LIVEGS_ASSERT(whole.mass_kg > 0.0);
  whole.centre_m /= whole.mass_kg;
  for (size_t p = 0; p < graph.pieces.size(); ++p) {
    if (group_of_piece[p] != group) continue;
    const Vector3d arm = graph.pieces[p].centre_m - whole.centre_m;
    whole.inertia +=
        graph.pieces[p].inertia +
        graph.pieces[p].mass_kg * (arm.squaredNorm() * Matrix3d::Identity() - arm * arm.transpose());
  }
  return whole;
}

}  // namespace livegs
