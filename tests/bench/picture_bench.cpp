// SPDX-License-Identifier: Apache-2.0
// Difference between the device's pictures of captured assets and the reference renderer. Prints CSV, one row
// per picture: PSNR of the picture on the screen as the client draws it (8 bits per channel); of blending in
// 16-bit floats, with its mean bias; and of blending in 32-bit floats before rounding to 8 bits. The exit
// code is 1 if a picture as the client draws it is below 50 dB, and 77 if there was nothing to draw. Also
// runs as a nightly test. With a folder, pictures are written there, of all assets or of the named one.
//   picture_bench > tests/bench/results/<processor>/picture.csv
//   picture_bench FOLDER NAME_OR_FILE
// VK_ICD_FILENAMES selects another device; append its rows.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>

#include "client/render/renderer/posed_assets.h"
#include "gaussian/asset_file.h"
#include "render/splat_renderer.h"

namespace livegs {
namespace {

constexpr double kBar_db = 50.0;
constexpr int kNothingDrawn = 77;  // ctest's code for a skipped test
constexpr int kWidth = 480, kHeight = 360;
constexpr double kTwist_rad_m = 1.5;
const Eigen::Vector3f kBackground{0.08f, 0.08f, 0.1f};

constexpr const char* kAssets[] = {"camera_leica/leica-sofort-top8192.ply",
                                   "fur_block",
                                   "garden_points/garden_init.compressed.ply",
                                   "guitar/guitar.ply",
                                   "lego_house/lego_house_50k.ply",
                                   "lego_house/fourth_st.spz",
                                   "playbot/playbot_31k.ply",
                                   "playbot/sog_lod2",
                                   "ponytail_palm/ponytail_palm.ply",
                                   "statues/angel.ply",
                                   "statues/angel-kneeling.sog",
                                   "statues/angel_statue_only.ply",
                                   "statues/massa.sog",
                                   "statues/narcissus.sog",
                                   "statues/trumpet.sog",
                                   "statues/trumpet_statue_only.ply"};

// Bound for lavapipe with blending in 16-bit floats, which lavapipe rounds towards zero. SwiftShader meets
// kBar_db.
constexpr double kLavapipeHalf_db = 44;

struct Renderers {
  std::unique_ptr<SplatRenderer> oracle, screen, halves, floats;
  bool on_lavapipe = false;
};

Image drawn_by(SplatRenderer& renderer, const RenderedObject& object, const Camera& camera) {
  std::vector<Image> images;
  RenderOptions options;
  options.background = kBackground;
  if (const auto done = renderer.draw({&object, 1}, {&camera, 1}, options, images); !done) {
    std::fprintf(stderr, "%s: %s\n", renderer.name().c_str(), done.error().message.c_str());
    std::exit(1);
  }
  return images[0];
}

// Blends the colours over the background.
void put_behind(Image& image) {
  for (size_t i = 0; i < image.pixels.size(); i += 4) {
    for (int c = 0; c < 3; ++c) image.pixels[i + c] += (1.0f - image.pixels[i + 3]) * kBackground[c];
  }
}

// Grey where the pictures are equal; a difference of 1/255 becomes 20/255.
Image amplified_difference(const Image& made, const Image& expected) {
  Image image = made;
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    image.pixels[i] =
        i % 4 == 3 ? 1.0f : std::clamp(0.5f + 20.0f * (made.pixels[i] - expected.pixels[i]), 0.0f, 1.0f);
  }
  return image;
}

bool measure(const Renderers& renderers, const std::string& name, const GaussianAsset& asset,
             const PosedKernels& kernels, View view, const char* view_name,
             const std::filesystem::path& folder) {
  static uint64_t version = 0;
  ++version;
  const RenderedObject object{{&asset, &kernels, 0}, version, version};
  const Camera camera = view_of(extent_of(kernels), view, kWidth, kHeight);
  const Image oracle = drawn_by(*renderers.oracle, object, camera);
  Image shown = oracle;
  for (float& value : shown.pixels) value = std::min(value, 1.0f);  // clamped to the range of a screen
  const Image screen = drawn_by(*renderers.screen, object, camera);
  const Image halves = drawn_by(*renderers.halves, object, camera);
  Image floats = drawn_by(*renderers.floats, object, camera);
  put_behind(floats);
  double bias = 0;
  for (size_t i = 0; i < shown.pixels.size(); ++i)
    bias += i % 4 == 3 ? 0.0 : (halves.pixels[i] - shown.pixels[i]) / (0.75 * shown.pixels.size());
  const double db = psnr_db(screen, shown);
  std::printf("%s,%zu,%d,%s,%d,%d,%.2f,%.2f,%.1e,%.2f,%.0f\n", name.c_str(), asset.size(), asset.sh_degree,
              view_name, kWidth, kHeight, db, psnr_db(halves, shown), bias, psnr_db(floats, oracle), kBar_db);
  std::fflush(stdout);
  if (!folder.empty()) {
    std::filesystem::create_directories(folder);
    const std::string stem = name + "_" + view_name;
    (void)write_png(folder / (stem + "_cpu.png"), shown);
    (void)write_png(folder / (stem + "_vulkan.png"), screen);
    (void)write_png(folder / (stem + "_difference.png"), amplified_difference(screen, shown));
  }
  return db >= kBar_db && psnr_db(halves, shown) >= (renderers.on_lavapipe ? kLavapipeHalf_db : kBar_db);
}

Result<Renderers> make_renderers() {
  auto device = VulkanDevice::create();
  if (!device) return device.error();
  auto screen = create_vulkan_renderer(*device);
  if (!screen) return screen.error();
  auto halves = create_vulkan_renderer(*device, {.precision = BlendPrecision::Half});
  if (!halves) return halves.error();
  auto floats = create_vulkan_renderer(*device, {.precision = BlendPrecision::Full, .read_blended = true});
  if (!floats) return floats.error();
  const bool on_lavapipe = (*screen)->name().find("llvmpipe") != std::string::npos;
  return Renderers{create_cpu_renderer(), *std::move(screen), *std::move(halves), *std::move(floats),
                   on_lavapipe};
}

int run(const std::filesystem::path& folder, const std::string& only) {
  auto renderers = make_renderers();
  if (!renderers) {
    std::fprintf(stderr, "picture_bench: %s\n", renderers.error().message.c_str());
    return 1;
  }
  std::printf("# %s\nasset,kernels,sh_degree,view,width,height,screen_db,half_db,half_bias,full_db,bar_db\n",
              renderers->screen->name().c_str());
  bool all = true;
  size_t drawn = 0;
  const std::filesystem::path captured = std::filesystem::path(LIVEGS_SHARED_DATA_DIR) / "splats";
  std::vector<std::filesystem::path> files;
  for (const char* file : kAssets) files.push_back(captured / file);
  if (std::filesystem::exists(only)) files = {only};
  for (const std::filesystem::path& file : files) {
    const std::string name = file.stem().string();
    if (!only.empty() && files.size() > 1 && name != only) continue;
    Result<AssetFile> asset = read_asset(file);
    if (!asset) {
      std::fprintf(stderr, "%s: skipped\n", asset.error().message.c_str());
      all = false;  // only reported if no asset was drawn
      continue;
    }
    ++drawn;
    const PosedKernels still = pose_asset(asset->asset);
    for (const View view : {View::Front, View::Close, View::Inside})
      all &= measure(*renderers, name, asset->asset, still, view, name_of(view), folder);
    const PosedKernels twisted = pose_asset(asset->asset, kTwist_rad_m);
    all &= measure(*renderers, name, asset->asset, twisted, View::Front, "deformed", folder);
  }
  if (drawn == 0) std::fprintf(stderr, "picture_bench: no captured assets; add the shared data\n");
  return drawn == 0 ? kNothingDrawn : all ? 0 : 1;
}

}  // namespace
}  // namespace livegs

int main(int argc, char** argv) { return livegs::run(argc > 1 ? argv[1] : "", argc > 2 ? argv[2] : ""); }
