// SPDX-License-Identifier: Apache-2.0
// What is read by itself: frames, publications, rest bodies and kernels (proto/frame_format.md). The first
// byte says which.
#include <algorithm>
#include <cmath>

#include "fuzz/moving_objects.h"
#include "wire/frame_codec.h"
#include "wire/kernel_codec.h"
#include "wire/publication.h"
#include "wire/rest_body_codec.h"

namespace livegs::fuzz::frame_fuzz {
namespace {

enum class What : uint8_t { Frame, Publication, RestBody, Kernels, Count };

Bytes with(What what, const Bytes& bytes) {
  Bytes all{static_cast<std::byte>(what)};
  all.insert(all.end(), bytes.begin(), bytes.end());
  return all;
}

void look_at_rest_body(std::span<const std::byte> bytes) {
  const auto rest = decode_rest_body(bytes);
  if (!rest) return;
  for (const auto& cell : rest->cells) {
    for (const uint32_t node : cell)
      check(node < rest->node_coordinates.size(), "cells name nodes that there are");
  }
  for (const RestBody::KernelRun& run : rest->kernel_runs)
    check(run.body < rest->bodies.size(), "runs name bodies that there are");
  // The writer takes the smallest widths, the reader any: what was written once stays as it is.
  const Bytes again = encode_rest_body(*rest);
  const auto same = decode_rest_body(again);
  check(same.has_value(), "what was read can be written and read");
  check(encode_rest_body(*same) == again, "and is the same then");
}

}  // namespace

void look_at(std::span<const std::byte> input) {
  if (input.empty()) return;
  const auto bytes = input.subspan(1);
  switch (static_cast<What>(std::to_integer<uint8_t>(input[0]) % static_cast<uint8_t>(What::Count))) {
    case What::Frame:
      if (const auto frame = decode_frame(bytes)) check_finite(*frame);
      break;
    case What::Publication:
      if (const auto publication = decode_publication(bytes)) {
        check_finite(publication->frame);
        check(publication->server_instance.size() == 32, "an instance has 32 digits");
      }
      break;
    case What::RestBody:
      look_at_rest_body(bytes);
      break;
    case What::Kernels:
      if (const auto kernels = decode_kernels(bytes)) {
        for (const ObjectKernels& object : kernels->objects) {
          for (const Eigen::Vector3f& position : object.kernels.positions_m)
            check(position.allFinite(), "kernels are finite");
          for (const Symmetric3f& s : object.kernels.covariances_m2)
            check(std::all_of(s.begin(), s.end(), [](float entry) { return std::isfinite(entry); }),
                  "covariances are finite");
        }
      }
      break;
    case What::Count:
      break;
  }
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> seeds;
  for (uint64_t tick = 1; tick < 4; ++tick) {
    seeds.push_back(with(What::Frame, encode_frame(frame_at(tick))));
    seeds.push_back(with(What::Frame, encode_frame(frame_at(tick), DriverEncoding::Raw)));
    seeds.push_back(with(What::Publication,
                         encode_publication({"00112233445566778899aabbccddeeff", tick, 5, frame_at(tick)})));
  }
  KernelFrame kernels{3, 5, {{7, 2, {}}, {8, 0, {}}}};
  kernels.objects[0].kernels.positions_m = {{1, 2, 3}, {-1, 0, 0.5f}};
  kernels.objects[0].kernels.covariances_m2 = {{1e-4f, 0, 1e-5f, 2e-4f, 0, 1e-6f},
                                               {1e-2f, 0, 0, 1e-2f, 0, 1e-2f}};
  kernels.objects[0].kernels.world_from_asset.assign(2, Eigen::Quaternionf(0.5f, 0.5f, -0.5f, 0.5f));
  for (const KernelEncoding encoding : {KernelEncoding::Exact, KernelEncoding::Quantised})
    seeds.push_back(with(What::Kernels, encode_kernels(kernels, encoding)));
  for (const RestBody& rest : rest_bodies()) seeds.push_back(with(What::RestBody, encode_rest_body(rest)));
  return seeds;
}

[[maybe_unused]] const bool kAdded = add_target({"frame", look_at, seeds});

}  // namespace livegs::fuzz::frame_fuzz
