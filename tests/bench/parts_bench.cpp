// SPDX-License-Identifier: GPL-3.0-or-later
// Segmentation of rooms made in code and of trained splats of a captured table, scored on views that were not
// used. Prints CSV.
//   parts_bench made > tests/bench/results/parts_made.csv
//   parts_bench table SPLAT.ply... > tests/bench/results/parts_table.csv
// LIVEGS_TEST_PICTURES=DIR writes pictures.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

#include "core/clock.h"
#include "gaussian/asset_file.h"
#include "parts/room_parts.h"
#include "parts/separate/split_straddling.h"
#include "parts/views/choose_cameras.h"
#include "parts/views/room_view.h"
#include "parts/views/transforms_file.h"
#include "sample/made_room.h"
#include "server/parts/part_scores.h"
#include "splat/image.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

constexpr int kWidth = 320;
constexpr double kOrbit_m = 1.1;

double seconds_since(int64_t start_ns) { return 1e-3 * milliseconds_from_ns(now_ns() - start_ns); }

Image draw_alone(const GaussianAsset& asset, const Camera& camera) {
  const PosedKernels posed = pose_in_place(asset);
  const DrawnObject object{&asset, &posed, 0};
  Rasteriser rasteriser;
  RasterisedView view;
  rasteriser.draw(std::span(&object, 1), camera, {}, view);
  return view.image;
}

void write_picture(const std::string& name, const Image& image) {
  const char* folder = std::getenv("LIVEGS_TEST_PICTURES");
  if (folder && !write_png(std::filesystem::path(folder) / (name + ".png"), image))
    std::fprintf(stderr, "%s: not written\n", name.c_str());
}

struct ViewsUsed {
  std::vector<Camera> known, held_out;
};

void print_header() {
  std::printf("room,views,kernels,things,found,extra,iou,boundary_iou,found_iou,footprint_mm,seconds\n");
}

void print_row(const std::string& room, const char* views, size_t kernels, const PartScores& scores,
               double footprint_m, double seconds) {
  std::printf("%s,%s,%zu,%zu,%zu,%zu,%.4f,%.4f,%.4f,%.2f,%.2f\n", room.c_str(), views, kernels,
              scores.things.size(), scores.found, scores.extra, scores.mean_iou, scores.mean_boundary_iou,
              scores.mean_found_iou, 1e3 * footprint_m, seconds);
  std::fflush(stdout);
}

int bench_made(const std::string& only) {
  print_header();
  for (const RoomKind kind : kRoomKinds) {
    if (!only.empty() && only != room_kind_name(kind)) continue;
    const MadeRoom room = make_room(kind);
    const Eigen::Vector3d up(0, -1, 0);
    // The made rooms have walls behind and on the left; cameras stay before and to the right of them.
    const bool wall = kind == RoomKind::Wall || kind == RoomKind::Corner;
    const double radius_m = kind == RoomKind::Corner ? 1.6 : kOrbit_m;
    const double first = wall ? -0.2 : 0.0, sweep = wall ? 2.0 : 2 * M_PI;
    ViewsUsed views;
    views.known = orbit(room.middle_m, up, radius_m, 32, kWidth, wall ? -M_PI / 2 + first : first, sweep);
    views.held_out =
        orbit(room.middle_m, up, radius_m, 7, kWidth, (wall ? -M_PI / 2 + first : first) + 0.13, sweep);
    std::vector<std::vector<uint16_t>> truth;
    for (const Camera& camera : views.held_out)
      truth.push_back(label_picture(room.asset, room.owner, camera));
    for (const bool known : {true, false}) {
      PartsOptions options;
      options.up = up;
      if (known) options.cameras = views.known;
      const int64_t start_ns = now_ns();
      auto found = find_parts(room.asset, options);
      const double seconds = seconds_since(start_ns);
      if (!found) {
        std::fprintf(stderr, "%s: %s\n", room_kind_name(kind), found.error().message.c_str());
        continue;
      }
      std::vector<std::vector<uint16_t>> pictures;
      for (const Camera& camera : views.held_out)
        pictures.push_back(label_picture(room.asset, found->label, camera));
      const PartScores scores = score_parts(truth, pictures, kWidth);
      print_row(room_kind_name(kind), known ? "known" : "chosen", room.asset.size(), scores,
                found->footprint_m, seconds);
      for (const ThingScore& thing : scores.things)
        std::fprintf(stderr, "  %-8s iou %.3f boundary %.3f label %u\n", room.names[thing.truth - 1].c_str(),
                     thing.iou, thing.boundary_iou, thing.label);
      for (const RoomPlane& plane : found->planes.supports)
        std::fprintf(stderr, "  support at %.4f share %.3f deviation %.2f mm area %.2f\n", plane.offset_m,
                     plane.share, 1e3 * plane.deviation_m, plane.region.area_m2());
      for (const RoomPlane& plane : found->planes.walls)
        std::fprintf(stderr, "  wall at %.4f share %.3f\n", plane.offset_m, plane.share);
      for (const RoomPart& part : found->parts)
        std::fprintf(stderr, "  part %u voxels %zu kernels %zu support %d wall %d size %.2f %.2f %.2f\n",
                     part.label, part.voxel_count, part.kernel_count,
                     part.support ? static_cast<int>(*part.support) : -1,
                     part.wall ? static_cast<int>(*part.wall) : -1, part.bounds_m.sizes().x(),
                     part.bounds_m.sizes().y(), part.bounds_m.sizes().z());
      const std::string name = std::string(room_kind_name(kind)) + (known ? "_known" : "_chosen");
      for (size_t v : {size_t{0}, size_t{3}}) {
        const Image picture = draw_alone(room.asset, views.held_out[v]);
        if (known) write_picture(std::string(room_kind_name(kind)) + std::to_string(v), picture);
        write_picture(name + std::to_string(v), paint_labels(picture, pictures[v]));
      }
      if (!known)
        for (size_t v = 0; v < 4 && v < found->cameras.size(); ++v)
          write_picture(name + "_view" + std::to_string(v),
                        paint_labels(draw_alone(room.asset, found->cameras[v]), found->pictures[v]));
    }
  }
  return 0;
}

// Labels of a mask picture at half its size: the most frequent of four pixels, the lowest in a tie.
std::vector<uint16_t> read_half_mask(const std::filesystem::path& path) {
  auto image = read_png(path);
  if (!image) return {};
  std::vector<uint16_t> labels;
  for (int y = 0; y + 1 < image->height; y += 2)
    for (int x = 0; x + 1 < image->width; x += 2) {
      uint16_t four[4];
      for (int i = 0; i < 4; ++i)
        four[i] = static_cast<uint16_t>(std::lround(255 * image->at(x + i % 2, y + i / 2)[0]));
      std::sort(four, four + 4);
      labels.push_back(four[1] == four[3]                         ? four[1]
                       : four[2] == four[3] && four[0] != four[1] ? four[2]
                                                                  : four[0]);
    }
  return labels;
}

int bench_table(std::span<char*> files) {
  const std::filesystem::path data = std::filesystem::path(LIVEGS_SHARED_DATA_DIR) / "multiview/ycb_tabletop";
  auto train = read_transforms(data / "transforms_train.json"),
       test = read_transforms(data / "transforms_test.json");
  if (!train || !test) return std::fprintf(stderr, "%s: missing\n", data.c_str()), 77;
  ViewsUsed views;
  for (const NamedCamera& camera : *train) views.known.push_back(camera.camera);
  for (const NamedCamera& camera : *test) views.held_out.push_back(camera.camera);
  views.held_out = thin_cameras(views.held_out, views.held_out.size(), kWidth);
  std::vector<std::vector<uint16_t>> truth;
  for (const NamedCamera& camera : *test)
    truth.push_back(read_half_mask(data / "masks" / (camera.name + ".png")));
  const uint16_t table[] = {1};
  print_header();
  for (char* file : files) {
    auto asset = read_asset(file);
    if (!asset) return std::fprintf(stderr, "%s\n", asset.error().message.c_str()), 1;
    const std::string name = std::filesystem::path(file).stem().string();
    for (int masks : {0, 3}) {
      PartsOptions options;
      options.up = Eigen::Vector3d(0, 0, 1);
      options.cameras = views.known;
      const int64_t start_ns = now_ns();
      Result<RoomParts> found = Error{};
      if (masks == 0) {
        found = find_parts(asset->asset, options);
      } else {
        std::vector<LabelPicture> pictures;
        for (int m = 0; m < masks; ++m) {
          const NamedCamera& camera =
              (*train)[static_cast<size_t>(m) * train->size() / static_cast<size_t>(masks)];
          pictures.push_back({thin_cameras({camera.camera}, 1, kWidth)[0],
                              read_half_mask(data / "masks" / (camera.name + ".png"))});
          for (uint16_t& label : pictures.back().labels) label = label < 2 ? 0 : label - 1;
        }
        found = lift_labels(asset->asset, std::move(pictures), options);
      }
      const double seconds = seconds_since(start_ns);
      if (!found) return std::fprintf(stderr, "%s: %s\n", name.c_str(), found.error().message.c_str()), 1;
      std::vector<std::vector<uint16_t>> pictures;
      for (const Camera& camera : views.held_out)
        pictures.push_back(label_picture(asset->asset, found->label, camera));
      print_row(name, masks ? "3 masks whole" : "no mask whole", asset->asset.size(),
                score_parts(truth, pictures, kWidth, table), found->footprint_m, seconds);
      const SplitRoom split = split_straddling(asset->asset, *found);
      pictures.clear();
      double joined_db = 1e9;
      for (const Camera& camera : views.held_out) {
        pictures.push_back(label_picture(split.asset, split.label, camera));
        joined_db =
            std::min(joined_db, psnr_db(draw_alone(asset->asset, camera), draw_alone(split.asset, camera)));
      }
      std::fprintf(stderr, "  split %zu of %zu, parts together %.2f dB\n", split.split_count,
                   asset->asset.size(), joined_db);
      const PartScores scores = score_parts(truth, pictures, kWidth, table);
      print_row(name, masks ? "3 masks" : "no mask", asset->asset.size(), scores, found->footprint_m,
                seconds);
      for (const ThingScore& thing : scores.things)
        std::fprintf(stderr, "  %u iou %.3f boundary %.3f label %u\n", thing.truth, thing.iou,
                     thing.boundary_iou, thing.label);
      for (const RoomPlane& plane : found->planes.supports)
        std::fprintf(stderr, "  support at %.4f share %.3f deviation %.2f mm area %.2f\n", plane.offset_m,
                     plane.share, 1e3 * plane.deviation_m, plane.region.area_m2());
      for (const RoomPart& part : found->parts)
        std::fprintf(stderr, "  part %u voxels %zu kernels %zu\n", part.label, part.voxel_count,
                     part.kernel_count);
      for (size_t v : {size_t{0}, size_t{3}}) {
        const Image picture = draw_alone(asset->asset, views.held_out[v]);
        write_picture(name + std::to_string(masks) + "_" + std::to_string(v),
                      paint_labels(picture, pictures[v]));
      }
    }
  }
  return 0;
}

}  // namespace
}  // namespace livegs

int main(int argc, char** argv) {
  if (argc >= 2 && std::strcmp(argv[1], "made") == 0) return livegs::bench_made(argc > 2 ? argv[2] : "");
  if (argc >= 3 && std::strcmp(argv[1], "table") == 0)
    return livegs::bench_table(std::span(argv + 2, static_cast<size_t>(argc - 2)));
  std::fprintf(stderr, "usage: parts_bench made [ROOM] | parts_bench table SPLAT.ply...\n");
  return 2;
}
