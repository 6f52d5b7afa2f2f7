// SPDX-License-Identifier: Apache-2.0
// .splat: records of 32 bytes without a header. Position and standard deviations are floats, colour and
// opacity four bytes, the quaternion w x y z four bytes.
#include <cmath>

#include "gaussian/asset/readers.h"
#include "gaussian/opacity.h"

namespace livegs {
namespace {

constexpr size_t kRecordBytes = 32;

}  // namespace

Result<AssetFile> read_splat(Bytes bytes, std::string_view name) {
  if (bytes.empty() || bytes.size() % kRecordBytes != 0) {
    return invalid_data(std::string(name) + ": " + std::to_string(bytes.size()) +
                        " bytes are not a multiple of the 32-byte record");
  }
  AssetFile file;
  file.format = AssetFormat::Splat;
  GaussianAsset& asset = file.asset;
  asset.resize(bytes.size() / kRecordBytes);
  for (size_t i = 0; i < asset.size(); ++i) {
    const Bytes record = bytes.subspan(i * kRecordBytes, kRecordBytes);
    const auto component = [&](size_t at) {
      return (static_cast<float>(byte_at(record, 28 + at)) - 128.0f) / 128.0f;
    };
    for (int axis = 0; axis < 3; ++axis) {
      const auto offset = static_cast<size_t>(4 * axis);
      asset.positions[i][axis] = load<float>(record, offset);
      asset.log_scales[i][axis] =
          std::log(load<float>(record, 12 + offset));  // negative: NaN; the kernel is dropped later
      asset.sh_dc[i][axis] =
          (static_cast<float>(byte_at(record, 24 + static_cast<size_t>(axis))) / 255.0f - 0.5f) / kShBand0;
    }
    asset.opacity_logits[i] = logit_of_opacity_byte(byte_at(record, 27));
    asset.rotations[i] = Eigen::Quaternionf(component(0), component(1), component(2), component(3));
  }
  return file;
}

}  // namespace livegs
