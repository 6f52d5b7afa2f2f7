// SPDX-License-Identifier: Apache-2.0
#include "wire/rest_body_codec.h"

#include <gtest/gtest.h>

#include "common/skin/kernels/rest_bodies.h"
#include "common/wire/mutations.h"

namespace livegs {
namespace {

using namespace livegs::testing;

void expect_same(const Pose& a, const Pose& b) {
  EXPECT_EQ(a.position_m, b.position_m);
  EXPECT_EQ(a.orientation.coeffs(), b.orientation.coeffs());
}

void expect_same(const RestBody& a, const RestBody& b) {
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.object_from_asset.scale, b.object_from_asset.scale);
  EXPECT_EQ(a.object_from_asset.rotation.coeffs(), b.object_from_asset.rotation.coeffs());
  EXPECT_EQ(a.object_from_asset.translation_m, b.object_from_asset.translation_m);
  ASSERT_EQ(a.bodies.size(), b.bodies.size());
  for (size_t i = 0; i < a.bodies.size(); ++i) expect_same(a.bodies[i], b.bodies[i]);
  expect_same(a.object_from_lattice, b.object_from_lattice);
  EXPECT_EQ(a.cell_width_m, b.cell_width_m);
  EXPECT_EQ(a.node_coordinates, b.node_coordinates);
  EXPECT_EQ(a.cells, b.cells);
  EXPECT_EQ(a.cell_fills, b.cell_fills);
  EXPECT_EQ(a.particles_m, b.particles_m);
  EXPECT_EQ(a.revision, b.revision);
  ASSERT_EQ(a.kernel_runs.size(), b.kernel_runs.size());
  for (size_t i = 0; i < a.kernel_runs.size(); ++i) {
    EXPECT_EQ(a.kernel_runs[i].body, b.kernel_runs[i].body);
    EXPECT_EQ(a.kernel_runs[i].count, b.kernel_runs[i].count);
  }
}

std::vector<RestBody> one_of_each() {
  std::mt19937_64 random(1);
  RestBody lattice = ragged_body(3, 4, 2, 1.0 / 3.0, 2);
  place(lattice, 3);
  RestBody rigid;
  rigid.object_from_asset = lattice.object_from_asset;
  for (int b = 0; b < 3; ++b) rigid.bodies.push_back({uniform3(random, -1, 1), random_rotation(random)});
  RestBody particles;
  particles.kind = DriverKind::Particles;
  for (int p = 0; p < 7; ++p) particles.particles_m.push_back(uniform3(random, -1, 1).cast<float>());
  RestBody fingers = lattice_body(1, 2, 1, 0.1);
  fingers.cells.push_back(fingers.cells[0]);
  for (size_t c = 0; c < fingers.cells.size(); ++c) fingers.cell_fills.push_back(random());
  RestBody broken = rigid;
  broken.revision = 2;
  for (uint32_t body : {0u, 2u, 1u}) broken.kernel_runs.push_back({body, 1});
  return {lattice, rigid, particles, fingers, broken};
}

TEST(RestBodyCodec, RoundTripIsLossless) {
  for (const RestBody& rest : one_of_each()) {
    const Result<RestBody> decoded = decode_rest_body(encode_rest_body(rest));
    ASSERT_TRUE(decoded) << decoded.error().message;
    expect_same(rest, *decoded);
  }
}

TEST(RestBodyCodec, CoordinatesUseTheSmallestWidth) {
  const auto size_at = [](const Eigen::Vector3i& far) {
    RestBody rest = lattice_body(1, 1, 1, 0.1, nullptr, {-5, 1000, 7});
    rest.node_coordinates.push_back(far);  // a node without a cell
    const std::vector<std::byte> bytes = encode_rest_body(rest);
    const Result<RestBody> decoded = decode_rest_body(bytes);
    EXPECT_TRUE(decoded);
    if (decoded) expect_same(rest, *decoded);
    return bytes.size();
  };
  const size_t fixed = 72 + 56 + 8 + 8 + 12 + 2 + 16;
  EXPECT_EQ(size_at({250, 1000, 7}), fixed + 9 * 3);
  EXPECT_EQ(size_at({251, 1000, 7}), fixed + 9 * 6);
  EXPECT_EQ(size_at({INT32_MIN, INT32_MAX, 7}), fixed + 9 * 12);
}

TEST(RestBodyCodec, ManyNodesUseWiderIndices) {
  RestBody rest = lattice_body(1, 1, 1, 0.1);
  rest.node_coordinates.resize(0x10001, Eigen::Vector3i::Zero());
  rest.cells.push_back({0x10000, 1, 2, 3, 4, 5, 6, 7});
  const Result<RestBody> decoded = decode_rest_body(encode_rest_body(rest));
  ASSERT_TRUE(decoded) << decoded.error().message;
  expect_same(rest, *decoded);
}

TEST(RestBodyCodec, FillsTakeEightBytesPerCell) {
  RestBody rest = one_of_each()[3];
  const size_t with_fills = encode_rest_body(rest).size();
  const size_t cells = rest.cells.size();
  rest.cell_fills.clear();
  EXPECT_EQ(with_fills, encode_rest_body(rest).size() + 8 * cells);
}

TEST(RestBodyCodec, RejectsTruncationAndTrailingBytes) {
  for (const RestBody& rest : one_of_each()) {
    std::vector<std::byte> bytes = encode_rest_body(rest);
    for (size_t length = 0; length < bytes.size(); ++length) {
      const std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
      EXPECT_FALSE(decode_rest_body(cut)) << length;
    }
    bytes.push_back(std::byte{0});
    EXPECT_FALSE(decode_rest_body(bytes));
  }
}

TEST(RestBodyCodec, DecodableMutationsBindOrFail) {
  // A client decodes, binds and skins a received rest body. None of these may crash.
  for (const RestBody& rest : one_of_each()) {
    const GaussianAsset asset = kernels_at(rest, {{0, 0, 0}, {0.1, 0.2, 0.3}, {2, -3, 1}}, 4);
    int decoded_count = 0, bound_count = 0;
    for_each_mutation(encode_rest_body(rest), 5000, 5, [&](std::span<const std::byte> bytes) {
      const Result<RestBody> decoded = decode_rest_body(bytes);
      if (!decoded) return;
      ++decoded_count;
      const Result<KernelBindings> bindings = bind_kernels(asset, *decoded);
      if (!bindings) return;
      ++bound_count;
      ObjectDrivers drivers;
      drivers.kind = decoded->kind;
      if (decoded->kind == DriverKind::Rigid) {
        drivers.poses = decoded->bodies;
      } else {
        drivers = rest_drivers(*decoded);
      }
      drivers.revision = decoded->revision;
      if (!check_drivers(*decoded, drivers)) return;
      PosedKernels kernels;
      skin_kernels(asset, *decoded, *bindings, drivers, kernels);
      EXPECT_EQ(kernels.positions_m.size(), asset.size());
    });
    EXPECT_GT(decoded_count, 50);
    EXPECT_GT(bound_count, 50);
  }
}

TEST(RestBodyCodec, ReportsEachInvalidField) {
  const auto message = [](const std::function<void(std::vector<std::byte>&)>& spoil, size_t which) {
    std::vector<std::byte> bytes = encode_rest_body(one_of_each()[which]);
    spoil(bytes);
    const Result<RestBody> decoded = decode_rest_body(bytes);
    return decoded ? std::string() : decoded.error().message;
  };
  const auto set = [](size_t at, uint8_t value) {
    return [=](std::vector<std::byte>& bytes) { bytes.at(at) = static_cast<std::byte>(value); };
  };
  EXPECT_NE(message(set(0, 0), 0).find("LVGR"), std::string::npos);
  EXPECT_NE(message(set(4, 9), 0).find("version 9"), std::string::npos);
  EXPECT_NE(message(set(6, 0), 0).find("unknown kind 0"), std::string::npos);
  EXPECT_NE(message(set(7, 2), 0).find("unknown encoding 2"), std::string::npos);
  EXPECT_NE(message(set(7, 1), 2).find("unknown encoding 1"), std::string::npos);  // particles have no fills
  EXPECT_NE(message(set(7, 1), 1).find("kernel runs is truncated"), std::string::npos);
  const size_t revision = 72 + 4 + 3 * 56;
  EXPECT_NE(message(set(revision, 0), 4).find("revision 0"), std::string::npos);
  EXPECT_NE(message(set(revision + 1, 1), 4).find("revision 258"), std::string::npos);
  EXPECT_NE(message(set(revision + 7, 0xFF), 4).find("kernel runs is truncated"), std::string::npos);
  EXPECT_NE(message(set(revision + 8, 3), 4).find("kernel run 0 refers to body 3 of 3"), std::string::npos);
  EXPECT_NE(message(set(15, 0xBF), 0).find("similarity"), std::string::npos);  // scale is negative
  EXPECT_NE(message(set(72 + 56 + 7, 0xBF), 0).find("cell width"), std::string::npos);
  EXPECT_NE(message(set(72 + 56 + 8 + 8 + 12, 3), 0).find("3 bytes per coordinate"), std::string::npos);
  EXPECT_NE(message(set(72 + 56 + 8 + 8 + 13, 1), 0).find("1 bytes per index"), std::string::npos);
  EXPECT_NE(message([](std::vector<std::byte>& b) { b.back() = std::byte{0xFF}; }, 0).find("refers to node"),
            std::string::npos);
  EXPECT_NE(message(set(75, 0xFF), 1).find("bodies is truncated"), std::string::npos);
  EXPECT_NE(message(set(72 + 4 + 24 + 31, 0x00), 1).find("body 0 has an invalid pose"), std::string::npos);
  EXPECT_NE(message([](std::vector<std::byte>& b) { b.back() = b[b.size() - 2] = std::byte{0xFF}; }, 2)
                .find("particle 6 is not finite"),
            std::string::npos);
}

}  // namespace
}  // namespace livegs
