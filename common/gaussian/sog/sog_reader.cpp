// SPDX-License-Identifier: Apache-2.0
// PlayCanvas SOG: one image per property, one pixel per kernel. SH of degree 1 and up are indices into a
// palette.
#include <cmath>

#include "gaussian/asset/readers.h"
#include "gaussian/asset/smallest_three.h"
#include "gaussian/opacity.h"
#include "gaussian/sog/sog_files.h"
#include "gaussian/sog/sog_meta.h"
#include "gaussian/sog/webp_plane.h"

namespace livegs {
namespace {

constexpr uint64_t kMaxMetaBytes = uint64_t{16} << 20;
constexpr uint64_t kBytesPerKernel = 5 * 4;  // pixels of the required images
constexpr size_t kPaletteColumns = 64;
constexpr unsigned kFirstQuaternionTag = 252;

// Upper bound of the pixels of an image. Images are rectangles, so some pixels are unused: at most two rows,
// and more for tiny images.
size_t max_pixels_for(size_t count) { return 2 * count + 65536; }

class SogDecoder {
 public:
  SogDecoder(const SogFiles& files, const SogMeta& meta, std::string_view name)
      : files_(files), meta_(meta), name_(name) {
    asset_.sh_degree = meta.palette ? meta.palette->degree : 0;
    asset_.antialiased = meta.antialiased;
  }

  Result<GaussianAsset> decode() {
    using Step = Result<void> (SogDecoder::*)();
    for (const Step step : {&SogDecoder::means, &SogDecoder::scales, &SogDecoder::quats, &SogDecoder::colours,
                            &SogDecoder::palette}) {
      const Result<void> done = (this->*step)();
      if (!done) return done.error();
    }
    return std::move(asset_);
  }

 private:
  Error off(const std::string& what) const { return invalid_data(std::string(name_) + ": " + what); }

  // Reads an image with at least one pixel per kernel.
  Result<WebpPlane> plane(const std::string& file) const {
    const Result<std::vector<std::byte>> bytes = files_.read(file);
    if (!bytes) return bytes.error();
    Result<WebpPlane> image = decode_webp_plane(*bytes, max_pixels_for(meta_.count), name_, file);
    if (image && image->pixels() < meta_.count) {
      return off("image " + file + " has " + std::to_string(image->pixels()) + " pixels, too few for " +
                 std::to_string(meta_.count) + " kernels");
    }
    return image;
  }

  // Positions are stored as sign(x) ln(1 + |x|), 16 bits in two images.
  Result<void> means() {
    const Result<WebpPlane> low = plane(meta_.means_low_file);
    if (!low) return low.error();
    const Result<WebpPlane> high = plane(meta_.means_high_file);
    if (!high) return high.error();
    asset_.resize(meta_.count);  // both images were decoded, so the count is plausible
    for (size_t i = 0; i < meta_.count; ++i) {
      for (size_t axis = 0; axis < 3; ++axis) {
        const auto word = static_cast<float>(low->pixel(i)[axis] | high->pixel(i)[axis] << 8);
        const float v =
            meta_.means_min[axis] + (meta_.means_max[axis] - meta_.means_min[axis]) * (word / 65535.0f);
        asset_.positions[i][static_cast<int>(axis)] = std::copysign(std::expm1(std::abs(v)), v);
      }
    }
    return {};
  }

  static float scaled(const SogScale& scale, size_t channel, uint8_t byte) {
    if (!scale.codebook.empty()) return scale.codebook[byte];
    return scale.mins[channel] +
           (scale.maxs[channel] - scale.mins[channel]) * (static_cast<float>(byte) / 255.0f);
  }

  Result<void> scales() {
    const Result<WebpPlane> image = plane(meta_.scales.file);
    if (!image) return image.error();
    for (size_t i = 0; i < meta_.count; ++i) {
      for (size_t axis = 0; axis < 3; ++axis) {
        asset_.log_scales[i][static_cast<int>(axis)] = scaled(meta_.scales, axis, image->pixel(i)[axis]);
      }
    }
    return {};
  }

  // Alpha selects the largest of w x y z; red, green and blue are the others.
  Result<void> quats() {
    const Result<WebpPlane> image = plane(meta_.quats_file);
    if (!image) return image.error();
    const auto component = [](uint8_t byte) {
      return (static_cast<float>(byte) / 255.0f * 2.0f - 1.0f) * kSqrtHalf;
    };
    for (size_t i = 0; i < meta_.count; ++i) {
      const uint8_t* p = image->pixel(i);
      if (p[3] < kFirstQuaternionTag) {
        return off("the rotation of kernel " + std::to_string(i) + " has tag " + std::to_string(p[3]) +
                   ", outside 252 to 255; export it again");
      }
      const Eigen::Vector4f wxyz = from_smallest_three(p[3] - kFirstQuaternionTag,
                                                       {component(p[0]), component(p[1]), component(p[2])});
      asset_.rotations[i] = Eigen::Quaternionf(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    }
    return {};
  }

  Result<void> colours() {
    const Result<WebpPlane> image = plane(meta_.sh0.file);
    if (!image) return image.error();
    for (size_t i = 0; i < meta_.count; ++i) {
      const uint8_t* p = image->pixel(i);
      for (size_t c = 0; c < 3; ++c) asset_.sh_dc[i][static_cast<int>(c)] = scaled(meta_.sh0, c, p[c]);
      asset_.opacity_logits[i] =
          meta_.version == 1 ? scaled(meta_.sh0, 3, p[3]) : logit_of_opacity_byte(p[3]);
    }
    return {};
  }

  Result<void> palette() {
    if (!meta_.palette) return {};
    const SogPalette& palette = *meta_.palette;
    const Result<WebpPlane> labels = plane(palette.labels_file);
    if (!labels) return labels.error();
    const Result<std::vector<std::byte>> bytes = files_.read(palette.centroids_file);
    if (!bytes) return bytes.error();
    const size_t rest = asset_.sh_rest_count();
    const size_t width = kPaletteColumns * rest;
    const size_t rows = (palette.count + kPaletteColumns - 1) / kPaletteColumns;
    // Writers round the rows up; the limit allows twice the needed rows.
    const Result<WebpPlane> image =
        decode_webp_plane(*bytes, width * (2 * rows + 64), name_, palette.centroids_file);
    if (!image) return image.error();
    if (image->width != width || image->height < rows) {
      return off("image " + palette.centroids_file + " is " + std::to_string(image->width) + " x " +
                 std::to_string(image->height) + " instead of " + std::to_string(width) + " x " +
                 std::to_string(rows) + " for its " + std::to_string(palette.count) +
                 " entries; export it again");
    }
    for (size_t i = 0; i < meta_.count; ++i) {
      const size_t label = static_cast<size_t>(labels->pixel(i)[0] | labels->pixel(i)[1] << 8);
      if (label >= palette.count) {
        return off("kernel " + std::to_string(i) + " refers to entry " + std::to_string(label) +
                   " of a palette of " + std::to_string(palette.count));
      }
      const uint8_t* entry = image->pixel(label / kPaletteColumns * width + label % kPaletteColumns * rest);
      for (size_t k = 0; k < rest; ++k) {
        const uint8_t* p = entry + 4 * k;
        asset_.sh_rest[i * rest + k] = {palette.codebook[p[0]], palette.codebook[p[1]],
                                        palette.codebook[p[2]]};
      }
    }
    return {};
  }

  const SogFiles& files_;
  const SogMeta& meta_;
  std::string_view name_;
  GaussianAsset asset_;
};

}  // namespace

Result<AssetFile> read_sog(const SogFiles& files, uint64_t total_bytes, std::string_view name) {
  const Result<std::vector<std::byte>> meta_json = files.read("meta.json");
  if (!meta_json) return meta_json.error();
  if (meta_json->size() > kMaxMetaBytes)
    return invalid_data(std::string(name) + ": meta.json is over 16 MiB");
  const Result<SogMeta> meta = parse_sog_meta(*meta_json, name);
  if (!meta) return meta.error();
  if (meta->count * kBytesPerKernel > kMaxCompressionRatio * total_bytes) {
    return invalid_data(std::string(name) + ": meta.json claims " + std::to_string(meta->count) +
                        " kernels, more than " + std::to_string(total_bytes) + " bytes can hold");
  }
  Result<GaussianAsset> asset = SogDecoder(files, *meta, name).decode();
  if (!asset) return asset.error();
  AssetFile file;
  file.asset = std::move(*asset);
  file.format = AssetFormat::Sog;
  file.format_version = meta->version;
  file.frame = meta->frame;
  file.notes = meta->notes;
  return file;
}

Result<AssetFile> read_sog_bundle(Bytes bytes, std::string_view name) {
  const Result<std::unique_ptr<SogFiles>> files = open_sog_bundle(bytes, name);
  if (!files) return files.error();
  return read_sog(**files, bytes.size(), name);
}

Result<AssetFile> read_sog_folder(const std::filesystem::path& index, std::string_view name) {
  const std::filesystem::path folder = index.has_parent_path() ? index.parent_path() : ".";
  uint64_t bytes = 0;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code no_size;
    const uint64_t size = entry->is_regular_file(no_size) ? entry->file_size(no_size) : 0;
    if (!no_size) bytes += size;
  }
  return read_sog(*open_sog_folder(index, name), bytes, name);
}

}  // namespace livegs
