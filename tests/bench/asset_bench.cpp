// SPDX-License-Identifier: Apache-2.0
// Size of a transmitted asset, and its appearance during the transfer (proto/asset_format.md). For each
// asset:
// - bytes of the lossless .ply, of the .ply compressed with zstd, and of the transmitted form;
// - processor time of encoding and decoding on one core;
// - bytes until the first kernels can be drawn;
// - for the first 5, 10, 25 and 50 % of the bytes: the share of kernels received, and the PSNR against the
//   complete asset (mean of four sides, 640x480), compared with the same bytes of a .ply.
// Run by hand:
//   asset_bench [ASSET...] > tests/bench/results/<processor>/asset.csv
// --pictures FOLDER writes the pictures of the first asset. Captured assets of the shared data follow the
// given ones.
#include <zstd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/support/time_of.h"
#include "core/parallel_for.h"
#include "gaussian/asset_file.h"
#include "gaussian/progressive_asset.h"
#include "skin/skin_kernels.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

constexpr double kShares[] = {0.05, 0.1, 0.25, 0.5};
constexpr int kSides = 4;

struct Stand {
  Eigen::Vector3d centre;
  double scale;
};

// Turned from -Y up, with a diagonal of 1.5 m.
Stand stand_of(const GaussianAsset& asset) {
  Eigen::AlignedBox3f bounds;
  for (const Eigen::Vector3f& position : asset.positions) bounds.extend(position);
  return {bounds.center().cast<double>(), 1.5 / static_cast<double>(bounds.diagonal().norm())};
}

std::vector<Image> pictures(const GaussianAsset& asset, const Stand& stand) {
  RestBody rest;
  rest.object_from_asset.scale = stand.scale;
  rest.object_from_asset.rotation = Eigen::Quaterniond(0, 1, 0, 0);
  rest.object_from_asset.translation_m = -stand.scale * (rest.object_from_asset.rotation * stand.centre);
  rest.bodies = {Pose{}};
  ObjectDrivers drivers;
  drivers.poses = {Pose{}};
  PosedKernels kernels;
  const auto bindings = bind_kernels(asset, rest);
  if (!bindings) return {};
  skin_kernels(asset, rest, *bindings, drivers, kernels);
  const DrawnObject drawn{&asset, &kernels, 1};
  Rasteriser rasteriser;
  std::vector<Image> images;
  for (int side = 0; side < kSides; ++side) {
    const double angle = 2 * M_PI * side / kSides;
    const Eigen::Vector3d from = Eigen::Vector3d(std::sin(angle), 0.3, std::cos(angle)).normalized();
    RasterisedView view;
    RasteriseOptions options;
    options.background = {0.08f, 0.08f, 0.1f};
    rasteriser.draw({&drawn, 1}, look_at(1.8 * from, {0, 0, 0}, {0, 1, 0}, 0.8, 640, 480), options, view);
    images.push_back(std::move(view.image));
  }
  return images;
}

double mean_psnr_db(const std::vector<Image>& a, const std::vector<Image>& b) {
  double sum = 0;
  for (int side = 0; side < kSides; ++side)
    sum += psnr_db(a[static_cast<size_t>(side)], b[static_cast<size_t>(side)]);
  return sum / kSides;
}

GaussianAsset first_kernels(const GaussianAsset& asset, size_t count) {
  GaussianAsset first = asset;
  first.resize(count);
  return first;
}

void measure(const std::string& name, const GaussianAsset& asset, const std::filesystem::path& folder) {
  const std::vector<std::byte> ply = encode_ply(asset);
  std::vector<std::byte> packed(ZSTD_compressBound(ply.size()));
  const size_t zstd = ZSTD_compress(packed.data(), packed.size(), ply.data(), ply.size(), 3);
  std::vector<std::byte> sent;
  const auto encode = bench::time_of(1, 3, [&] { sent = encode_progressive(asset); });
  const auto decode = bench::time_of(1, 3, [&] { (void)decode_progressive(sent); });
  size_t first_bytes = 0;
  ProgressiveDecoder beginning;
  while (beginning.arrived() == 0 && beginning.take(std::span(sent).subspan(first_bytes, 1))) ++first_bytes;
  std::printf("%s,%zu,%d,%zu,%zu,%zu,%.3f,%.3f,%.1f,%.1f,%zu", name.c_str(), asset.size(), asset.sh_degree,
              ply.size(), zstd, sent.size(), static_cast<double>(zstd) / static_cast<double>(ply.size()),
              static_cast<double>(sent.size()) / static_cast<double>(ply.size()), encode.cpu_ms,
              decode.cpu_ms, first_bytes);
  const Stand stand = stand_of(asset);
  const std::vector<Image> whole = pictures(asset, stand);
  for (const double share : kShares) {
    ProgressiveDecoder decoder;
    const auto bytes = static_cast<size_t>(share * static_cast<double>(sent.size()));
    (void)decoder.take(std::span(sent).first(bytes));
    const AssetPart part = decoder.part();
    const std::vector<Image> coarse =
        part.asset.size() > 0 ? pictures(part.asset, stand) : std::vector<Image>();
    // The same number of bytes of the .ply.
    const size_t plain = std::max<size_t>(1, asset.size() * bytes / ply.size());
    const std::vector<Image> front = pictures(first_kernels(asset, plain), stand);
    std::printf(",%.3f,%.1f,%.1f", static_cast<double>(part.asset.size()) / static_cast<double>(asset.size()),
                coarse.empty() ? 0 : mean_psnr_db(coarse, whole), mean_psnr_db(front, whole));
    if (folder.empty() || coarse.empty()) continue;
    (void)write_png(folder / (name + "_" + std::to_string(static_cast<int>(100 * share)) + ".png"),
                    coarse[0]);
    (void)write_png(folder / (name + "_" + std::to_string(static_cast<int>(100 * share)) + "_ply.png"),
                    front[0]);
  }
  if (!folder.empty()) (void)write_png(folder / (name + ".png"), whole[0]);
  std::printf("\n");
  std::fflush(stdout);
}

int run(int argc, char** argv) {
  set_thread_count(1);
  std::vector<std::filesystem::path> assets;
  std::filesystem::path folder;
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "--pictures" && i + 1 < argc) {
      folder = argv[++i];
      std::filesystem::create_directories(folder);
    } else {
      assets.emplace_back(argv[i]);
    }
  }
  const std::filesystem::path data = std::filesystem::path(LIVEGS_SHARED_DATA_DIR) / "splats";
  for (const char* file :
       {"guitar/guitar.compressed.ply", "ponytail_palm/ponytail_palm.splat", "lego_house/fourth_st.spz",
        "lego_house/lego_house_50k.ply", "statues/angel.sog", "statues/narcissus.sog", "statues/massa.sog",
        "camera_leica/leica-sofort-top8192.ply", "playbot/sog_lod2", "fur_block"}) {
    assets.push_back(data / file);
  }
  std::printf(
      "asset,kernels,sh_degree,ply_bytes,zstd_ply_bytes,sent_bytes,zstd_ply_share,sent_share,encode_ms,"
      "decode_ms,first_drawn_bytes");
  for (const double share : kShares) {
    const int percent = static_cast<int>(100 * share + 0.5);
    std::printf(",kernels_at_%d,psnr_db_at_%d,front_of_ply_psnr_db_at_%d", percent, percent, percent);
  }
  std::printf("\n");
  for (const std::filesystem::path& path : assets) {
    const auto file = read_asset(path);
    if (!file) {
      std::fprintf(stderr, "%s: skipped: %s\n", path.c_str(), file.error().message.c_str());
      continue;
    }
    const std::string name = std::filesystem::is_directory(path) && path.filename() == "sog_lod2"
                                 ? "playbot"
                                 : path.stem().string();
    measure(name, file->asset, path == assets.front() ? folder : std::filesystem::path());
  }
  return 0;
}

}  // namespace
}  // namespace livegs

int main(int argc, char** argv) { return livegs::run(argc, argv); }
