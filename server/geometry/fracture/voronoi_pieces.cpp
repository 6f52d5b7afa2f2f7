// SPDX-License-Identifier: GPL-3.0-or-later
// 1. Each cell is clipped separately, in parallel (clip_to_cell).
// 2. Its contents are split into connected parts.
// 3. Vertices with the same name, found in up to four cells, are merged, so that both sides of a cut face
// have
//    the same boundary.
// 4. Slivers are merged with a neighbour. The faces between them are dropped, which leaves the rest closed.
#include "geometry/fracture/voronoi_pieces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <unordered_map>

#include "core/disjoint_sets.h"
#include "core/parallel_for.h"
#include "geometry/fracture/cell_parts.h"
#include "geometry/fracture/voronoi_neighbours.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/mesh/triangle_distance.h"
#include "geometry/mesh/weld_vertices.h"

namespace livegs {
namespace {

constexpr size_t kMaxCells = 4096;
constexpr double kMinVolumeShare =
    1e-9;  // minimum volume relative to the whole; smaller parts are rounding errors
constexpr double kMinSeedDistance = 1e-9;  // relative to the diagonal

// A cut face seen from its lower part, with its area. Bonds are sums of contacts.
struct Contact {
  uint32_t first, second;  // parts, first < second
  double area_m2 = 0.0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  // area times centroid
  Eigen::Vector3d normal_area = Eigen::Vector3d::Zero();
};

struct PartList {
  std::vector<CellPart> parts;              // sorted by cell
  std::vector<Eigen::Vector3d> vertices_m;  // shared
  // By part and triangle: the part on the other side of a cut face, or ~0.
  std::vector<std::vector<uint32_t>> facing;
};

struct NameHash {
  size_t operator()(const VertexName& name) const {
    uint64_t hash = 0xcbf29ce484222325ull;
    for (uint32_t number : name) hash = (hash ^ number) * 0x9E3779B97F4A7C15ull, hash ^= hash >> 29;
    return static_cast<size_t>(hash);
  }
};

// Keeps one vertex per name, at the position found by the cell with the lowest number.
void share_vertices(std::vector<std::vector<CellPart>>& by_cell, const std::vector<ClippedCell>& cells,
                    PartList& list) {
  std::unordered_map<VertexName, uint32_t, NameHash> shared;
  for (size_t c = 0; c < cells.size(); ++c) {
    std::vector<uint32_t> number(cells[c].vertices_m.size());
    for (size_t v = 0; v < number.size(); ++v) {
      const auto [found, is_new] =
          shared.try_emplace(cells[c].names[v], static_cast<uint32_t>(list.vertices_m.size()));
      if (is_new) list.vertices_m.push_back(cells[c].vertices_m[v]);
      number[v] = found->second;
    }
    for (CellPart& part : by_cell[c]) {
      for (auto& triangle : part.triangles) {
        for (uint32_t& corner : triangle) corner = number[corner];
      }
      list.parts.push_back(std::move(part));
    }
  }
}

// Finds for each cut face the part of the other cell that shares most of its corners.
void find_facing_parts(PartList& list, size_t cell_count) {
  std::vector<std::vector<uint32_t>> parts_of_cell(cell_count);
  for (uint32_t p = 0; p < list.parts.size(); ++p) parts_of_cell[list.parts[p].cell].push_back(p);
  // Corners of the faces between each part and each cell.
  std::map<std::pair<uint32_t, uint32_t>, std::vector<uint32_t>> corners;
  for (uint32_t p = 0; p < list.parts.size(); ++p) {
    for (const CellPart::Face& face : list.parts[p].faces) {
      if (face.label >= cell_count) continue;
      auto& set = corners[{p, face.label}];
      for (uint32_t t = face.begin; t < face.end; ++t) {
        const auto& triangle = list.parts[p].triangles[t];
        set.insert(set.end(), triangle.begin(), triangle.end());
      }
    }
  }
  for (auto& [key, set] : corners) {
    std::sort(set.begin(), set.end());
    set.erase(std::unique(set.begin(), set.end()), set.end());
  }
  list.facing.resize(list.parts.size());
  for (uint32_t p = 0; p < list.parts.size(); ++p) {
    const CellPart& part = list.parts[p];
    list.facing[p].assign(part.triangles.size(), ~0u);
    for (const CellPart::Face& face : part.faces) {
      if (face.label >= cell_count) continue;
      uint32_t best = ~0u;
      size_t most = 0;
      for (uint32_t other : parts_of_cell[face.label]) {
        const auto found = corners.find({other, part.cell});
        if (found == corners.end()) continue;
        size_t common = 0;
        for (uint32_t t = face.begin; t < face.end; ++t) {
          for (uint32_t corner : part.triangles[t]) {
            common += std::binary_search(found->second.begin(), found->second.end(), corner);
          }
        }
        if (common > most) most = common, best = other;
      }
      for (uint32_t t = face.begin; t < face.end; ++t) list.facing[p][t] = best;
    }
  }
}

std::vector<Contact> contacts_of(const PartList& list) {
  std::map<std::pair<uint32_t, uint32_t>, Contact> contacts;
  for (uint32_t p = 0; p < list.parts.size(); ++p) {
    for (size_t t = 0; t < list.facing[p].size(); ++t) {
      const uint32_t other = list.facing[p][t];
      if (other == ~0u || other < p) continue;
      const auto& [a, b, c] = list.parts[p].triangles[t];
      const Eigen::Vector3d &pa = list.vertices_m[a], &pb = list.vertices_m[b], &pc = list.vertices_m[c];
      const Eigen::Vector3d normal_area = 0.5 * (pb - pa).cross(pc - pa);
      const double area = normal_area.norm();
      Contact& contact = contacts.try_emplace({p, other}, Contact{p, other}).first->second;
      contact.area_m2 += area;
      contact.moment += area / 3.0 * (pa + pb + pc);
      contact.normal_area += normal_area;
    }
  }
  std::vector<Contact> out;
  for (const auto& [key, contact] : contacts) out.push_back(contact);
  return out;
}

double part_volume(const PartList& list, const CellPart& part) {
  const Eigen::Vector3d origin = list.vertices_m[part.triangles[0][0]];
  double six = 0.0;
  for (const auto& [a, b, c] : part.triangles) {
    six +=
        (list.vertices_m[a] - origin).dot((list.vertices_m[b] - origin).cross(list.vertices_m[c] - origin));
  }
  return six / 6.0;
}

Eigen::Vector3d part_middle(const PartList& list, const CellPart& part) {
  Eigen::AlignedBox3d box;
  for (const auto& triangle : part.triangles) {
    for (uint32_t corner : triangle) box.extend(list.vertices_m[corner]);
  }
  return box.center();
}

// Returns sets of parts; each set makes one piece.
DisjointSets join_slivers(const PartList& list, const std::vector<Contact>& contacts,
                          const CutOptions& options) {
  const auto count = static_cast<uint32_t>(list.parts.size());
  DisjointSets sets(count);
  std::vector<double> volumes(count);
  double whole = 0.0;
  for (uint32_t p = 0; p < count; ++p) whole += volumes[p] = part_volume(list, list.parts[p]);
  const double least = std::max(options.smallest_share, kMinVolumeShare);
  size_t left = count;
  while (left > 1) {
    uint32_t smallest = ~0u;
    for (uint32_t p = 0; p < count; ++p) {
      if (sets.find(p) == p && (smallest == ~0u || volumes[p] < volumes[smallest])) smallest = p;
    }
    if (left <= options.most_pieces && volumes[smallest] >= least * whole) break;
    // The neighbour with the largest shared area; without neighbours, the set with the nearest centre.
    std::map<uint32_t, double> areas;
    for (const Contact& contact : contacts) {
      const uint32_t a = sets.find(contact.first), b = sets.find(contact.second);
      if (a != b && a == smallest) areas[b] += contact.area_m2;
      if (a != b && b == smallest) areas[a] += contact.area_m2;
    }
    uint32_t best = ~0u;
    double most = 0.0;
    for (const auto& [other, area] : areas) {
      if (area > most) most = area, best = other;
    }
    if (best == ~0u) {
      double nearest = std::numeric_limits<double>::max();
      const Eigen::Vector3d middle = part_middle(list, list.parts[smallest]);
      for (uint32_t p = 0; p < count; ++p) {
        if (sets.find(p) == smallest) continue;
        const double distance = (part_middle(list, list.parts[p]) - middle).norm();
        if (distance < nearest) nearest = distance, best = sets.find(p);
      }
    }
    const double sum = volumes[smallest] + volumes[best];
    sets.join(smallest, best);
    volumes[sets.find(best)] = sum;
    --left;
  }
  return sets;
}

// Returns whether each edge occurs equally often in both directions.
bool is_balanced(std::span<const std::array<uint32_t, 3>> triangles) {
  std::vector<std::array<uint32_t, 2>> forward, backward;
  for (const auto& triangle : triangles) {
    for (int k = 0; k < 3; ++k) {
      const uint32_t from = triangle[k], to = triangle[(k + 1) % 3];
      if (from < to)
        forward.push_back({from, to});
      else
        backward.push_back({to, from});
    }
  }
  std::sort(forward.begin(), forward.end());
  std::sort(backward.begin(), backward.end());
  return forward == backward;
}

void add_pieces(const PartList& list, DisjointSets& sets, VoronoiPieces& out) {
  const auto part_count = static_cast<uint32_t>(list.parts.size());
  std::vector<uint32_t> piece_of_part(part_count, ~0u), piece_of_set(part_count, ~0u);
  std::vector<std::vector<uint32_t>> parts_of_piece;
  for (uint32_t p = 0; p < part_count; ++p) {
    uint32_t& piece = piece_of_set[sets.find(p)];
    if (piece == ~0u) {
      piece = static_cast<uint32_t>(parts_of_piece.size());
      parts_of_piece.emplace_back();
    }
    piece_of_part[p] = piece;
    parts_of_piece[piece].push_back(p);
  }

  // Bonds are sorted by piece numbers.
  std::map<std::pair<uint32_t, uint32_t>, VoronoiBond> bonds;
  for (const Contact& contact : contacts_of(list)) {
    uint32_t a = piece_of_part[contact.first], b = piece_of_part[contact.second];
    if (a == b) continue;
    const double sign = a < b ? 1.0 : -1.0;
    if (a > b) std::swap(a, b);
    VoronoiBond& bond =
        bonds.try_emplace({a, b}, VoronoiBond{a, b, 0.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()})
            .first->second;
    bond.area_m2 += contact.area_m2;
    bond.centroid_m += contact.moment;
    bond.normal += sign * contact.normal_area;
  }
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> bond_number;
  for (auto& [key, bond] : bonds) {
    if (!(bond.area_m2 > 0.0)) continue;
    bond.centroid_m /= bond.area_m2;
    const double length = bond.normal.norm();
    bond.normal = length > 0.0 ? Eigen::Vector3d(bond.normal / length) : Eigen::Vector3d::UnitX();
    bond_number[key] = static_cast<uint32_t>(out.bonds.size());
    out.bonds.push_back(bond);
  }

  for (uint32_t piece = 0; piece < parts_of_piece.size(); ++piece) {
    VoronoiPiece& made = out.pieces.emplace_back();
    std::vector<std::array<uint32_t, 3>> triangles, inner;
    std::vector<uint32_t> triangle_bond;
    for (uint32_t p : parts_of_piece[piece]) {
      for (size_t t = 0; t < list.parts[p].triangles.size(); ++t) {
        const auto& triangle = list.parts[p].triangles[t];
        if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) continue;
        const uint32_t facing = list.facing[p][t];
        const uint32_t other = facing == ~0u ? piece : piece_of_part[facing];
        if (facing != ~0u && other == piece) {
          inner.push_back(triangle);
          continue;
        }
        triangles.push_back(triangle);
        const auto found = bond_number.find(std::minmax(piece, other));
        triangle_bond.push_back(found == bond_number.end() ? kNoBond : found->second);
      }
    }
    if (!inner.empty() && !is_balanced(triangles)) {
      // The two sides of a face between joined slivers do not match. Both are kept, which encloses the same
      // volume.
      triangles.insert(triangles.end(), inner.begin(), inner.end());
      triangle_bond.resize(triangles.size(), kNoBond);
    }
    std::unordered_map<uint32_t, uint32_t> number;
    for (auto& triangle : triangles) {
      for (uint32_t& corner : triangle) {
        const auto [found, is_new] =
            number.try_emplace(corner, static_cast<uint32_t>(made.mesh.vertices_m.size()));
        if (is_new) made.mesh.vertices_m.push_back(list.vertices_m[corner]);
        corner = found->second;
      }
    }
    made.mesh.triangles = std::move(triangles);
    made.triangle_bond = std::move(triangle_bond);
    made.mass = solid_mass_properties(made.mesh);
  }

  for (uint32_t p = 0; p < part_count; ++p) {
    VoronoiPieces::Part& part = out.cell_parts[list.parts[p].cell].emplace_back();
    part.piece = piece_of_part[p];
    part.mesh.triangles = list.parts[p].triangles;
  }
  for (auto& parts : out.cell_parts) {
    const bool one_piece = std::all_of(parts.begin(), parts.end(),
                                       [&](const auto& part) { return part.piece == parts[0].piece; });
    if (one_piece) parts.resize(std::min<size_t>(parts.size(), 1));
    for (auto& part : parts) {
      if (one_piece) {
        part.mesh = {};
        continue;
      }
      std::unordered_map<uint32_t, uint32_t> number;
      for (auto& triangle : part.mesh.triangles) {
        for (uint32_t& corner : triangle) {
          const auto [found, is_new] =
              number.try_emplace(corner, static_cast<uint32_t>(part.mesh.vertices_m.size()));
          if (is_new) part.mesh.vertices_m.push_back(list.vertices_m[corner]);
          corner = found->second;
        }
      }
    }
  }
}

// Removes empty cells. Neighbours are found in a box three times as wide, because kernels extend beyond the
// body.
void drop_empty_cells(VoronoiPieces& out, const Eigen::AlignedBox3d& bounds) {
  uint32_t count = 0;
  for (uint32_t c = 0; c < out.seeds_m.size(); ++c) {
    if (out.cell_parts[c].empty()) continue;
    if (count != c) {
      out.seeds_m[count] = out.seeds_m[c];
      out.cell_parts[count] = std::move(out.cell_parts[c]);
    }
    ++count;
  }
  out.seeds_m.resize(count);
  out.cell_parts.resize(count);
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(bounds.diagonal().norm());
  out.cell_neighbours = voronoi_neighbours(out.seeds_m, {bounds.min() - margin, bounds.max() + margin});
  for (auto& neighbours : out.cell_neighbours) std::sort(neighbours.begin(), neighbours.end());
}

Result<void> check(const TriangleMesh& mesh, std::span<const Eigen::Vector3d> seeds_m) {
  for (const auto& vertex : mesh.vertices_m) {
    if (!vertex.allFinite()) return invalid_data("fracture: a vertex of the mesh is not finite");
  }
  if (seeds_m.empty() || seeds_m.size() > kMaxCells) {
    return invalid_argument("fracture: " + std::to_string(seeds_m.size()) + " seeds; give 1 to " +
                            std::to_string(kMaxCells));
  }
  const double least_m = kMinSeedDistance * mesh_bounds_m(mesh).diagonal().norm();
  for (size_t a = 0; a < seeds_m.size(); ++a) {
    if (!seeds_m[a].allFinite()) {
      return invalid_argument("fracture: seed " + std::to_string(a) + " is not finite");
    }
    for (size_t b = 0; b < a; ++b) {
      if (!((seeds_m[a] - seeds_m[b]).norm() > least_m)) {
        return invalid_argument("fracture: seeds " + std::to_string(b) + " and " + std::to_string(a) +
                                " are at the same place; remove one");
      }
    }
  }
  return {};
}

}  // namespace

Result<VoronoiPieces> cut_voronoi_pieces(const TriangleMesh& mesh, std::span<const Eigen::Vector3d> seeds_m,
                                         const CutOptions& options) {
  const TriangleMesh* body = &mesh;
  TriangleMesh welded;
  if (!mesh_topology(mesh).closed) {
    welded = weld_vertices(mesh);
    const MeshTopology topology = mesh_topology(welded);
    if (!topology.closed) {
      return invalid_data("fracture: the mesh is open (" + std::to_string(open_edge_count(welded)) +
                          " edges lack a neighbour) and cannot be cut; close it, or make a closed one with "
                          "reconstruct_surface");
    }
    body = &welded;
  }
  if (Result<void> checked = check(*body, seeds_m); !checked) return checked.error();
  if (!(signed_volume_m3(*body) > 0.0)) {
    return invalid_data("fracture: the mesh is inside out or encloses no volume; reverse its triangles");
  }
  if (!(options.smallest_share >= 0.0 && options.smallest_share < 1.0) || options.most_pieces < 1) {
    return invalid_argument(
        "fracture: smallest_share or most_pieces is out of range; give 0 to 1 and at least 1");
  }

  VoronoiPieces out;
  out.seeds_m.assign(seeds_m.begin(), seeds_m.end());
  const Eigen::AlignedBox3d bounds = mesh_bounds_m(*body);
  const std::vector<std::vector<uint32_t>> neighbours = voronoi_neighbours(seeds_m, bounds);
  out.cell_parts.resize(seeds_m.size());

  std::vector<ClippedCell> cells(seeds_m.size());
  std::vector<std::vector<CellPart>> parts(seeds_m.size());
  std::atomic<size_t> done = 0;
  parallel_for(cells.size(), 1, [&](size_t begin, size_t end) {
    for (size_t c = begin; c < end; ++c) {
      if (options.stop.stop_requested()) return;
      cells[c] = clip_to_cell(*body, seeds_m, static_cast<uint32_t>(c), neighbours[c]);
      parts[c] = connected_parts(cells[c], static_cast<uint32_t>(c));
      if (options.progress) {
        options.progress->store(0.9f * static_cast<float>(++done) / static_cast<float>(cells.size()));
      }
    }
  });
  if (options.stop.stop_requested()) return Error{ErrorCode::Unavailable, "fracture: cancelled"};

  PartList list;
  share_vertices(parts, cells, list);
  find_facing_parts(list, seeds_m.size());
  DisjointSets sets = join_slivers(list, contacts_of(list), options);
  add_pieces(list, sets, out);
  drop_empty_cells(out, bounds);
  if (options.progress) options.progress->store(1.0f);
  return out;
}

uint32_t VoronoiPieces::cell_at(const Eigen::Vector3d& point_m) const {
  uint32_t best = 0;
  double nearest = std::numeric_limits<double>::max();
  for (uint32_t c = 0; c < seeds_m.size(); ++c) {
    const double distance = (point_m - seeds_m[c]).squaredNorm();
    if (distance < nearest) nearest = distance, best = c;
  }
  return best;
}

uint32_t VoronoiPieces::locate(const Eigen::Vector3d& point_m) const {
  return locate_in(cell_at(point_m), point_m);
}

uint32_t VoronoiPieces::locate_in(uint32_t cell, const Eigen::Vector3d& point_m) const {
  const std::vector<Part>& parts = cell_parts[cell];
  if (parts.size() == 1) return parts[0].piece;
  // A path from one part to another leaves the first part, so the nearest surface belongs to the part that
  // contains the point.
  uint32_t best = parts[0].piece;
  double nearest = std::numeric_limits<double>::max();
  for (const Part& part : parts) {
    for (const auto& [a, b, c] : part.mesh.triangles) {
      const Eigen::Vector3d on = closest_point_on_triangle(point_m, part.mesh.vertices_m[a],
                                                           part.mesh.vertices_m[b], part.mesh.vertices_m[c]);
      const double distance = (on - point_m).squaredNorm();
      if (distance < nearest) nearest = distance, best = part.piece;
    }
  }
  return best;
}

}  // namespace livegs
