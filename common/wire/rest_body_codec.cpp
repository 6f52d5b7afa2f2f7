// SPDX-License-Identifier: Apache-2.0
#include "wire/rest_body_codec.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/assert.h"
#include "wire/header.h"
#include "wire/little_endian.h"

namespace livegs {
namespace {

constexpr MessageHeader<uint32_t, uint16_t> kRestBodyHeader{"rest body", " with LVGR", 0x5247564C, 1};
constexpr uint8_t kPlain = 0;
constexpr uint8_t kWithFills = 1;  // lattice
constexpr uint8_t kWithRuns = 1;   // rigid object
constexpr size_t kPoseBytes = 7 * 8;
constexpr size_t kRunBytes = 2 * 4;
constexpr size_t kParticleBytes = 3 * 4;

// Tolerance of the length of a unit quaternion.
constexpr double kUnitTolerance = 1e-3;

template <class Vector>
void write_vector(ByteWriter& out, const Vector& vector) {
  for (Eigen::Index i = 0; i < vector.size(); ++i) out.write(vector[i]);
}

void write_pose(ByteWriter& out, const Pose& pose) {
  write_vector(out, pose.position_m);
  write_vector(out, pose.orientation.coeffs());
}

Eigen::Vector3d read_vector3(ByteReader& in) {
  Eigen::Vector3d vector;
  for (int i = 0; i < 3; ++i) vector[i] = in.read<double>();
  return vector;
}

Eigen::Quaterniond read_quaternion(ByteReader& in) {
  Eigen::Quaterniond quaternion;
  for (int i = 0; i < 4; ++i) quaternion.coeffs()[i] = in.read<double>();
  return quaternion;
}

Pose read_pose(ByteReader& in) {
  Pose pose;
  pose.position_m = read_vector3(in);
  pose.orientation = read_quaternion(in);
  return pose;
}

bool is_unit(const Eigen::Quaterniond& quaternion) {
  return std::abs(quaternion.norm() - 1.0) <= kUnitTolerance;  // false for NaN
}

bool is_valid(const Pose& pose) { return pose.position_m.allFinite() && is_unit(pose.orientation); }

Error cut_short(const char* what) {
  return invalid_data(std::string("rest body: ") + what + " is truncated");
}

void write_lattice(ByteWriter& out, const RestBody& rest) {
  Eigen::Vector3i lowest = Eigen::Vector3i::Zero();
  uint32_t span = 0;
  if (!rest.node_coordinates.empty()) {
    lowest = rest.node_coordinates[0];
    Eigen::Vector3i highest = lowest;
    for (const Eigen::Vector3i& node : rest.node_coordinates) {
      lowest = lowest.cwiseMin(node);
      highest = highest.cwiseMax(node);
    }
    for (int d = 0; d < 3; ++d) {
      span = std::max(span, static_cast<uint32_t>(int64_t{highest[d]} - lowest[d]));
    }
  }
  const uint8_t coordinate_bytes = span <= 0xFF ? 1 : span <= 0xFFFF ? 2 : 4;
  const uint8_t index_bytes = rest.node_coordinates.size() <= 0x10000 ? 2 : 4;
  write_pose(out, rest.object_from_lattice);
  out.write(rest.cell_width_m);
  out.write(static_cast<uint32_t>(rest.node_coordinates.size()));
  out.write(static_cast<uint32_t>(rest.cells.size()));
  write_vector(out, lowest);
  out.write(coordinate_bytes);
  out.write(index_bytes);
  for (const Eigen::Vector3i& node : rest.node_coordinates) {
    for (int d = 0; d < 3; ++d) {
      out.write_bits(static_cast<uint64_t>(int64_t{node[d]} - lowest[d]), coordinate_bytes);
    }
  }
  for (const std::array<uint32_t, 8>& cell : rest.cells) {
    for (const uint32_t node : cell) {
      LIVEGS_ASSERT(node < rest.node_coordinates.size());
      out.write_bits(node, index_bytes);
    }
  }
  LIVEGS_ASSERT(rest.cell_fills.empty() || rest.cell_fills.size() == rest.cells.size());
  for (const uint64_t fill : rest.cell_fills) out.write(fill);
}

Result<void> read_lattice(ByteReader& in, bool with_fills, RestBody& rest) {
  rest.object_from_lattice = read_pose(in);
  rest.cell_width_m = in.read<double>();
  const size_t node_count = in.read<uint32_t>();
  const size_t cell_count = in.read<uint32_t>();
  Eigen::Vector3i lowest;
  for (int d = 0; d < 3; ++d) lowest[d] = in.read<int32_t>();
  const size_t coordinate_bytes = in.read<uint8_t>();
  const size_t index_bytes = in.read<uint8_t>();
  if (in.failed()) return cut_short("lattice header");
  if (!is_valid(rest.object_from_lattice))
    return invalid_data("rest body: object_from_lattice is not a rigid transform");
  if (!std::isfinite(rest.cell_width_m) || rest.cell_width_m <= 0.0) {
    return invalid_data("rest body: cell width must be positive");
  }
  if (coordinate_bytes != 1 && coordinate_bytes != 2 && coordinate_bytes != 4) {
    return invalid_data("rest body: " + std::to_string(coordinate_bytes) +
                        " bytes per coordinate instead of 1, 2 or 4");
  }
  if (index_bytes != 2 && index_bytes != 4) {
    return invalid_data("rest body: " + std::to_string(index_bytes) + " bytes per index instead of 2 or 4");
  }
  const size_t bytes_a_cell = 8 * index_bytes + (with_fills ? 8 : 0);
  if (node_count * 3 * coordinate_bytes + cell_count * bytes_a_cell > in.remaining()) {
    return cut_short("lattice");
  }
  rest.node_coordinates.reserve(node_count);
  for (size_t n = 0; n < node_count; ++n) {
    Eigen::Vector3i node;
    for (int d = 0; d < 3; ++d) {
      const int64_t coordinate = int64_t{lowest[d]} + static_cast<int64_t>(in.read_bits(coordinate_bytes));
      if (coordinate > std::numeric_limits<int32_t>::max()) {
        return invalid_data("rest body: node " + std::to_string(n) + " has a coordinate beyond 32 bits");
      }
      node[d] = static_cast<int32_t>(coordinate);
    }
    rest.node_coordinates.push_back(node);
  }
  rest.cells.resize(cell_count);
  for (size_t c = 0; c < cell_count; ++c) {
    for (uint32_t& node : rest.cells[c]) {
      node = static_cast<uint32_t>(in.read_bits(index_bytes));
      if (node >= node_count) {
        return invalid_data("rest body: cell " + std::to_string(c) + " refers to node " +
                            std::to_string(node) + " of " + std::to_string(node_count));
      }
    }
  }
  if (with_fills) {
    rest.cell_fills.resize(cell_count);
    for (uint64_t& fill : rest.cell_fills) fill = in.read<uint64_t>();
  }
  return {};
}

Result<void> read_rigid(ByteReader& in, bool with_runs, RestBody& rest) {
  const size_t count = in.read<uint32_t>();
  if (in.failed() || count > in.remaining() / kPoseBytes) return cut_short("list of bodies");
  rest.bodies.reserve(count);
  for (size_t b = 0; b < count; ++b) {
    rest.bodies.push_back(read_pose(in));
    if (!is_valid(rest.bodies.back())) {
      return invalid_data("rest body: body " + std::to_string(b) + " has an invalid pose");
    }
  }
  if (!with_runs) return {};
  rest.revision = in.read<uint32_t>();
  const size_t run_count = in.read<uint32_t>();
  if (in.failed() || run_count > in.remaining() / kRunBytes) return cut_short("list of kernel runs");
  if (rest.revision == 0 || rest.revision > kMaxRevision) {
    return invalid_data("rest body: revision " + std::to_string(rest.revision) +
                        " of a broken object is not from 1 to " + std::to_string(kMaxRevision));
  }
  for (size_t r = 0; r < run_count; ++r) {
    RestBody::KernelRun run;
    run.body = in.read<uint32_t>();
    run.count = in.read<uint32_t>();
    if (run.body >= count) {
      return invalid_data("rest body: kernel run " + std::to_string(r) + " refers to body " +
                          std::to_string(run.body) + " of " + std::to_string(count));
    }
    rest.kernel_runs.push_back(run);
  }
  return {};
}

Result<void> read_particles(ByteReader& in, RestBody& rest) {
  const size_t count = in.read<uint32_t>();
  if (in.failed() || count > in.remaining() / kParticleBytes) return cut_short("list of particles");
  rest.particles_m.reserve(count);
  for (size_t p = 0; p < count; ++p) {
    const float x = in.read<float>(), y = in.read<float>(), z = in.read<float>();
    rest.particles_m.emplace_back(x, y, z);
    if (!rest.particles_m.back().allFinite()) {
      return invalid_data("rest body: particle " + std::to_string(p) + " is not finite");
    }
  }
  return {};
}

}  // namespace

std::vector<std::byte> encode_rest_body(const RestBody& rest) {
  ByteWriter out;
  kRestBodyHeader.write(out);
  out.write(static_cast<uint8_t>(rest.kind));
  LIVEGS_ASSERT(rest.revision <= kMaxRevision && (rest.kind == DriverKind::Rigid || rest.revision == 0));
  out.write(rest.revision > 0 ? kWithRuns : rest.cell_fills.empty() ? kPlain : kWithFills);
  out.write(rest.object_from_asset.scale);
  write_vector(out, rest.object_from_asset.rotation.coeffs());
  write_vector(out, rest.object_from_asset.translation_m);
  switch (rest.kind) {
    case DriverKind::Rigid:
      out.write(static_cast<uint32_t>(rest.bodies.size()));
      for (const Pose& body : rest.bodies) write_pose(out, body);
      if (rest.revision == 0) break;
      out.write(rest.revision);
      out.write(static_cast<uint32_t>(rest.kernel_runs.size()));
      for (const RestBody::KernelRun& run : rest.kernel_runs) {
        out.write(run.body);
        out.write(run.count);
      }
      break;
    case DriverKind::Lattice:
      write_lattice(out, rest);
      break;
    case DriverKind::Particles:
      out.write(static_cast<uint32_t>(rest.particles_m.size()));
      for (const Eigen::Vector3f& particle : rest.particles_m) write_vector(out, particle);
      break;
  }
  std::vector<std::byte> bytes = std::move(out).take();
  LIVEGS_ASSERT(bytes.size() <= kMaxRestBodyBytes);
  return bytes;
}

Result<RestBody> decode_rest_body(std::span<const std::byte> bytes) {
  if (bytes.size() > kMaxRestBodyBytes) {
    return Error{ErrorCode::TooLarge, "rest body: " + std::to_string(bytes.size()) +
                                          " bytes exceed the limit of " + std::to_string(kMaxRestBodyBytes)};
  }
  ByteReader in(bytes);
  const uint32_t magic = in.read<uint32_t>();
  const uint16_t version = in.read<uint16_t>();
  const uint8_t kind = in.read<uint8_t>();
  const uint8_t encoding = in.read<uint8_t>();
  if (auto known = kRestBodyHeader.check(magic, version, in.failed()); !known) return known.error();
  const bool with_fills = encoding == kWithFills && kind == static_cast<uint8_t>(DriverKind::Lattice);
  const bool with_runs = encoding == kWithRuns && kind == static_cast<uint8_t>(DriverKind::Rigid);
  if (encoding != kPlain && !with_fills && !with_runs)
    return unsupported("rest body: unknown encoding " + std::to_string(encoding));
  RestBody rest;
  Similarity& to_object = rest.object_from_asset;
  to_object.scale = in.read<double>();
  to_object.rotation = read_quaternion(in);
  to_object.translation_m = read_vector3(in);
  if (in.failed()) return cut_short("header");
  if (!std::isfinite(to_object.scale) || to_object.scale <= 0.0 || !is_unit(to_object.rotation) ||
      !to_object.translation_m.allFinite()) {
    return invalid_data("rest body: object_from_asset is not a similarity");
  }
  Result<void> read = [&]() -> Result<void> {
    switch (kind) {
      case static_cast<uint8_t>(DriverKind::Rigid):
        return read_rigid(in, with_runs, rest);
      case static_cast<uint8_t>(DriverKind::Lattice):
        return read_lattice(in, with_fills, rest);
      case static_cast<uint8_t>(DriverKind::Particles):
        return read_particles(in, rest);
    }
    return invalid_data("rest body: unknown kind " + std::to_string(kind));
  }();
  if (!read) return read.error();
  rest.kind = static_cast<DriverKind>(kind);
  if (in.remaining() != 0)
    return invalid_data("rest body: " + std::to_string(in.remaining()) + " bytes left over");
  return rest;
}

}  // namespace livegs
