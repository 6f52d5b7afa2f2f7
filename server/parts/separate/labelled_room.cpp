// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/labelled_room.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "core/file.h"
#include "core/parallel_for.h"
#include "gaussian/asset_file.h"
#include "parts/label/choose_kernels.h"
#include "parts/separate/fill_behind.h"
#include "parts/separate/split_straddling.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

constexpr char kMagic[] = "LGSLAB1\n";
constexpr size_t kHeaderBytes = 16;

fs::path kernels_of(fs::path labels) { return labels.replace_extension(".ply"); }

// Divides the colour of the last kernel by the light that reached it.
void light_again(GaussianAsset& asset, float light) {
  const Eigen::Vector3f rgb = Eigen::Vector3f::Constant(0.5f) + kShBand0 * asset.sh_dc.back();
  asset.sh_dc.back() = ((rgb / light).array() - 0.5f).matrix() / kShBand0;
  const size_t rest = asset.sh_rest_count();
  for (size_t i = asset.sh_rest.size() - rest; i < asset.sh_rest.size(); ++i) asset.sh_rest[i] /= light;
}

}  // namespace

LabelledRoom label_room(const GaussianAsset& asset, const RoomParts& parts, const std::stop_token& stop) {
  SplitRoom split = split_straddling(asset, parts);
  std::vector<BehindThing> behind(parts.parts.size());
  parallel_for(behind.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end && !stop.stop_requested(); ++i) behind[i] = fill_behind(split, parts, i);
  });
  LabelledRoom room{std::move(split.asset), std::move(split.label)};
  const size_t own = room.asset.size();
  for (size_t i = 0; i < behind.size(); ++i) {
    for (const uint32_t kernel : behind[i].hidden) {
      if (room.label[kernel] == 0) room.label[kernel] = label_of(KernelKind::Covered, parts.parts[i].label);
    }
  }
  // A kernel has one label, so that it is lit again when the thing that shades it most is taken.
  std::vector<float> light(own, 1.0f);
  for (const BehindThing& one : behind)
    for (const auto& relit : one.relit) light[relit.kernel] = std::min(light[relit.kernel], relit.light);
  for (size_t i = 0; i < behind.size(); ++i) {
    const uint16_t thing = parts.parts[i].label;
    for (const auto& relit : behind[i].relit) {
      if (room.label[relit.kernel] != 0 || relit.light > light[relit.kernel]) continue;
      room.label[relit.kernel] = label_of(KernelKind::Covered, thing);
      append_kernel(behind[i].fill, room.asset, relit.kernel);
      light_again(behind[i].fill, relit.light);
    }
    for (const auto& [kernels, kind] :
         {std::pair(&behind[i].fill, KernelKind::Fill), {&behind[i].underside, KernelKind::Underside}}) {
      for (size_t k = 0; k < kernels->size(); ++k) {
        append_kernel(room.asset, *kernels, k);
        room.label.push_back(label_of(kind, thing));
      }
    }
  }
  return room;
}

GaussianAsset room_without(const LabelledRoom& room, std::span<const uint32_t> taken,
                           std::vector<uint32_t>* kept) {
  std::vector<uint32_t> stays;
  for (uint32_t i = 0; i < room.label.size(); ++i) {
    const auto thing = static_cast<uint16_t>(room.label[i] & kThingMask);
    const KernelKind kind = kind_of(room.label[i]);
    const bool gone = thing != 0 && std::find(taken.begin(), taken.end(), thing) != taken.end();
    if (kind == KernelKind::Fill ? gone : kind != KernelKind::Underside && !gone) stays.push_back(i);
  }
  GaussianAsset rest = select_kernels(room.asset, stays);
  if (kept) *kept = std::move(stays);
  return rest;
}

GaussianAsset thing_alone(const LabelledRoom& room, uint16_t thing) {
  std::vector<uint32_t> own;
  for (uint32_t i = 0; i < room.label.size(); ++i) {
    if (room.label[i] == thing || room.label[i] == label_of(KernelKind::Underside, thing)) own.push_back(i);
  }
  return select_kernels(room.asset, own);
}

Result<void> write_labelled_room(const fs::path& labels, const LabelledRoom& room) {
  if (auto written = write_asset(kernels_of(labels), room.asset); !written) return written;
  std::vector<std::byte> bytes(kHeaderBytes + 2 * room.label.size());
  const uint64_t count = room.label.size();
  std::memcpy(bytes.data(), kMagic, 8);
  std::memcpy(bytes.data() + 8, &count, 8);
  std::memcpy(bytes.data() + kHeaderBytes, room.label.data(), 2 * room.label.size());
  return write_file_atomically(labels, bytes);
}

Result<LabelledRoom> read_labelled_room(const fs::path& labels) {
  const std::string name = labels.filename().string();
  auto bytes = read_file(labels);
  if (!bytes) return bytes.error();
  uint64_t count = 0;
  if (bytes->size() >= kHeaderBytes) std::memcpy(&count, bytes->data() + 8, 8);
  if (bytes->size() < kHeaderBytes || std::memcmp(bytes->data(), kMagic, 8) != 0 ||
      count != (bytes->size() - kHeaderBytes) / 2 || bytes->size() % 2 != 0)
    return invalid_data(
        name + ": is not a label file, or is truncated; restore it, or remove \"labels\" and \"taken\"");
  auto kernels = read_asset(kernels_of(labels));
  if (!kernels) return kernels.error();
  if (kernels->asset.size() != count)
    return invalid_data(name + ": has " + std::to_string(count) + " labels for " +
                        std::to_string(kernels->asset.size()) + " kernels in " +
                        kernels_of(labels).filename().string() + "; restore both from one copy");
  LabelledRoom room;
  room.asset = std::move(kernels->asset);
  room.label.resize(count);
  std::memcpy(room.label.data(), bytes->data() + kHeaderBytes, 2 * count);
  return room;
}

}  // namespace livegs
