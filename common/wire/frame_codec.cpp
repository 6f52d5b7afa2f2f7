// SPDX-License-Identifier: Apache-2.0
// The layout is proto/frame_format.md.
#include "wire/frame_codec.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "core/assert.h"
#include "wire/coding/packed_quaternion.h"
#include "wire/coding/quantised_box.h"
#include "wire/header.h"
#include "wire/little_endian.h"

namespace livegs {
namespace {

constexpr MessageHeader<uint32_t, uint16_t> kHeader{"driver frame", " with LVGF", 0x4647564C, 1};
constexpr uint8_t kSelfContained = 0;
constexpr uint8_t kAsleep = 1;

constexpr int kPoseBits = 21;
constexpr int kPositionBits = 16;

constexpr size_t kBoxBytes = 24;
constexpr size_t kFrameHeaderBytes = 28 + kBoxBytes;
constexpr size_t kObjectHeaderBytes = 12;
constexpr size_t kPoseBytes = 16;
constexpr size_t kPositionBytes = 6;
constexpr size_t kRotationBytes = 5;
constexpr size_t kRawPositionBytes = 12, kRawRotationBytes = 16;
// Tolerance of a unit quaternion stored as floats; the same as for other poses.
constexpr float kUnitTolerance = 1e-3f;

// Grows to contain points. NaN or infinity here is a programming error.
struct Bounds {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = -low;

  void add(const Eigen::Vector3d& point) {
    LIVEGS_ASSERT(point.cast<float>().allFinite());
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  QuantisedBox box() const { return low[0] > high[0] ? QuantisedBox{} : box_around(low, high); }
};

void write_box(ByteWriter& out, const QuantisedBox& box) {
  LIVEGS_ASSERT(box.is_valid());
  for (int d = 0; d < 3; ++d) out.write(box.min_m[d]);
  for (int d = 0; d < 3; ++d) out.write(box.edge_m[d]);
}

QuantisedBox read_box(ByteReader& in) {
  QuantisedBox box;
  for (int d = 0; d < 3; ++d) box.min_m[d] = in.read<float>();
  for (int d = 0; d < 3; ++d) box.edge_m[d] = in.read<float>();
  return box;
}

void write_pose(ByteWriter& out, const QuantisedBox& box, const Pose& pose) {
  const Eigen::Matrix<uint32_t, 3, 1> steps = box.quantise(pose.position_m, kPoseBits);
  out.write(uint64_t{steps[0]} | uint64_t{steps[1]} << kPoseBits | uint64_t{steps[2]} << (2 * kPoseBits));
  out.write(pack_quaternion(pose.orientation, kPoseComponentBits));
}

// Empty if a spare bit is set.
std::optional<Pose> read_pose(ByteReader& in, const QuantisedBox& box) {
  const uint64_t position = in.read<uint64_t>();
  const uint64_t orientation = in.read<uint64_t>();
  if ((position >> 63) != 0 || (orientation >> 62) != 0) return std::nullopt;
  constexpr uint64_t kMask = (uint64_t{1} << kPoseBits) - 1;
  const Eigen::Matrix<uint32_t, 3, 1> steps(static_cast<uint32_t>(position & kMask),
                                            static_cast<uint32_t>((position >> kPoseBits) & kMask),
                                            static_cast<uint32_t>((position >> (2 * kPoseBits)) & kMask));
  return Pose{box.position_m(steps, kPoseBits), unpack_quaternion(orientation, kPoseComponentBits)};
}

void write_raw(ByteWriter& out, const Eigen::Vector3f& position_m) {
  LIVEGS_ASSERT(position_m.allFinite());
  for (int d = 0; d < 3; ++d) out.write(position_m[d]);
}
void write_raw(ByteWriter& out, const Eigen::Quaternionf& rotation) {
  LIVEGS_ASSERT(rotation.coeffs().allFinite());
  for (int d = 0; d < 4; ++d) out.write(rotation.coeffs()[d]);
}

void write_raw_drivers(ByteWriter& out, const ObjectDrivers& object) {
  for (const Pose& pose : object.poses) {
    write_raw(out, Eigen::Vector3f(pose.position_m.cast<float>()));
    write_raw(out, pose.orientation.normalized().cast<float>());
  }
  for (size_t i = 0; i < object.positions_m.size(); ++i) {
    write_raw(out, object.positions_m[i]);
    if (object.kind == DriverKind::Particles) write_raw(out, object.rotations[i].normalized());
  }
}

Eigen::Vector3f read_raw_position(ByteReader& in) {
  const float x = in.read<float>(), y = in.read<float>(), z = in.read<float>();
  return {x, y, z};
}
Eigen::Quaternionf read_raw_rotation(ByteReader& in) {
  Eigen::Quaternionf rotation;
  for (int d = 0; d < 4; ++d) rotation.coeffs()[d] = in.read<float>();
  return rotation;
}
bool is_rotation(const Eigen::Quaternionf& rotation) {
  return std::abs(rotation.norm() - 1.0f) <= kUnitTolerance;
}  // not NaN

size_t raw_driver_bytes(DriverKind kind) {
  return kRawPositionBytes + (kind == DriverKind::Lattice ? 0 : kRawRotationBytes);
}

void write_object(ByteWriter& out, const QuantisedBox& frame_box, const ObjectDrivers& object,
                  DriverEncoding encoding) {
  const bool rigid = object.kind == DriverKind::Rigid;
  const size_t count = rigid ? object.poses.size() : object.positions_m.size();
  out.write(object.object_id);
  out.write(static_cast<uint8_t>(object.kind));
  out.write(static_cast<uint8_t>(object.asleep ? kAsleep : 0));
  out.write(static_cast<uint8_t>(encoding));
  out.write(static_cast<uint8_t>(object.revision));
  out.write(static_cast<uint32_t>(count));
  if (count == 0) return;
  if (encoding == DriverEncoding::Raw) return write_raw_drivers(out, object);
  if (rigid) {
    for (const Pose& pose : object.poses) write_pose(out, frame_box, pose);
    return;
  }
  Bounds bounds;
  for (const Eigen::Vector3f& position : object.positions_m) bounds.add(position.cast<double>());
  const QuantisedBox box = bounds.box();
  write_box(out, box);
  for (const Eigen::Vector3f& position : object.positions_m) {
    const Eigen::Matrix<uint32_t, 3, 1> steps = box.quantise(position.cast<double>(), kPositionBits);
    for (int d = 0; d < 3; ++d) out.write(static_cast<uint16_t>(steps[d]));
  }
  if (object.kind != DriverKind::Particles) return;
  LIVEGS_ASSERT(object.rotations.size() == count);
  for (const Eigen::Quaternionf& rotation : object.rotations) {
    LIVEGS_ASSERT(rotation.coeffs().allFinite());
    out.write_bits(pack_quaternion(rotation.cast<double>(), kParticleComponentBits), kRotationBytes);
  }
}

size_t encoded_size(const DriverFrame& frame, DriverEncoding encoding) {
  size_t size = kFrameHeaderBytes;
  for (const ObjectDrivers& object : frame.objects) {
    const size_t positions = object.positions_m.size();
    size += kObjectHeaderBytes;
    if (encoding == DriverEncoding::Raw) {
      size += raw_driver_bytes(object.kind) * std::max(positions, object.poses.size());
      continue;
    }
    if (object.kind == DriverKind::Rigid) {
      size += kPoseBytes * object.poses.size();
    } else if (positions > 0) {
      size += kBoxBytes +
              positions * (kPositionBytes + (object.kind == DriverKind::Particles ? kRotationBytes : 0));
    }
  }
  return size;
}

Error bad_object(size_t index, uint32_t object_id, const std::string& what) {
  return invalid_data("driver frame: object " + std::to_string(index) + " (id " + std::to_string(object_id) +
                      ") " + what);
}

// Preconditions: the kind of the object is set, and its bytes are available.
Result<ObjectDrivers> read_raw_drivers(ByteReader& in, size_t index, size_t count, ObjectDrivers object) {
  const uint32_t id = object.object_id;
  const bool rigid = object.kind == DriverKind::Rigid;
  for (size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f position_m = read_raw_position(in);
    if (!position_m.allFinite())
      return bad_object(index, id, "has a position that is not finite: driver " + std::to_string(i));
    if (!rigid) object.positions_m.push_back(position_m);
    if (object.kind == DriverKind::Lattice) continue;
    const Eigen::Quaternionf rotation = read_raw_rotation(in);
    if (!is_rotation(rotation))
      return bad_object(index, id, "has an invalid rotation: driver " + std::to_string(i));
    if (rigid)
      object.poses.push_back({position_m.cast<double>(), rotation.cast<double>().normalized()});
    else
      object.rotations.push_back(rotation.normalized());
  }
  return object;
}

Result<ObjectDrivers> read_object(ByteReader& in, size_t index, const QuantisedBox& frame_box) {
  ObjectDrivers object;
  object.object_id = in.read<uint32_t>();
  const uint8_t kind = in.read<uint8_t>();
  const uint8_t flags = in.read<uint8_t>();
  const uint8_t encoding = in.read<uint8_t>();
  const uint8_t revision = in.read<uint8_t>();
  const size_t count = in.read<uint32_t>();
  const uint32_t id = object.object_id;
  if (in.failed()) return bad_object(index, id, "is truncated");
  if (kind < static_cast<uint8_t>(DriverKind::Rigid) || kind > static_cast<uint8_t>(DriverKind::Particles)) {
    return bad_object(index, id, "has unknown kind " + std::to_string(kind));
  }
  if (encoding > static_cast<uint8_t>(DriverEncoding::Raw))
    return bad_object(index, id, "has unknown encoding " + std::to_string(encoding));
  object.kind = static_cast<DriverKind>(kind);
  if ((flags & ~kAsleep) != 0 || (revision != 0 && object.kind != DriverKind::Rigid)) {
    return bad_object(index, id, "sets a reserved bit");
  }
  object.revision = revision;
  object.asleep = (flags & kAsleep) != 0;
  if (count == 0) return object;

  // Counts are checked against the available bytes before any allocation.
  const bool rigid = object.kind == DriverKind::Rigid;
  if (encoding == static_cast<uint8_t>(DriverEncoding::Raw)) {
    if (count > in.remaining() / raw_driver_bytes(object.kind))
      return bad_object(index, id, "claims " + std::to_string(count) + " drivers but is truncated");
    return read_raw_drivers(in, index, count, std::move(object));
  }
  const size_t driver_bytes =
      rigid ? kPoseBytes : kPositionBytes + (object.kind == DriverKind::Particles ? kRotationBytes : 0);
  if (count > in.remaining() / driver_bytes ||
      count * driver_bytes + (rigid ? 0 : kBoxBytes) > in.remaining()) {
    return bad_object(index, id, "claims " + std::to_string(count) + " drivers but is truncated");
  }
  if (rigid) {
    object.poses.reserve(count);
    for (size_t i = 0; i < count; ++i) {
      const std::optional<Pose> pose = read_pose(in, frame_box);
      if (!pose) return bad_object(index, id, "sets a spare bit of pose " + std::to_string(i));
      object.poses.push_back(*pose);
    }
    return object;
  }
  const QuantisedBox box = read_box(in);
  if (!box.is_valid()) return bad_object(index, id, "has a box that is not finite or has negative edges");
  object.positions_m.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    Eigen::Matrix<uint32_t, 3, 1> steps;
    for (int d = 0; d < 3; ++d) steps[d] = in.read<uint16_t>();
    object.positions_m.push_back(box.position_m(steps, kPositionBits).cast<float>());
  }
  if (object.kind != DriverKind::Particles) return object;
  object.rotations.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    const uint64_t packed = in.read_bits(kRotationBytes);
    if ((packed >> (2 + 3 * kParticleComponentBits)) != 0) {
      return bad_object(index, id, "sets a spare bit of rotation " + std::to_string(i));
    }
    object.rotations.push_back(unpack_quaternion(packed, kParticleComponentBits).cast<float>());
  }
  return object;
}

}  // namespace

std::vector<std::byte> encode_frame(const DriverFrame& frame, DriverEncoding encoding) {
  Bounds bounds;
  for (const ObjectDrivers& object : frame.objects) {
    if (object.kind != DriverKind::Rigid || encoding == DriverEncoding::Raw) continue;
    for (const Pose& pose : object.poses) {
      LIVEGS_ASSERT(pose.orientation.coeffs().allFinite());
      bounds.add(pose.position_m);
    }
  }
  const QuantisedBox box = bounds.box();
  ByteWriter out;
  out.reserve(encoded_size(frame, encoding));
  kHeader.write(out);
  out.write(kSelfContained);
  out.write(uint8_t{0});
  out.write(frame.tick);
  out.write(frame.simulated_ns);
  out.write(static_cast<uint32_t>(frame.objects.size()));
  write_box(out, box);
  for (const ObjectDrivers& object : frame.objects) write_object(out, box, object, encoding);
  std::vector<std::byte> bytes = std::move(out).take();
  LIVEGS_ASSERT(bytes.size() <= kMaxFrameBytes);
  return bytes;
}

Result<DriverFrame> decode_frame(std::span<const std::byte> bytes) {
  if (bytes.size() > kMaxFrameBytes) {
    return Error{ErrorCode::TooLarge, "driver frame: " + std::to_string(bytes.size()) +
                                          " bytes exceed the limit of " + std::to_string(kMaxFrameBytes)};
  }
  ByteReader in(bytes);
  const uint32_t magic = in.read<uint32_t>();
  const uint16_t version = in.read<uint16_t>();
  const uint8_t encoding = in.read<uint8_t>();
  const uint8_t reserved = in.read<uint8_t>();
  if (auto known = kHeader.check(magic, version, in.failed()); !known) return known.error();
  if (encoding != kSelfContained) {
    return unsupported("driver frame: unknown encoding " + std::to_string(encoding));
  }
  if (reserved != 0) return invalid_data("driver frame: sets a reserved bit");
  DriverFrame frame;
  frame.tick = in.read<uint64_t>();
  frame.simulated_ns = in.read<int64_t>();
  const size_t object_count = in.read<uint32_t>();
  const QuantisedBox box = read_box(in);
  if (in.failed()) return invalid_data("driver frame: header is truncated");
  if (!box.is_valid()) return invalid_data("driver frame: box is not finite or has negative edges");
  if (object_count > in.remaining() / kObjectHeaderBytes) {
    return invalid_data("driver frame: claims " + std::to_string(object_count) + " objects but is truncated");
  }
  frame.objects.reserve(object_count);
  for (size_t i = 0; i < object_count; ++i) {
    Result<ObjectDrivers> object = read_object(in, i, box);
    if (!object) return object.error();
    frame.objects.push_back(std::move(*object));
  }
  if (in.remaining() != 0) {
    return invalid_data("driver frame: " + std::to_string(in.remaining()) + " bytes left over");
  }
  return frame;
}

}  // namespace livegs
