// SPDX-License-Identifier: Apache-2.0
// The layout is described in sog_reader.cpp; asset_file.cpp writes the bytes.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "gaussian/asset/morton_order.h"
#include "gaussian/asset/smallest_three.h"
#include "gaussian/asset_file.h"
#include "gaussian/opacity.h"
#include "gaussian/sog/codebook.h"
#include "gaussian/sog/sog_files.h"
#include "gaussian/sog/webp_plane.h"

namespace livegs {
namespace {

using Json = nlohmann::json;

constexpr size_t kPaletteEntries = 65536;  // labels have 16 bits
constexpr size_t kPaletteEntriesOfRow = 64;

double log_of(float x) {
  return std::copysign(std::log1p(std::abs(static_cast<double>(x))), static_cast<double>(x));
}

class SogEncoder {
 public:
  SogEncoder(const GaussianAsset& asset, const AssetFrame& frame)
      : asset_(asset), frame_(frame), order_(morton_order(asset)) {
    width_ = static_cast<size_t>(std::ceil(std::sqrt(static_cast<double>(asset.size()))));
    width_ = (width_ + 3) / 4 * 4;
    height_ = (asset.size() + width_ - 1) / width_;
  }

  Result<std::vector<std::byte>> encode() {
    meta_["version"] = 2;
    meta_["asset"] = {{"generator", "LiveGS"}};
    meta_["count"] = asset_.size();
    if (asset_.antialiased) meta_["antialias"] = true;
    for (auto step : {&SogEncoder::means, &SogEncoder::scales, &SogEncoder::quats, &SogEncoder::colours,
                      &SogEncoder::harmonics}) {
      if (auto done = (this->*step)(); !done) return done.error();
    }
    const std::vector<std::string> lines = frame_lines(frame_, false);
    if (!lines.empty()) meta_["livegs"] = lines;
    const std::string text = meta_.dump();
    const auto bytes = std::as_bytes(std::span(text));
    files_.insert(files_.begin(), {"meta.json", {bytes.begin(), bytes.end()}});
    return write_sog_bundle(files_);
  }

 private:
  // Adds an image whose pixel of kernel i (in the order of the file) is written by `fill`. Unused pixels at
  // the end are opaque black.
  template <class Fill>
  Result<void> add(const std::string& name, const Fill& fill) {
    WebpPlane plane{width_, height_, std::vector<uint8_t>(4 * width_ * height_, 0)};
    for (size_t i = 0; i < plane.pixels(); ++i) {
      uint8_t* pixel = plane.rgba.data() + 4 * i;
      pixel[3] = 255;
      if (i < order_.size()) fill(order_[i], pixel);
    }
    return add(name, plane);
  }
  Result<void> add(const std::string& name, const WebpPlane& plane) {
    auto bytes = encode_webp_plane(plane, "sog");
    if (!bytes) return bytes.error();
    files_.push_back({name, std::move(*bytes)});
    return {};
  }

  Result<void> means() {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY), high = -low;
    const auto logs = [](const Eigen::Vector3f& p) {
      return Eigen::Vector3d(log_of(p.x()), log_of(p.y()), log_of(p.z()));
    };
    for (const Eigen::Vector3f& position : asset_.positions) {
      low = low.cwiseMin(logs(position));
      high = high.cwiseMax(logs(position));
    }
    // Bounds are stored as floats, like the reader uses them, and must hold all values.
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = static_cast<double>(std::nextafter(static_cast<float>(low[axis]), -INFINITY));
      high[axis] = static_cast<double>(std::nextafter(static_cast<float>(high[axis]), INFINITY));
    }
    const auto steps = [&](uint32_t i, int axis) {
      const double share = (log_of(asset_.positions[i][axis]) - low[axis]) / (high[axis] - low[axis]);
      return static_cast<unsigned>(std::lround(std::clamp(share, 0.0, 1.0) * 65535));
    };
    meta_["means"] = {{"mins", Json::array({low.x(), low.y(), low.z()})},
                      {"maxs", Json::array({high.x(), high.y(), high.z()})},
                      {"files", Json::array({"means_l.webp", "means_u.webp"})}};
    auto added = add("means_l.webp", [&](uint32_t i, uint8_t* pixel) {
      for (int axis = 0; axis < 3; ++axis) pixel[axis] = static_cast<uint8_t>(steps(i, axis) & 255);
    });
    if (!added) return added;
    return add("means_u.webp", [&](uint32_t i, uint8_t* pixel) {
      for (int axis = 0; axis < 3; ++axis) pixel[axis] = static_cast<uint8_t>(steps(i, axis) >> 8);
    });
  }

  static Codebook codebook_of(const std::vector<Eigen::Vector3f>& vectors) {
    std::vector<float> values;
    values.reserve(3 * vectors.size());
    for (const Eigen::Vector3f& vector : vectors) values.insert(values.end(), vector.begin(), vector.end());
    return Codebook(std::move(values));
  }

  Result<void> scales() {
    const Codebook book = codebook_of(asset_.log_scales);
    meta_["scales"] = {{"codebook", book.entries()}, {"files", Json::array({"scales.webp"})}};
    return add("scales.webp", [&](uint32_t i, uint8_t* pixel) {
      for (int axis = 0; axis < 3; ++axis) pixel[axis] = book.nearest(asset_.log_scales[i][axis]);
    });
  }

  Result<void> quats() {
    meta_["quats"]["files"] = Json::array({"quats.webp"});
    return add("quats.webp", [&](uint32_t i, uint8_t* pixel) {
      const Eigen::Quaternionf& q = asset_.rotations[i];
      const SmallestThree three = to_smallest_three({q.w(), q.x(), q.y(), q.z()});
      for (size_t k = 0; k < 3; ++k) {
        const float share = std::clamp(three.others[k] / kSqrtHalf * 0.5f + 0.5f, 0.0f, 1.0f);
        pixel[k] = static_cast<uint8_t>(std::lround(share * 255));
      }
      pixel[3] = static_cast<uint8_t>(252 + three.largest);
    });
  }

  Result<void> colours() {
    const Codebook book = codebook_of(asset_.sh_dc);
    meta_["sh0"] = {{"codebook", book.entries()}, {"files", Json::array({"sh0.webp"})}};
    return add("sh0.webp", [&](uint32_t i, uint8_t* pixel) {
      for (int c = 0; c < 3; ++c) pixel[c] = book.nearest(asset_.sh_dc[i][c]);
      pixel[3] = static_cast<uint8_t>(std::lround(opacity_of_logit(asset_.opacity_logits[i]) * 255));
    });
  }

  Result<void> harmonics() {
    const size_t rest = asset_.sh_rest_count();
    if (rest == 0) return {};
    std::vector<float> rows;
    rows.reserve(3 * asset_.sh_rest.size());
    for (const uint32_t i : order_) {
      for (size_t k = 0; k < rest; ++k) {
        const Eigen::Vector3f& value = asset_.sh_rest[i * rest + k];
        rows.insert(rows.end(), value.begin(), value.end());
      }
    }
    const size_t width = 3 * rest;
    const std::vector<uint32_t> labels = cut_into_groups(rows, width, kPaletteEntries);
    const size_t entries = *std::max_element(labels.begin(), labels.end()) + size_t{1};
    std::vector<double> sums(entries * width, 0);
    std::vector<size_t> counts(entries, 0);
    for (size_t i = 0; i < labels.size(); ++i) {
      for (size_t k = 0; k < width; ++k)
        sums[labels[i] * width + k] += static_cast<double>(rows[i * width + k]);
      ++counts[labels[i]];
    }
    std::vector<float> centroids(sums.size());
    for (size_t k = 0; k < sums.size(); ++k)
      centroids[k] = static_cast<float>(sums[k] / static_cast<double>(counts[k / width]));
    const Codebook book(centroids);
    WebpPlane plane;
    plane.width = kPaletteEntriesOfRow * rest;
    plane.height = (entries + kPaletteEntriesOfRow - 1) / kPaletteEntriesOfRow;
    plane.rgba.assign(4 * plane.pixels(), 0);
    for (size_t i = 3; i < plane.rgba.size(); i += 4) plane.rgba[i] = 255;
    for (size_t entry = 0; entry < entries; ++entry) {
      const size_t first = entry / kPaletteEntriesOfRow * plane.width + entry % kPaletteEntriesOfRow * rest;
      for (size_t k = 0; k < width; ++k)
        plane.rgba[4 * (first + k / 3) + k % 3] = book.nearest(centroids[entry * width + k]);
    }
    meta_["shN"] = {{"count", entries},
                    {"bands", asset_.sh_degree},
                    {"codebook", book.entries()},
                    {"files", Json::array({"shN_centroids.webp", "shN_labels.webp"})}};
    if (auto added = add("shN_centroids.webp", plane); !added) return added;
    std::vector<uint32_t> label_of(asset_.size());
    for (size_t i = 0; i < order_.size(); ++i) label_of[order_[i]] = labels[i];
    return add("shN_labels.webp", [&](uint32_t i, uint8_t* pixel) {
      pixel[0] = static_cast<uint8_t>(label_of[i] & 255);
      pixel[1] = static_cast<uint8_t>(label_of[i] >> 8);
    });
  }

  const GaussianAsset& asset_;
  const AssetFrame& frame_;
  std::vector<uint32_t> order_;
  size_t width_ = 0, height_ = 0;
  Json meta_;
  std::vector<NamedBytes> files_;
};

}  // namespace

Result<std::vector<std::byte>> encode_sog(const GaussianAsset& asset, const AssetFrame& frame) {
  if (asset.size() == 0) return invalid_argument("sog: an asset without kernels cannot be written");
  return SogEncoder(asset, frame).encode();
}

}  // namespace livegs
