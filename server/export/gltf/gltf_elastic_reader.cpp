// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "export/gltf/gltf_values.h"

namespace livegs::gltf {

Result<PortableElastic> read_elastic(const Values& values, const Json& json, const std::string& where) {
  PortableElastic elastic;
  for (const ElasticNumber& one : kElasticNumbers) {
    const auto read = values.number(json, one.name, elastic.*one.value, where);
    if (!read) return read.error();
    elastic.*one.value = *read;
  }
  if (json.contains("accuracy") && !read_message(json["accuracy"], elastic.accuracy))
    return values.bad(where, "has no valid elastic.accuracy");
  if (const Json& regions = part_of(json, "regions"); regions.is_array()) {
    for (const Json& region : regions) {
      if (!read_message(region, elastic.regions.emplace_back()))
        return values.bad(where, "has no valid elastic.regions");
    }
  }
  const Json& lattice = part_of(json, "lattice");
  if (lattice.is_object()) {
    RestBody& rest = elastic.lattice;
    rest.kind = DriverKind::Lattice;
    const auto width = values.number(lattice, "cell_width_m", 0, where);
    const auto position = values.vector(lattice, "translation", Eigen::Vector3d::Zero(), where);
    const auto orientation = values.quaternion(lattice, "rotation", where);
    const auto nodes = values.document().numbers(part_of(lattice, "nodes"), 3);
    if (!width) return width.error();
    if (!position) return position.error();
    if (!orientation) return orientation.error();
    if (!nodes) return nodes.error();
    if (auto within = values.spend(3 * nodes->count); !within) return within.error();
    if (!(*width > 0)) return values.bad(where, "has a lattice without a cell_width_m above 0");
    rest.cell_width_m = *width;
    rest.object_from_lattice = {*position, *orientation};
    for (size_t i = 0; i < nodes->count; ++i) {
      Eigen::Vector3i node;
      for (size_t axis = 0; axis < 3; ++axis) {
        const double value = nodes->at(i, axis);
        if (!(std::abs(value) <= 1e6 && value == std::floor(value)))
          return values.bad(where, "has a lattice node that is not a whole number");
        node[static_cast<int>(axis)] = static_cast<int>(value);
      }
      rest.node_coordinates.push_back(node);
    }
    if (lattice.contains("cells")) {
      const auto cells = values.whole_numbers(lattice["cells"]);
      if (!cells) return cells.error();
      if (cells->size() % 8 != 0) return values.bad(where, "has a lattice cell without eight nodes");
      for (const uint32_t node : *cells) {
        if (node >= rest.node_coordinates.size())
          return values.bad(where, "has a lattice cell of a node that does not exist");
      }
      for (size_t i = 0; i < cells->size(); i += 8) {
        std::copy_n(cells->begin() + static_cast<std::ptrdiff_t>(i), 8, rest.cells.emplace_back().begin());
      }
    }
    if (lattice.contains("cell_fills")) {
      const auto fills = values.whole_numbers(lattice["cell_fills"]);
      if (!fills) return fills.error();
      if (fills->size() != 2 * rest.cells.size())
        return values.bad(where, "has the wrong number of cell_fills");
      for (size_t i = 0; i < fills->size(); i += 2)
        rest.cell_fills.push_back((*fills)[i] | uint64_t{(*fills)[i + 1]} << 32);
    }
  }
  return elastic;
}

}  // namespace livegs::gltf
