// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "capture/read/pose_files.h"
#include "core/file.h"
#include "gaussian/ply/ply_header.h"
#include "gaussian/ply/ply_rows.h"

namespace livegs {

Result<void> read_point_cloud(const std::filesystem::path& file, std::vector<Eigen::Vector3f>& points,
                              std::vector<Eigen::Vector3f>& colours) {
  const std::string name = file.filename().string();
  const auto bytes = read_file(file);
  if (!bytes) return bytes.error();
  const auto header = parse_ply_header(*bytes, name);
  if (!header) return header.error();
  const PlyElement* vertex = header->find("vertex");
  if (!vertex) return invalid_data(name + ": has no element vertex");
  std::array<std::optional<size_t>, 6> property;
  const std::array<const char*, 6> names{"x", "y", "z", "red", "green", "blue"};
  bool coloured = true;
  for (size_t i = 0; i < 6; ++i) {
    property[i] = vertex->find(names[i]);
    if (property[i] && vertex->properties[*property[i]].list_count_type) property[i].reset();
    if (!property[i] && i < 3) return invalid_data(name + ": element vertex has no property " + names[i]);
    coloured = coloured && property[i];
  }
  points.resize(vertex->count);
  colours.assign(vertex->count, Eigen::Vector3f::Constant(0.5f));
  std::vector<PlyColumn> columns;
  if (vertex->count == 0) return {};
  for (size_t i = 0; i < (coloured ? 6u : 3u); ++i) {
    float* first = i < 3 ? points[0].data() + i : colours[0].data() + i - 3;
    columns.push_back({*property[i], first, nullptr, 3});
  }
  PlyRows rows(*header, *bytes, name);
  for (const PlyElement& element : header->elements) {
    const bool wanted = &element == vertex;
    if (auto read =
            rows.read(element, wanted ? std::span<const PlyColumn>(columns) : std::span<const PlyColumn>{});
        !read)
      return read.error();
    if (wanted) break;
  }
  if (coloured) {
    const PlyScalar type = vertex->properties[*property[3]].type;
    const float full = type == PlyScalar::Float32 || type == PlyScalar::Float64 ? 1.0f : 255.0f;
    for (Eigen::Vector3f& colour : colours) colour = (colour / full).cwiseMax(0.0f).cwiseMin(1.0f);
  }
  return {};
}

}  // namespace livegs
