// SPDX-License-Identifier: GPL-3.0-or-later
// Segmentation of rooms made in code and of trained splats of a captured table, scored on views that were not
// used. Prints CSV.
//   parts_bench made > tests/bench/results/MACHINE/parts/made.csv
//   parts_bench table SPLAT.ply... > tests/bench/results/MACHINE/parts/table.csv
//   parts_bench fill > tests/bench/results/MACHINE/parts/fill.csv
//   parts_bench clicks > tests/bench/results/MACHINE/parts/clicks.csv
//   parts_bench million > tests/bench/results/MACHINE/parts/million.csv
// LIVEGS_TEST_PICTURES=DIR writes pictures.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>

#include "capture/read/pose_files.h"
#include "core/clock.h"
#include "core/percentile.h"
#include "gaussian/asset_file.h"
#include "parts/click/click_cut.h"
#include "parts/click/kernel_on_ray.h"
#include "parts/label/choose_kernels.h"
#include "parts/labelled_room.h"
#include "parts/room_parts.h"
#include "parts/separate/split_straddling.h"
#include "parts/views/choose_cameras.h"
#include "parts/views/room_view.h"
#include "sample/made_room.h"
#include "server/parts/fill_scores.h"
#include "server/parts/part_scores.h"
#include "splat/image.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

constexpr int kWidth = 320;
constexpr double kOrbit_m = 1.1;
constexpr double kSmallError = 0.01;  // of the pixels of a thing in a view, with which a user is content

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
  if (folder && image.width > 0 && !write_png(std::filesystem::path(folder) / (name + ".png"), image))
    std::fprintf(stderr, "%s: not written\n", name.c_str());
}

struct ViewsUsed {
  std::vector<Camera> known, held_out;
};

// Borders of things after kernels across them are split.
struct BorderScores {
  double mixed_before = 0, mixed_after = 0;  // mixed_kernels()
  AloneScore alone;                          // mean of the things that were found
};

// `alone` draws the mask of a whole thing in a view. Without it the pictures of truth are used, in which
// other things hide parts of it.
BorderScores score_borders(const GaussianAsset& asset, const RoomParts& found, const PartScores& scores,
                           std::span<const Camera> cameras, std::span<const std::vector<uint16_t>> truth,
                           const std::function<std::vector<uint8_t>(uint16_t thing, size_t view)>& alone) {
  BorderScores borders;
  const LabelledRoom labelled = label_room(asset, found);
  const SplitRoom split = split_straddling(asset, found);
  borders.mixed_before = mixed_kernels(asset, found.cameras, found.pictures);
  borders.mixed_after = mixed_kernels(split.asset, found.cameras, found.pictures);
  double count = 0;
  for (const ThingScore& thing : scores.things) {
    if (thing.iou < 0.5) continue;
    std::vector<std::vector<uint8_t>> masks, hidden;
    for (size_t v = 0; v < cameras.size(); ++v) {
      std::vector<uint8_t> mask, behind(truth[v].size(), 0);
      if (alone) {
        mask = alone(thing.truth, v);
      } else {
        for (size_t i = 0; i < truth[v].size(); ++i) {
          mask.push_back(truth[v][i] == thing.truth);
          behind[i] = truth[v][i] > 1 && truth[v][i] != thing.truth;
        }
      }
      masks.push_back(std::move(mask));
      hidden.push_back(std::move(behind));
    }
    const AloneScore one = score_alone(thing_alone(labelled, thing.label), cameras, masks, hidden);
    borders.alone.iou += one.iou, borders.alone.boundary_iou += one.boundary_iou;
    ++count;
  }
  if (count > 0) borders.alone.iou /= count, borders.alone.boundary_iou /= count;
  return borders;
}

void print_header() {
  std::printf(
      "room,views,kernels,things,found,extra,iou,boundary_iou,found_iou,footprint_mm,seconds,mixed_before,"
      "mixed_after,"
      "alone_iou,alone_boundary_iou\n");
}

void print_row(const std::string& room, const char* views, size_t kernels, const PartScores& scores,
               double footprint_m, double seconds, const BorderScores& borders) {
  std::printf("%s,%s,%zu,%zu,%zu,%zu,%.4f,%.4f,%.4f,%.2f,%.2f,%.4f,%.4f,%.4f,%.4f\n", room.c_str(), views,
              kernels, scores.things.size(), scores.found, scores.extra, scores.mean_iou,
              scores.mean_boundary_iou, scores.mean_found_iou, 1e3 * footprint_m, seconds,
              borders.mixed_before, borders.mixed_after, borders.alone.iou, borders.alone.boundary_iou);
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
      print_row(
          room_kind_name(kind), known ? "known" : "chosen", room.asset.size(), scores, found->footprint_m,
          seconds,
          score_borders(room.asset, *found, scores, views.held_out, truth, [&](uint16_t thing, size_t v) {
            std::vector<uint32_t> own;
            for (uint32_t k = 0; k < room.owner.size(); ++k)
              if (room.owner[k] == thing) own.push_back(k);
            const Image image = draw_alone(select_kernels(room.asset, own), views.held_out[v]);
            std::vector<uint8_t> mask;
            for (size_t i = 3; i < image.pixels.size(); i += 4) mask.push_back(image.pixels[i] >= 0.5f);
            return mask;
          }));
      for (const ThingScore& thing : scores.things)
        std::fprintf(stderr, "  %-8s iou %.3f boundary %.3f label %u\n", room.names[thing.truth - 1].c_str(),
                     thing.iou, thing.boundary_iou, thing.label);
      for (const RoomPlane& plane : found->planes.supports)
        std::fprintf(stderr, "  support at %.4f share %.3f deviation %.2f mm area %.2f\n", plane.offset_m,
                     plane.share, 1e3 * plane.deviation_m, plane.region.area_m2());
      for (const RoomPlane& plane : found->planes.walls)
        std::fprintf(stderr, "  wall at %.4f share %.3f\n", plane.offset_m, plane.share);
      for (const RoomPart& part : found->parts)
        std::fprintf(stderr, "  part %u voxels %zu kernels %zu support %d wall %d\n", part.label,
                     part.voxel_count, part.kernel_count, part.support ? static_cast<int>(*part.support) : -1,
                     part.wall ? static_cast<int>(*part.wall) : -1);
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
  auto train = read_transforms_file(data / "transforms_train.json"),
       test = read_transforms_file(data / "transforms_test.json");
  if (!train || !test) return std::fprintf(stderr, "%s: missing\n", data.c_str()), 77;
  ViewsUsed views;
  for (const CapturedView& camera : train->views) views.known.push_back(camera.camera);
  for (const CapturedView& camera : test->views) views.held_out.push_back(camera.camera);
  views.held_out = thin_cameras(views.held_out, views.held_out.size(), kWidth);
  std::vector<std::vector<uint16_t>> truth;
  for (const CapturedView& camera : test->views)
    truth.push_back(
        read_half_mask(data / "masks" / (std::filesystem::path(camera.name).stem().string() + ".png")));
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
          const CapturedView& camera =
              train->views[static_cast<size_t>(m) * train->views.size() / static_cast<size_t>(masks)];
          pictures.push_back({thin_cameras({camera.camera}, 1, kWidth)[0],
                              read_half_mask(data / "masks" /
                                             (std::filesystem::path(camera.name).stem().string() + ".png"))});
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
                score_parts(truth, pictures, kWidth, table), found->footprint_m, seconds, {});
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
      print_row(name, masks ? "3 masks" : "no mask", asset->asset.size(), scores, found->footprint_m, seconds,
                score_borders(asset->asset, *found, scores, views.held_out, truth, nullptr));
      for (const ThingScore& thing : scores.things)
        std::fprintf(stderr, "  %u iou %.3f boundary %.3f label %u\n", thing.truth, thing.iou,
                     thing.boundary_iou, thing.label);
      for (const RoomPlane& plane : found->planes.supports)
        std::fprintf(stderr, "  support at %.4f share %.3f deviation %.2f mm area %.2f\n", plane.offset_m,
                     plane.share, 1e3 * plane.deviation_m, plane.region.area_m2());
      for (const RoomPart& part : found->parts)
        std::fprintf(stderr, "  part %u voxels %zu kernels %zu\n", part.label, part.voxel_count,
                     part.kernel_count);
      const LabelledRoom labelled = label_room(asset->asset, *found);
      for (uint32_t t = 1; t <= found->parts.size() && masks == 0; ++t)
        write_picture(name + "_without" + std::to_string(t),
                      draw_alone(room_without(labelled, std::span(&t, 1)), views.held_out[t % 7]));
      for (size_t v : {size_t{0}, size_t{3}}) {
        const Image picture = draw_alone(asset->asset, views.held_out[v]);
        write_picture(name + std::to_string(masks) + "_" + std::to_string(v),
                      paint_labels(picture, pictures[v]));
      }
    }
  }
  return 0;
}

// The pixel of a mask that is farthest from its rim, by erosion.
std::optional<Eigen::Vector2i> inmost(std::vector<uint8_t> mask, int width) {
  const int height = static_cast<int>(mask.size()) / width;
  std::optional<Eigen::Vector2i> last;
  for (bool any = true; any;) {
    any = false;
    std::vector<uint8_t> next(mask.size(), 0);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const size_t i = static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
        if (!mask[i]) continue;
        if (!any) last = Eigen::Vector2i(x, y);
        any = true;
        next[i] = x > 0 && y > 0 && x + 1 < width && y + 1 < height && mask[i - 1] && mask[i + 1] &&
                  mask[i - static_cast<size_t>(width)] && mask[i + static_cast<size_t>(width)];
      }
    mask = std::move(next);
  }
  return last;
}

// Nothing if the ray of the pixel meets nothing.
std::optional<Click> click_at(const GaussianAsset& asset, const Camera& camera, const Eigen::Vector2i& pixel,
                              bool take) {
  const Eigen::Vector3d ray((pixel.x() + 0.5 - camera.centre_x_px) / camera.focal_x_px,
                            -(pixel.y() + 0.5 - camera.centre_y_px) / camera.focal_y_px, -1);
  const auto kernel = kernel_on_ray(asset, camera.world_from_camera.position_m,
                                    (camera.world_from_camera.orientation * ray).normalized());
  if (!kernel) return {};
  return Click{*kernel, take};
}

// A user who clicks on a thing, then up to twice on the largest error in any view.
int bench_clicks() {
  std::printf("room,thing,iou_1,iou_3,click_ms\n");
  double sum[2] = {};
  size_t count = 0;
  for (const RoomKind kind :
       {RoomKind::Touching, RoomKind::Stacked, RoomKind::Wall, RoomKind::Corner, RoomKind::Crowded}) {
    const MadeRoom room = make_room(kind);
    const bool wall = kind == RoomKind::Wall || kind == RoomKind::Corner;
    const double radius_m = kind == RoomKind::Corner ? 1.6 : kOrbit_m;
    const double first = wall ? -M_PI / 2 - 0.2 : 0.0, sweep = wall ? 2.0 : 2 * M_PI;
    PartsOptions options;
    options.cameras = orbit(room.middle_m, options.up, radius_m, 24, kWidth, first, sweep);
    const auto found = find_parts(room.asset, options);
    if (!found) continue;
    const KernelGraph graph(room.asset, found->label, options.up);
    const auto views = orbit(room.middle_m, options.up, radius_m, 5, kWidth, first + 0.13, sweep);
    std::vector<std::vector<uint16_t>> truth;
    for (const Camera& camera : views) truth.push_back(label_picture(room.asset, room.owner, camera));
    for (uint16_t thing = 1; thing <= room.names.size(); ++thing) {
      std::vector<Click> clicks;
      double iou[2] = {}, click_ms = 0;
      std::vector<std::vector<uint16_t>> pictures(views.size(), std::vector<uint16_t>(truth[0].size(), 0));
      for (int c = 0; c < 3; ++c) {
        // The largest error among all views, by its inmost pixel.
        size_t best_view = 0, most = 0;
        bool take = true;
        for (size_t v = 0; v < views.size(); ++v) {
          size_t missed = 0, extra = 0;
          for (size_t i = 0; i < truth[v].size(); ++i) {
            missed += truth[v][i] == thing && pictures[v][i] != 1;
            extra += truth[v][i] != thing && pictures[v][i] == 1;
          }
          if (std::max(missed, extra) > most)
            most = std::max(missed, extra), best_view = v, take = missed >= extra;
        }
        const auto shown = std::count(truth[best_view].begin(), truth[best_view].end(), thing);
        if (static_cast<double>(most) < kSmallError * static_cast<double>(shown)) break;
        std::vector<uint8_t> mask(truth[best_view].size());
        for (size_t i = 0; i < mask.size(); ++i) {
          const bool in = truth[best_view][i] == thing, got = pictures[best_view][i] == 1;
          mask[i] = take ? in && !got : !in && got;
        }
        const int64_t start_ns = now_ns();
        if (const auto click = click_at(room.asset, views[best_view], *inmost(mask, kWidth), take))
          clicks.push_back(*click);
        const CutThing cut = cut_thing(graph, found->label, clicks);
        click_ms = milliseconds_from_ns(now_ns() - start_ns);
        std::vector<uint16_t> label(room.asset.size(), 0);
        for (uint32_t k : cut.kernels) label[k] = 1;
        size_t both = 0, either = 0;
        for (size_t v = 0; v < views.size(); ++v) {
          pictures[v] = label_picture(room.asset, label, views[v]);
          for (size_t i = 0; i < truth[v].size(); ++i) {
            const bool in = truth[v][i] == thing, got = pictures[v][i] == 1;
            both += in && got;
            either += in || got;
          }
        }
        (c == 0 ? iou[0] : iou[1]) =
            static_cast<double>(both) / static_cast<double>(std::max<size_t>(either, 1));
        if (c == 0) iou[1] = iou[0];
      }
      std::printf("%s,%s,%.4f,%.4f,%.1f\n", room_kind_name(kind), room.names[thing - 1].c_str(), iou[0],
                  iou[1], click_ms);
      std::fflush(stdout);
      sum[0] += iou[0], sum[1] += iou[1], ++count;
    }
  }
  std::printf("all,mean,%.4f,%.4f,\n", sum[0] / static_cast<double>(count),
              sum[1] / static_cast<double>(count));
  return 0;
}

struct RoomViews {
  std::vector<Camera> known, held_out;
};

// The made rooms have walls behind and on the left; cameras stay before and to the right of them.
RoomViews views_of(const MadeRoom& room, RoomKind kind, size_t known, size_t held_out) {
  const Eigen::Vector3d up(0, -1, 0);
  const bool wall = kind == RoomKind::Wall || kind == RoomKind::Corner;
  const double radius_m = kind == RoomKind::Corner ? 1.6 : kOrbit_m;
  const double first = wall ? -M_PI / 2 - 0.2 : 0.0, sweep = wall ? 2.0 : 2 * M_PI;
  return {orbit(room.middle_m, up, radius_m, known, kWidth, first, sweep),
          orbit(room.middle_m, up, radius_m, held_out, kWidth, first + 0.13, sweep)};
}

// Takes each thing out of each room and compares the rest with the room made without it.
int bench_fill(const std::string& only) {
  std::printf("room,thing,iou,hole_pixels,psnr_db,rim_psnr_db,depth_p95_mm,open_share,label_s\n");
  // Places on planes only, and those at which things touch others too.
  FillScores sum[2];
  double count[2] = {};
  for (const RoomKind kind : kRoomKinds) {
    const size_t group =
        kind == RoomKind::Apart || kind == RoomKind::Wall || kind == RoomKind::Corner ? 0 : 1;
    if (kind == RoomKind::Empty || (!only.empty() && only != room_kind_name(kind))) continue;
    const MadeRoom room = make_room(kind);
    const RoomViews views = views_of(room, kind, 32, 7);
    PartsOptions options;
    options.cameras = views.known;
    const auto found = find_parts(room.asset, options);
    if (!found) continue;
    const int64_t start_ns = now_ns();
    const LabelledRoom labelled = label_room(room.asset, *found);
    const double label_s = seconds_since(start_ns);
    std::vector<std::vector<uint16_t>> truth, pictures;
    for (const Camera& camera : views.held_out) {
      truth.push_back(label_picture(room.asset, room.owner, camera));
      pictures.push_back(label_picture(room.asset, found->label, camera));
    }
    for (const ThingScore& thing : score_parts(truth, pictures, kWidth).things) {
      if (thing.label == 0) continue;
      MadeRoomOptions without;
      without.without = thing.truth - 1;
      const MadeRoom twin = make_room(kind, without);
      const uint32_t taken[] = {thing.label};
      const GaussianAsset after = room_without(labelled, taken);
      const FillScores scores = score_fill(room.asset, twin.asset, after, views.held_out);
      const std::string& name = room.names[thing.truth - 1];
      std::printf("%s,%s,%.4f,%zu,%.2f,%.2f,%.2f,%.4f,%.2f\n", room_kind_name(kind), name.c_str(), thing.iou,
                  scores.hole_pixels, scores.psnr_db, scores.rim_psnr_db, scores.depth_p95_mm,
                  scores.open_share, label_s);
      std::fflush(stdout);
      for (size_t v : {size_t{0}, size_t{3}})
        write_picture(std::string("fill_") + room_kind_name(kind) + "_" + name + std::to_string(v),
                      fill_picture(room.asset, twin.asset, after, with_width(views.held_out[v], 2 * kWidth)));
      if (scores.hole_pixels == 0) continue;
      sum[group].psnr_db += scores.psnr_db, sum[group].rim_psnr_db += scores.rim_psnr_db;
      sum[group].depth_p95_mm = std::max(sum[group].depth_p95_mm, scores.depth_p95_mm);
      sum[group].open_share += scores.open_share;
      ++count[group];
    }
  }
  for (size_t group = 0; group < 2; ++group)
    if (count[group] > 0)
      std::printf("%s,mean of %.0f (largest depth),,,%.2f,%.2f,%.2f,%.4f,\n",
                  group == 0 ? "planes" : "crowds", count[group], sum[group].psnr_db / count[group],
                  sum[group].rim_psnr_db / count[group], sum[group].depth_p95_mm,
                  sum[group].open_share / count[group]);
  return 0;
}

int bench_million() {
  MadeRoomOptions made;
  made.spacing_m = 0.00126;
  const MadeRoom room = make_room(RoomKind::Crowded, made);
  PartsOptions options;
  options.max_views = 12;
  options.cameras = orbit(room.middle_m, options.up, kOrbit_m, 12, kWidth, 0, 2 * M_PI);
  int64_t start_ns = now_ns();
  const auto found = find_parts(room.asset, options);
  const double parts_s = seconds_since(start_ns);
  if (!found) return std::fprintf(stderr, "%s\n", found.error().message.c_str()), 1;
  start_ns = now_ns();
  const KernelGraph graph(room.asset, found->label, options.up);
  const double graph_s = seconds_since(start_ns);
  // A click takes the thing of a kernel; two clicks divide it between the kernel and another one.
  std::vector<double> hover_ms, click_ms, divide_ms;
  const auto views = orbit(room.middle_m, options.up, kOrbit_m, 5, kWidth, 0.13, 2 * M_PI);
  std::optional<Click> last;
  for (const Camera& camera : views)
    for (int y = 8; y < camera.height; y += 8)
      for (int x = 8; x < camera.width; x += 8) {
        if (click_ms.size() >= 200) break;
        start_ns = now_ns();
        const auto click = click_at(room.asset, camera, {x, y}, true);
        hover_ms.push_back(milliseconds_from_ns(now_ns() - start_ns));
        if (!click || found->label[click->kernel] == 0) continue;
        (void)cut_thing(graph, found->label, std::span(&*click, 1));
        click_ms.push_back(milliseconds_from_ns(now_ns() - start_ns));
        if (last && found->label[last->kernel] == found->label[click->kernel]) {
          const Click two[] = {*last, {click->kernel, false}};
          start_ns = now_ns();
          (void)cut_thing(graph, found->label, two);
          divide_ms.push_back(milliseconds_from_ns(now_ns() - start_ns));
        }
        last = click;
      }
  std::printf(
      "kernels,parts,parts_s,graph_s,hover_p50_ms,hover_p95_ms,click_p50_ms,click_p95_ms,divide_p50_ms,"
      "divide_p95_ms\n%zu,%zu,%.2f,%.2f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f\n",
      room.asset.size(), found->parts.size(), parts_s, graph_s, percentile(hover_ms, 0.5),
      percentile(hover_ms, 0.95), percentile(click_ms, 0.5), percentile(click_ms, 0.95),
      percentile(divide_ms, 0.5), percentile(divide_ms, 0.95));
  return 0;
}

}  // namespace
}  // namespace livegs

int main(int argc, char** argv) {
  if (argc >= 2 && std::strcmp(argv[1], "made") == 0) return livegs::bench_made(argc > 2 ? argv[2] : "");
  if (argc >= 3 && std::strcmp(argv[1], "table") == 0)
    return livegs::bench_table(std::span(argv + 2, static_cast<size_t>(argc - 2)));
  if (argc == 2 && std::strcmp(argv[1], "clicks") == 0) return livegs::bench_clicks();
  if (argc >= 2 && std::strcmp(argv[1], "fill") == 0) return livegs::bench_fill(argc > 2 ? argv[2] : "");
  if (argc == 2 && std::strcmp(argv[1], "million") == 0) return livegs::bench_million();
  std::fprintf(stderr,
               "usage: parts_bench made [ROOM] | table SPLAT.ply... | clicks | fill [ROOM] | million\n");
  return 2;
}
