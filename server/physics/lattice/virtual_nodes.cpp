// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/lattice/virtual_nodes.h"

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <unordered_set>

#include "core/disjoint_sets.h"
#include "physics/lattice/lattice_order.h"

namespace livegs {
namespace {

using Eigen::Vector3i;
using Links = std::span<const std::pair<uint32_t, uint32_t>>;

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
void for_each_joint(const std::vector<uint32_t>& begin, Links links, Take take) {
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
  std::sort(roots.begin(), roots.end(), [&](uint32_t a, uint32_t b) {
    return std::make_pair(lattice_key(entries[a].cell), a) < std::make_pair(lattice_key(entries[b].cell), b);
  });
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
DisjointSets share_nodes(const std::vector<uint32_t>& begin, Links links, const Materials& materials) {
  DisjointSets corners(8 * materials.cells.size());
  std::unordered_set<uint64_t> done;
  for_each_joint(begin, links, [&](uint32_t e, uint32_t f) {
    const uint32_t a = std::min(materials.of_entry[e], materials.of_entry[f]);
    const uint32_t b = std::max(materials.of_entry[e], materials.of_entry[f]);
    if (a == b || !neighbours(materials.cells[a], materials.cells[b])) return;
    if (!done.insert(uint64_t{a} << 32 | b).second) return;
    const Vector3i step = materials.cells[b] - materials.cells[a];
    for (uint32_t c = 0; c < 8; ++c) {
      const Vector3i there = corner_offset(static_cast<int>(c)) - step;
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
    if (is_first(m)) take(m, static_cast<uint32_t>(colour_of(cells[m])));
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

VirtualCells make_virtual_cells(std::span<const BoxInCell> entries, Links links, uint32_t colour_count) {
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
      return materials.cells[corner / 8] + corner_offset(static_cast<int>(corner % 8));
    };
    std::vector<uint32_t> roots;
    for (uint32_t corner = 0; corner < 8 * count; ++corner) {
      if (corners.find(corner) == corner) roots.push_back(corner);
    }
    std::sort(roots.begin(), roots.end(), [&](uint32_t a, uint32_t b) {
      return std::make_pair(lattice_key(place_of(a)), a) < std::make_pair(lattice_key(place_of(b)), b);
    });
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
    std::stable_sort(order.begin(), order.end(),
                     [&](uint32_t a, uint32_t b) { return colours[a] < colours[b]; });
    for (const uint32_t m : order) {
      place[m] = static_cast<uint32_t>(result.cells.size());
      result.cells.push_back({materials.cells[m], nodes[m], colours[m]});
    }
    for (const uint32_t m : materials.of_entry) result.cell_of_entry.push_back(place[m]);
    return result;
  }
}

}  // namespace livegs
