// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <unordered_set>

#include "core/disjoint_sets.h"
#include "physics/lattice/build_lattice.h"

namespace livegs {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Maximum gap in box edges. A smaller value lets jitter open cracks; a larger one closes slits.
constexpr double kMaxLinkGap = 0.5;

// Boxes, binned by the cubic cell that contains their centre.
class BoxGrid {
 public:
  BoxGrid(const BodyExtent& extent, double cube_m) : extent_(extent), cube_m_(cube_m) {
    for (uint32_t i = 0; i < extent.boxes.size(); ++i)
      places_.push_back({cube_of(extent.boxes[i].centre_m), i});
    std::ranges::sort(places_, before);
  }

  // Visits every other box with its centre in the bin of box i or in an adjacent bin.
  void for_each_near(uint32_t i, const std::function<void(uint32_t)>& take) const {
    const Vector3i own = cube_of(extent_.boxes[i].centre_m);
    for (int z = -1; z <= 1; ++z) {
      for (int y = -1; y <= 1; ++y) {
        // Bins of one row are consecutive.
        auto place = std::ranges::lower_bound(places_, Place{own + Vector3i(-1, y, z), 0}, before);
        for (; place != places_.end() && place->cube.z() == own.z() + z && place->cube.y() == own.y() + y &&
               place->cube.x() <= own.x() + 1;
             ++place) {
          if (place->box != i) take(place->box);
        }
      }
    }
  }

 private:
  struct Place {
    Vector3i cube;
    uint32_t box;
  };
  static bool before(const Place& a, const Place& b) {
    for (int d = 2; d >= 0; --d) {
      if (a.cube[d] != b.cube[d]) return a.cube[d] < b.cube[d];
    }
    return a.box < b.box;
  }
  Vector3i cube_of(const Vector3d& point_m) const {
    return ((point_m - extent_.min_m) / cube_m_).array().floor().cast<int>();
  }

  const BodyExtent& extent_;
  double cube_m_;
  std::vector<Place> places_;
};

// Bit 0: x is odd, bit 1: y, bit 2: z. Cells of one parity share no corner.
int parity_of(const Vector3i& c) { return (c.x() & 1) | (c.y() & 1) << 1 | (c.z() & 1) << 2; }

Vector3i corner_offset(uint32_t corner) {
  return {static_cast<int>(corner & 1), static_cast<int>(corner >> 1 & 1), static_cast<int>(corner >> 2)};
}

bool neighbours(const Vector3i& a, const Vector3i& b) { return ((a - b).cwiseAbs().array() <= 1).all(); }

// Entries of box i are begin[i] ... begin[i + 1] - 1.
std::vector<uint32_t> entries_by_box(std::span<const BoxInCell> entries) {
  std::vector<uint32_t> begin(1, 0);
  for (uint32_t e = 0; e < entries.size(); ++e) {
    while (begin.size() <= entries[e].box) begin.push_back(e);
  }
  begin.push_back(static_cast<uint32_t>(entries.size()));
  return begin;
}

// Calls `take` for pairs of connected entries: of one box, or of two linked boxes.
template <class Take>
void for_each_joint(const std::vector<uint32_t>& begin, const BoxLinks& links, Take take) {
  for (size_t box = 0; box + 1 < begin.size(); ++box) {
    for (uint32_t e = begin[box]; e < begin[box + 1]; ++e) {
      for (uint32_t f = e + 1; f < begin[box + 1]; ++f) take(e, f);
    }
  }
  for (const auto& [i, j] : links) {
    for (uint32_t e = begin[i]; e < begin[i + 1]; ++e) {
      for (uint32_t f = begin[j]; f < begin[j + 1]; ++f) take(e, f);
    }
  }
}

// Numbers the materials by cell (z, y, x), then by first entry.
struct Materials {
  std::vector<Vector3i> cells;
  std::vector<uint32_t> of_entry;
};
Materials number_materials(std::span<const BoxInCell> entries, DisjointSets& joined) {
  std::vector<uint32_t> roots;
  for (uint32_t e = 0; e < entries.size(); ++e) {
    if (joined.find(e) == e) roots.push_back(e);
  }
  std::ranges::sort(roots, {}, [&](uint32_t e) { return std::pair(lattice_key(entries[e].cell), e); });
  Materials materials;
  std::vector<uint32_t> number(entries.size());
  for (const uint32_t root : roots) {
    number[root] = static_cast<uint32_t>(materials.cells.size());
    materials.cells.push_back(entries[root].cell);
  }
  for (uint32_t e = 0; e < entries.size(); ++e) materials.of_entry.push_back(number[joined.find(e)]);
  return materials;
}

// Node of corner c of material m, as the root of 8 m + c.
DisjointSets share_nodes(const std::vector<uint32_t>& begin, const BoxLinks& links,
                         const Materials& materials) {
  DisjointSets corners(8 * materials.cells.size());
  std::unordered_set<uint64_t> done;
  for_each_joint(begin, links, [&](uint32_t e, uint32_t f) {
    const uint32_t a = std::min(materials.of_entry[e], materials.of_entry[f]);
    const uint32_t b = std::max(materials.of_entry[e], materials.of_entry[f]);
    if (a == b || !neighbours(materials.cells[a], materials.cells[b])) return;
    if (!done.insert(uint64_t{a} << 32 | b).second) return;
    const Vector3i step = materials.cells[b] - materials.cells[a];
    for (uint32_t c = 0; c < 8; ++c) {
      const Vector3i there = corner_offset(c) - step;
      if ((there.array() < 0).any() || (there.array() > 1).any()) continue;
      corners.join(8 * a + c, 8 * b + static_cast<uint32_t>(there.x() | there.y() << 1 | there.z() << 2));
    }
  });
  return corners;
}

// The first material of a cell gets the cell's parity; the others get a colour that is free at their nodes.
// Returns a material without a free colour, or the number of materials.
uint32_t colour_materials(const std::vector<Vector3i>& cells,
                          const std::vector<std::array<uint32_t, 8>>& nodes, size_t node_count,
                          uint32_t colour_count, std::vector<uint32_t>& colours) {
  std::vector<uint64_t> taken(node_count, 0);  // colours at a node, as bits
  const auto take = [&](uint32_t m, uint32_t colour) {
    colours[m] = colour;
    for (const uint32_t node : nodes[m]) taken[node] |= uint64_t{1} << colour;
  };
  const auto count = static_cast<uint32_t>(cells.size());
  const auto is_first = [&](uint32_t m) { return m == 0 || cells[m - 1] != cells[m]; };
  colours.assign(count, 0);
  for (uint32_t m = 0; m < count; ++m) {
    if (is_first(m)) take(m, static_cast<uint32_t>(parity_of(cells[m])));
  }
  for (uint32_t m = 0; m < count; ++m) {
    if (is_first(m)) continue;
    uint64_t busy = 0;
    for (const uint32_t node : nodes[m]) busy |= taken[node];
    uint32_t colour = 0;
    while (colour < colour_count && (busy >> colour & 1) != 0) ++colour;
    if (colour == colour_count) return m;
    take(m, colour);
  }
  return count;
}

}  // namespace

BoxLinks link_boxes(const BodyExtent& extent, double max_gap_m) {
  const size_t count = extent.boxes.size();
  // A box represents at least the material within half its spacing.
  const double least_half_m = 0.5 * extent.spacing_m;
  double widest_half_m = 0.0;
  std::vector<Vector3d> halves(count);
  for (size_t i = 0; i < count; ++i) {
    halves[i] = extent.boxes[i].half_m.cwiseMax(least_half_m);
    widest_half_m = std::max(widest_half_m, halves[i].maxCoeff());
  }
  const auto gap_m = [&](uint32_t i, uint32_t j) {
    return ((extent.boxes[i].centre_m - extent.boxes[j].centre_m).cwiseAbs() - halves[i] - halves[j])
        .maxCoeff();
  };

  BoxLinks links;
  DisjointSets parts(count);
  const auto link = [&](uint32_t i, uint32_t j, double widest_m) {
    if (gap_m(i, j) > widest_m) return;
    links.emplace_back(std::min(i, j), std::max(i, j));
    parts.join(i, j);
  };
  double widest_m = kMaxLinkGap * std::max(extent.box_edge_m, extent.spacing_m);
  const BoxGrid touching(extent, 2.0 * widest_half_m + widest_m);
  for (uint32_t i = 0; i < count; ++i) {
    touching.for_each_near(i, [&](uint32_t j) {
      if (i < j) link(i, j, widest_m);
    });
  }

  // Bridges gaps: the smaller parts search with a growing range until they reach the rest.
  while (widest_m < max_gap_m) {
    std::vector<uint32_t> part(count), size(count, 0);
    for (uint32_t i = 0; i < count; ++i) ++size[part[i] = parts.find(i)];
    const auto largest = static_cast<uint32_t>(std::ranges::max_element(size) - size.begin());
    if (size[largest] == count) break;
    widest_m = std::min(2.0 * widest_m, max_gap_m);
    const BoxGrid near(extent, 2.0 * widest_half_m + widest_m);
    for (uint32_t i = 0; i < count; ++i) {
      if (part[i] == largest) continue;
      near.for_each_near(i, [&](uint32_t j) {
        if (part[j] != part[i] && (i < j || part[j] == largest)) link(i, j, widest_m);
      });
    }
  }
  std::ranges::sort(links);
  return links;
}

VirtualCells make_virtual_cells(std::span<const BoxInCell> entries, const BoxLinks& links,
                                uint32_t colour_count) {
  const std::vector<uint32_t> begin = entries_by_box(entries);
  DisjointSets joined(entries.size());
  for_each_joint(begin, links, [&](uint32_t e, uint32_t f) {
    if (entries[e].cell == entries[f].cell) joined.join(e, f);
  });

  while (true) {
    const Materials materials = number_materials(entries, joined);
    const auto count = static_cast<uint32_t>(materials.cells.size());
    DisjointSets corners = share_nodes(begin, links, materials);

    // Nodes by z, y, x; at one place by their first corner.
    const auto place_of = [&](uint32_t corner) -> Vector3i {
      return materials.cells[corner / 8] + corner_offset(corner % 8);
    };
    std::vector<uint32_t> roots;
    for (uint32_t corner = 0; corner < 8 * count; ++corner) {
      if (corners.find(corner) == corner) roots.push_back(corner);
    }
    std::ranges::sort(roots, {},
                      [&](uint32_t corner) { return std::pair(lattice_key(place_of(corner)), corner); });
    VirtualCells result;
    std::vector<uint32_t> node_of(8 * count);
    for (const uint32_t root : roots) {
      node_of[root] = static_cast<uint32_t>(result.node_coordinates.size());
      result.node_coordinates.push_back(place_of(root));
    }
    std::vector<std::array<uint32_t, 8>> nodes(count);
    for (uint32_t m = 0; m < count; ++m) {
      for (uint32_t c = 0; c < 8; ++c) nodes[m][c] = node_of[corners.find(8 * m + c)];
    }

    // Materials of one cell with the same eight nodes move as one and are merged.
    std::vector<std::pair<uint32_t, uint32_t>> same;
    for (uint32_t m = 1; m < count; ++m) {
      for (uint32_t n = m; n-- > 0 && materials.cells[n] == materials.cells[m];) {
        if (nodes[n] == nodes[m]) same.emplace_back(n, m);
      }
    }
    std::vector<uint32_t> colours;
    if (same.empty()) {
      const uint32_t uncoloured =
          colour_materials(materials.cells, nodes, roots.size(), colour_count, colours);
      if (uncoloured < count) same.emplace_back(uncoloured - 1, uncoloured);
    }
    if (!same.empty()) {
      std::vector<uint32_t> first_entry(count);
      for (uint32_t e = static_cast<uint32_t>(entries.size()); e-- > 0;)
        first_entry[materials.of_entry[e]] = e;
      for (const auto& [a, b] : same) joined.join(first_entry[a], first_entry[b]);
      continue;
    }

    std::vector<uint32_t> order(count), place(count);
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, {}, [&](uint32_t m) { return colours[m]; });
    for (const uint32_t m : order) {
      place[m] = static_cast<uint32_t>(result.cells.size());
      result.cells.push_back({materials.cells[m], nodes[m], colours[m]});
    }
    for (const uint32_t m : materials.of_entry) result.cell_of_entry.push_back(place[m]);
    return result;
  }
}

}  // namespace livegs
