// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/mesh/mesh_io.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/file.h"

namespace livegs {
namespace {

constexpr uint64_t kMaxObjBytes = uint64_t{256} << 20;
// Maximum coordinate, metres. Larger values lose precision in squares and products of lengths.
constexpr double kMaxCoordinate_m = 1e9;

// Removes the first word of `line` and returns it; empty at the end.
std::string_view next_word(std::string_view& line) {
  const size_t begin = line.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return line = {};
  const size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

template <class Number>
bool parse(std::string_view word, Number& value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

}  // namespace

Result<TriangleMesh> read_obj(const std::filesystem::path& path) {
  auto text = read_text_file(path, kMaxObjBytes);
  if (!text) return text.error();
  TriangleMesh mesh;
  std::vector<uint32_t> polygon;
  std::string_view rest = *text;
  for (size_t line_number = 1; !rest.empty(); ++line_number) {
    const size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    const auto fail = [&](const std::string& what) {
      return invalid_data(path.string() + ": line " + std::to_string(line_number) + ": " + what +
                          "; export the mesh again");
    };
    const std::string_view keyword = next_word(line);
    if (keyword == "v") {
      Eigen::Vector3d vertex;
      for (int axis = 0; axis < 3; ++axis) {
        if (!parse(next_word(line), vertex[axis])) return fail("a vertex needs three numbers");
        if (!(std::abs(vertex[axis]) <= kMaxCoordinate_m))
          return fail("a coordinate is not finite or exceeds 1e9 m");
      }
      mesh.vertices_m.push_back(vertex);
    } else if (keyword == "f") {
      polygon.clear();
      for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
        int64_t index = 0;
        if (!parse(word.substr(0, word.find('/')), index)) return fail("a face index is not a number");
        const auto count = static_cast<int64_t>(mesh.vertices_m.size());
        if (index < 0) index += count + 1;
        if (index < 1 || index > count) return fail("a face refers to a vertex that does not exist");
        polygon.push_back(static_cast<uint32_t>(index - 1));
      }
      if (polygon.size() < 3) return fail("a face needs three vertices");
      for (size_t k = 2; k < polygon.size(); ++k) {
        const std::array<uint32_t, 3> triangle{polygon[0], polygon[k - 1], polygon[k]};
        if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0]) {
          mesh.triangles.push_back(triangle);
        }
      }
    }
  }
  if (mesh.triangles.empty())
    return invalid_data(path.string() + ": no face; give a Wavefront .obj file with a surface");
  return mesh;
}

}  // namespace livegs
