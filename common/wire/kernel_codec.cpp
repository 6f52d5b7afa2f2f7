// SPDX-License-Identifier: Apache-2.0
// The layout is proto/frame_format.md, "Kernels".
#include "wire/kernel_codec.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/assert.h"
#include "wire/coding/packed_quaternion.h"
#include "wire/coding/quantised_box.h"
#include "wire/frame_codec.h"
#include "wire/header.h"
#include "wire/little_endian.h"
#include "wire/rest_body_codec.h"

namespace livegs {
namespace {

constexpr MessageHeader<uint8_t, uint8_t> kHeader{"kernel frame", " with 0xD8", 0xD8, 2};
constexpr size_t kObjectHeaderBytes = 9, kBoxBytes = 24;
constexpr size_t kExactBytes = 52, kQuantisedBytes = 20;
constexpr int kPositionBits = 16, kComponentBits = 12, kDeviationBits = 10;
constexpr size_t kDeviationBytes = 4, kRotationBytes = 5;
constexpr double kMinDeviationLog2 = -20, kDeviationOctaves = 24;  // 2^-20 m (1 µm) to 2^4 m
constexpr double kLastDeviation = (1 << kDeviationBits) - 1;

uint32_t quantised_deviation(double variance_m2) {
  const double log2_m = 0.5 * std::log2(std::max(variance_m2, 1e-30));
  return static_cast<uint32_t>(
      std::lround(std::clamp((log2_m - kMinDeviationLog2) / kDeviationOctaves, 0.0, 1.0) * kLastDeviation));
}
double deviation_m(uint32_t steps) {
  return std::exp2(kMinDeviationLog2 + kDeviationOctaves * steps / kLastDeviation);
}

// Standard deviations along the principal axes, and the axes as a rotation.
void write_shape(ByteWriter& out, const Symmetric3f& covariance_m2) {
  const Symmetric3f& s = covariance_m2;
  Eigen::Matrix3d m;
  m << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  LIVEGS_ASSERT(m.allFinite());
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes;
  axes.computeDirect(m);
  Eigen::Matrix3d turn = axes.eigenvectors();
  if (turn.determinant() < 0) turn.col(0) = -turn.col(0);
  uint32_t deviations = 0;
  for (int d = 0; d < 3; ++d)
    deviations |= quantised_deviation(axes.eigenvalues()[d]) << (kDeviationBits * d);
  out.write_bits(deviations, kDeviationBytes);
  out.write_bits(pack_quaternion(Eigen::Quaterniond(turn).normalized(), kComponentBits), kRotationBytes);
}

Symmetric3f shape_of(uint32_t deviations, uint64_t rotation) {
  constexpr uint32_t kMask = (1u << kDeviationBits) - 1;
  Eigen::Matrix3d turn = unpack_quaternion(rotation, kComponentBits).toRotationMatrix();
  for (int d = 0; d < 3; ++d) turn.col(d) *= deviation_m(deviations >> (kDeviationBits * d) & kMask);
  const Eigen::Matrix3f m = (turn * turn.transpose()).cast<float>();
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}

void write_exact(ByteWriter& out, const PosedKernels& kernels) {
  for (size_t k = 0; k < kernels.positions_m.size(); ++k) {
    LIVEGS_ASSERT(kernels.positions_m[k].allFinite() && kernels.world_from_asset[k].coeffs().allFinite());
    for (int d = 0; d < 3; ++d) out.write(kernels.positions_m[k][d]);
    for (const float entry : kernels.covariances_m2[k]) out.write(entry);
    for (int d = 0; d < 4; ++d) out.write(kernels.world_from_asset[k].coeffs()[d]);
  }
}

void write_quantised(ByteWriter& out, const PosedKernels& kernels) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Eigen::Vector3f& position : kernels.positions_m) {
    LIVEGS_ASSERT(position.allFinite());
    low = low.cwiseMin(position.cast<double>());
    high = high.cwiseMax(position.cast<double>());
  }
  const QuantisedBox box = box_around(low, high);
  for (int d = 0; d < 3; ++d) out.write(box.min_m[d]);
  for (int d = 0; d < 3; ++d) out.write(box.edge_m[d]);
  for (size_t k = 0; k < kernels.positions_m.size(); ++k) {
    const Eigen::Matrix<uint32_t, 3, 1> steps =
        box.quantise(kernels.positions_m[k].cast<double>(), kPositionBits);
    for (int d = 0; d < 3; ++d) out.write(static_cast<uint16_t>(steps[d]));
    write_shape(out, kernels.covariances_m2[k]);
    out.write_bits(pack_quaternion(kernels.world_from_asset[k].cast<double>(), kComponentBits),
                   kRotationBytes);
  }
}

Error bad(const std::string& what) { return kHeader.invalid(what); }

Result<void> read_exact(ByteReader& in, PosedKernels& kernels) {
  for (size_t k = 0; k < kernels.positions_m.size(); ++k) {
    bool finite = true;
    const auto read = [&] {
      const float value = in.read<float>();
      finite = finite && std::isfinite(value);
      return value;
    };
    for (int d = 0; d < 3; ++d) kernels.positions_m[k][d] = read();
    for (float& entry : kernels.covariances_m2[k]) entry = read();
    for (int d = 0; d < 4; ++d) kernels.world_from_asset[k].coeffs()[d] = read();
    if (!finite) return bad("kernel " + std::to_string(k) + " of an object is not finite");
  }
  return {};
}

Result<void> read_quantised(ByteReader& in, PosedKernels& kernels) {
  QuantisedBox box;
  for (int d = 0; d < 3; ++d) box.min_m[d] = in.read<float>();
  for (int d = 0; d < 3; ++d) box.edge_m[d] = in.read<float>();
  if (!box.is_valid()) return bad("the box of an object is not finite or has negative edges");
  for (size_t k = 0; k < kernels.positions_m.size(); ++k) {
    Eigen::Matrix<uint32_t, 3, 1> steps;
    for (int d = 0; d < 3; ++d) steps[d] = in.read<uint16_t>();
    const uint32_t deviations = static_cast<uint32_t>(in.read_bits(kDeviationBytes));
    const uint64_t axes = in.read_bits(kRotationBytes), rotation = in.read_bits(kRotationBytes);
    constexpr int kUsed = 2 + 3 * kComponentBits;
    if (deviations >> (3 * kDeviationBits) != 0 || axes >> kUsed != 0 || rotation >> kUsed != 0)
      return bad("kernel " + std::to_string(k) + " of an object sets a spare bit");
    kernels.positions_m[k] = box.position_m(steps, kPositionBits).cast<float>();
    kernels.covariances_m2[k] = shape_of(deviations, axes);
    kernels.world_from_asset[k] = unpack_quaternion(rotation, kComponentBits).cast<float>();
  }
  return {};
}

}  // namespace

size_t kernel_bytes(size_t kernels, KernelEncoding encoding) {
  return kObjectHeaderBytes + kBoxBytes +
         kernels * (encoding == KernelEncoding::Exact ? kExactBytes : kQuantisedBytes);
}

std::vector<std::byte> encode_kernels(const KernelFrame& frame, KernelEncoding encoding) {
  const bool exact = encoding == KernelEncoding::Exact;
  size_t size = kKernelFrameHeaderBytes;
  for (const ObjectKernels& object : frame.objects)
    size += kernel_bytes(object.kernels.positions_m.size(), encoding);
  ByteWriter out;
  out.reserve(size);
  kHeader.write(out);
  out.write(static_cast<uint8_t>(encoding));
  out.write(uint8_t{0});
  out.write(frame.tick);
  out.write(frame.simulated_ns);
  out.write(static_cast<uint32_t>(frame.objects.size()));
  for (const ObjectKernels& object : frame.objects) {
    const PosedKernels& kernels = object.kernels;
    LIVEGS_ASSERT(kernels.covariances_m2.size() == kernels.positions_m.size() &&
                  kernels.world_from_asset.size() == kernels.positions_m.size());
    LIVEGS_ASSERT(object.revision <= kMaxRevision);
    out.write(object.object_id);
    out.write(static_cast<uint8_t>(object.revision));
    out.write(static_cast<uint32_t>(kernels.positions_m.size()));
    if (kernels.positions_m.empty()) continue;
    exact ? write_exact(out, kernels) : write_quantised(out, kernels);
  }
  std::vector<std::byte> bytes = std::move(out).take();
  LIVEGS_ASSERT(bytes.size() <= kMaxFrameBytes);
  return bytes;
}

Result<KernelFrame> decode_kernels(std::span<const std::byte> bytes) {
  if (bytes.size() > kMaxFrameBytes)
    return Error{ErrorCode::TooLarge,
                 "kernel frame: larger than the limit of " + std::to_string(kMaxFrameBytes) + " bytes"};
  ByteReader in(bytes);
  const uint8_t magic = in.read<uint8_t>(), version = in.read<uint8_t>(), encoding = in.read<uint8_t>(),
                reserved = in.read<uint8_t>();
  KernelFrame frame;
  frame.tick = in.read<uint64_t>();
  frame.simulated_ns = in.read<int64_t>();
  const size_t object_count = in.read<uint32_t>();
  if (auto known = kHeader.check(magic, version, in.failed()); !known) return known.error();
  if (encoding > static_cast<uint8_t>(KernelEncoding::Quantised))
    return bad("has unknown encoding " + std::to_string(encoding));
  if (reserved != 0) return bad("sets a reserved bit");
  const bool exact = encoding == static_cast<uint8_t>(KernelEncoding::Exact);
  if (object_count > in.remaining() / kObjectHeaderBytes)
    return bad("claims more objects than its bytes can hold");
  for (size_t i = 0; i < object_count; ++i) {
    ObjectKernels& object = frame.objects.emplace_back();
    object.object_id = in.read<uint32_t>();
    object.revision = in.read<uint8_t>();
    const size_t count = in.read<uint32_t>();
    if (in.failed()) return bad("is truncated");
    if (count == 0) continue;
    const size_t box = exact ? 0 : kBoxBytes;
    if (in.remaining() < box || count > (in.remaining() - box) / (exact ? kExactBytes : kQuantisedBytes))
      return bad("object " + std::to_string(object.object_id) + " claims " + std::to_string(count) +
                 " kernels but is truncated");
    object.kernels.resize(count);
    if (auto read = exact ? read_exact(in, object.kernels) : read_quantised(in, object.kernels); !read)
      return read.error();
  }
  if (in.remaining() != 0) return bad(std::to_string(in.remaining()) + " bytes left over");
  return frame;
}

}  // namespace livegs
