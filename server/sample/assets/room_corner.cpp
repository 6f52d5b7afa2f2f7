// SPDX-License-Identifier: GPL-3.0-or-later
// A corner of a room: oak parquet in herringbone, painted skirting, plaster walls lit by a tall window, and a
// framed print. Flat surfaces need few kernels, laid row by row; only edges and the print are fine.
#include <algorithm>
#include <cmath>
#include <functional>

#include "sample/sample_scene.h"
#include "sample/tools/baked_light.h"
#include "sample/tools/colour.h"
#include "sample/tools/noise.h"
#include "sample/tools/surface_sampler.h"
#include "sample/tools/wood.h"

namespace livegs {
namespace {

using namespace sample;
using Eigen::Vector3d;

constexpr int kBoard = 0, kSeam = 1, kWall = 2, kSkirting = 3, kFrame = 4, kPrint = 5, kMat = 6;
constexpr double kRoomHalf_m = 1.5, kWallHeight_m = 2.4;
constexpr double kSkirtingHeight_m = 0.11, kSkirtingDepth_m = 0.016;
const Vector3d kPictureLow_m(-0.42, 1.10, -kRoomHalf_m);  // lower left corner of the picture
constexpr double kPictureWidth_m = 0.62, kPictureHeight_m = 0.82;
constexpr double kBoardLength_m = 0.48, kBoardWidth_m = 0.08;

// A flat rectangle of kernels in rows, jittered by a fifth of the spacing.
void lay_rectangle(const Vector3d& corner_m, const Vector3d& along_m, const Vector3d& across_m,
                   double spacing_m, double stretch, int part, Random& random, SurfaceSamples& samples) {
  const Vector3d tangent = along_m.normalized(), normal = along_m.cross(across_m).normalized();
  const int rows = std::max(1, static_cast<int>(std::lround(across_m.norm() / spacing_m)));
  const int columns = std::max(1, static_cast<int>(std::lround(along_m.norm() / (spacing_m * stretch))));
  const double pitch_m = across_m.norm() / rows;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const double shift = row % 2 ? 0.25 : -0.25;
      const double u = std::clamp((column + 0.5 + shift + 0.2 * random.uniform(-1, 1)) / columns, 0.0, 1.0);
      const double v = (row + 0.5 + 0.15 * random.uniform(-1, 1)) / rows;
      samples.push_back({corner_m + u * along_m + v * across_m, normal, tangent, u, v, pitch_m,
                         along_m.norm() / columns / pitch_m, part});
    }
}

class Decor {
 public:
  explicit Decor(uint64_t seed) : seed_(seed) {}

  Appearance operator()(const SurfaceSample& s) const {
    const Vector3d& p = s.position_m;
    Appearance a;
    a.overlap = 0.80;
    a.flatness = 0.12;
    switch (s.part) {
      case kBoard:
      case kSeam:
        floor(s, a);
        break;
      case kWall:
        wall(p, a);
        break;
      case kSkirting:
        a.albedo = linear_from_hex(0xEDEAE2) * (1 + 0.02 * fractal_noise(p / 0.2, 2, seed_));
        a.gloss = 0.05;
        a.gloss_width = 0.5;
        break;
      case kFrame:
        a.albedo = wood_albedo(Vector3d(p.x() + p.y(), p.y() - p.x(), p.z() + 0.03),
                               {linear_from_hex(0x6B4A30), linear_from_hex(0x533522), 0.012, 0.3}, seed_ + 3);
        break;
      case kMat:
        a.albedo = linear_from_hex(0xF3EFE4);
        break;
      default:
        print(s, a);
        break;
    }
    a.albedo *= window_light(s) * corner_shade(s);
    return a;
  }

 private:
  void floor(const SurfaceSample& s, Appearance& a) const {
    const Vector3d& p = s.position_m;
    a.gloss = 0.10;
    a.gloss_width = 0.45;
    if (s.part == kSeam) {
      a.albedo = linear_from_hex(0x4A3018);
      a.opacity = 0.72;
      a.overlap = 1.0;
      return;
    }
    // v is the board's number, u the position across it. Each board has its own cut, tone and streaks.
    const auto board = static_cast<int64_t>(s.v);
    const auto dice = [&](int64_t which) { return lattice_random(board, which, 0, seed_ + 11); };
    const double along_m = p.dot(s.tangent) + 3.1 * dice(3);
    const Vector3d grain(along_m, 0.030 + 0.04 * dice(4), s.u + 0.10 * (dice(5) - 0.5));
    const WoodTone oak{linear_from_hex(0xC79B68), linear_from_hex(0xA8743F), 0.026, 0.0};
    const double streak = value_noise(Vector3d(along_m / 0.22, s.u / 0.011, s.v), seed_ + 17);
    a.albedo = wood_albedo(grain, oak, seed_ + 13 + static_cast<uint64_t>(board % 7)) *
               (1 + 0.26 * (dice(1) - 0.5) + 0.09 * streak);
    const double warm = dice(2) - 0.5;
    a.albedo = a.albedo.cwiseProduct(Vector3d(1 + 0.05 * warm, 1, 1 - 0.10 * warm));
  }

  void wall(const Vector3d& p, Appearance& a) const {
    a.albedo = linear_from_hex(0xDED3BE) * (1 + 0.03 * fractal_noise(p / 0.35, 4, seed_ + 31) +
                                            0.015 * value_noise(p / 0.05, seed_ + 33));
    a.flatness = 0.05;
    a.bump = 0.03 * Vector3d(value_noise(p / 0.12, seed_ + 34), value_noise(p / 0.12, seed_ + 35),
                             value_noise(p / 0.12, seed_ + 36));
  }

  // A print in flat inks: the sun and its reflection between hills.
  void print(const SurfaceSample& s, Appearance& a) const {
    const double x = s.u * 2 - 1, y = s.v * 2 - 1;
    Vector3d ink = blend(linear_from_hex(0xF0D2A4), linear_from_hex(0xE9A071), smooth_step(0.9, -0.2, y));
    const double sun = std::hypot((x - 0.15) * 0.72, y - 0.22);
    ink = blend(linear_from_hex(0xD8432B), ink, smooth_step(0.27, 0.285, sun));
    struct Hill {
      double base, height, pitch;
      uint32_t colour;
    };
    for (const Hill& h : {Hill{0.06, 0.24, 1.3, 0x7FA09A}, Hill{-0.18, 0.26, 1.9, 0x4F7C7D},
                          Hill{-0.46, 0.24, 2.6, 0x2B555E}, Hill{-0.72, 0.16, 2.2, 0x17343F}}) {
      const double crest =
          h.base + h.height * value_noise(Vector3d(x * h.pitch + 10 * h.base, h.base * 31, 0.5), seed_ + 41);
      ink = blend(ink, linear_from_hex(h.colour), smooth_step(crest + 0.012, crest - 0.012, y));
    }
    a.albedo = ink * (1 + 0.03 * value_noise(s.position_m / 0.006, seed_ + 43));
    a.gloss = 0.04;
    a.gloss_width = 0.4;
  }

  // Light of a tall window, four panes by two, out of view on the right. It falls on the back wall and the
  // floor and gets softer with distance. The rest of the room is lit by scattered light.
  static double window_light(const SurfaceSample& s) {
    const Vector3d light = key_direction();
    const Vector3d q = s.position_m + 0.004 * s.normal;
    const double travel_m = (2.6 - q.x()) / light.x();
    const Vector3d at = q + light * travel_m;  // intersection of the ray with the window's plane
    const double blur_m = 0.010 + 0.012 * travel_m;
    const auto opening = [&](double value, double low, double high) {
      return smooth_step(low - blur_m, low + blur_m, value) *
             smooth_step(high + blur_m, high - blur_m, value);
    };
    double through = 0.0;
    for (int column = 0; column < 2; ++column)
      for (int row = 0; row < 4; ++row)
        through += opening(at.z(), 1.05 + 0.72 * column, 1.05 + 0.72 * column + 0.64) *
                   opening(at.y(), 3.05 + 0.68 * row, 3.05 + 0.68 * row + 0.61);
    const double distance = std::hypot(q.x() - 1.5, q.z() - 1.5) / 4.2;
    const double gradient =
        0.88 - 0.22 * smooth_step(0.1, 1.0, distance) - 0.08 * smooth_step(1.0, 2.4, q.y());
    return gradient + 0.42 * through;
  }

  // Ambient occlusion where planes meet: a narrow crease and a wide falloff.
  static double corner_shade(const SurfaceSample& s) {
    const auto crease = [](double distance_m) {
      const double d = std::max(0.0, distance_m);
      return 1 - 0.09 * std::exp(-d / 0.05) - 0.17 * std::exp(-d / 0.40);
    };
    double shade = 1.0;
    if (std::abs(s.normal.x()) < 0.7) shade *= crease(s.position_m.x() + kRoomHalf_m);
    if (std::abs(s.normal.y()) < 0.7) shade *= crease(s.position_m.y());
    if (std::abs(s.normal.z()) < 0.7) shade *= crease(s.position_m.z() + kRoomHalf_m);
    return shade;
  }

  uint64_t seed_;
};

// Herringbone: boards at right angles, each pair offset by one width. Boards are clipped to the room.
void lay_parquet(Random& random, SurfaceSamples& samples) {
  const Eigen::Rotation2Dd turn(0.78539816339);
  const double length = kBoardLength_m, width = kBoardWidth_m;
  int number = 0;
  // Rows across one board, closer at its edges so that the seam stays sharp.
  const double rows_m[] = {0.0022, 0.0085, 0.0170, 0.0270, 0.0400, 0.0530, 0.0630, 0.0715, 0.0778};
  const double sizes_m[] = {0.0040, 0.0074, 0.0092, 0.0115, 0.0130, 0.0115, 0.0092, 0.0074, 0.0040};
  const auto inside = [](const Eigen::Vector2d& p, double margin) {
    return std::abs(p.x()) <= kRoomHalf_m + margin && std::abs(p.y()) <= kRoomHalf_m + margin;
  };
  const auto lay = [&](const Eigen::Vector2d& low, bool along_first) {
    const Eigen::Vector2d along = along_first ? Eigen::Vector2d(1, 0) : Eigen::Vector2d(0, 1);
    const Eigen::Vector2d across = along_first ? Eigen::Vector2d(0, 1) : Eigen::Vector2d(1, 0);
    const Eigen::Vector2d middle = turn * (low + 0.5 * length * along + 0.5 * width * across);
    if (!inside(middle, 0.36)) return;
    ++number;
    const auto put = [&](double l_m, double w_m, double spacing_m, double stretch, int part, bool lengthwise,
                         double y_m) {
      const Eigen::Vector2d flat = turn * (low + l_m * along + w_m * across);
      if (!inside(flat, -0.002)) return;
      const Eigen::Vector2d direction = turn * (lengthwise ? along : across);
      samples.push_back({{flat.x(), y_m, flat.y()},
                         Vector3d::UnitY(),
                         {direction.x(), 0, direction.y()},
                         w_m,
                         static_cast<double>(number),
                         spacing_m,
                         stretch,
                         part});
    };
    for (size_t row = 0; row < std::size(rows_m); ++row) {
      constexpr int kColumns = 17;
      for (int column = 0; column < kColumns; ++column) {
        const double pitch_m = (length - 0.006) / kColumns;
        double l_m =
            0.003 + pitch_m * (column + 0.5 + (row % 2 ? 0.25 : -0.25) + 0.12 * random.uniform(-1, 1));
        l_m = std::clamp(l_m, 0.013, length - 0.013);
        const double stretch = std::min(pitch_m, 0.028) / sizes_m[row] * 0.85;
        put(l_m, rows_m[row] + 0.001 * random.uniform(-1, 1), sizes_m[row], std::max(1.0, stretch), kBoard,
            true, 0.0);
      }
    }
    for (int i = 0; i < 24; ++i) put((i + 0.5) * length / 24, 0.0, 0.00075, 17.0, kSeam, true, 0.0004);
    for (int i = 0; i < 4; ++i) put(0.0, (i + 0.5) * width / 4, 0.00075, 17.0, kSeam, false, 0.0004);
  };
  // Lattice of the pattern: boards along the first axis at (i w, i w + 2 L j), then the perpendicular board
  // that meets them.
  for (int j = -8; j <= 8; ++j)
    for (int i = -60; i <= 60; ++i) {
      const Eigen::Vector2d step(i * width + j * length, i * width - j * length);
      lay(step, true);
      lay(step + Eigen::Vector2d(length, width - length + 0.0), false);
    }
}

void lay_skirting(Random& random, SurfaceSamples& samples) {
  const double h = kSkirtingHeight_m, d = kSkirtingDepth_m;
  const double bevel = 0.008;
  // The board on the back wall faces +z, the one on the left wall +x. Each has a face, a bevel and a top.
  lay_rectangle({-kRoomHalf_m + d, 0, -kRoomHalf_m + d}, {2 * kRoomHalf_m - d, 0, 0}, {0, h - bevel, 0},
                0.012, 2.0, kSkirting, random, samples);
  lay_rectangle({-kRoomHalf_m + d, h - bevel, -kRoomHalf_m + d}, {2 * kRoomHalf_m - d, 0, 0},
                {0, bevel, -bevel}, 0.0045, 5.0, kSkirting, random, samples);
  lay_rectangle({-kRoomHalf_m + d, h, -kRoomHalf_m + d - bevel}, {2 * kRoomHalf_m - d, 0, 0},
                {0, 0, bevel - d}, 0.0045, 5.0, kSkirting, random, samples);
  lay_rectangle({-kRoomHalf_m + d, 0, kRoomHalf_m}, {0, 0, d - 2 * kRoomHalf_m}, {0, h - bevel, 0}, 0.012,
                2.0, kSkirting, random, samples);
  lay_rectangle({-kRoomHalf_m + d, h - bevel, kRoomHalf_m}, {0, 0, d - 2 * kRoomHalf_m}, {-bevel, bevel, 0},
                0.0045, 5.0, kSkirting, random, samples);
  lay_rectangle({-kRoomHalf_m + d - bevel, h, kRoomHalf_m}, {0, 0, d - 2 * kRoomHalf_m}, {bevel - d, 0, 0},
                0.0045, 5.0, kSkirting, random, samples);
}

void lay_picture(Random& random, SurfaceSamples& samples) {
  const double width = kPictureWidth_m, height = kPictureHeight_m, border = 0.022, mat = 0.075, depth = 0.020;
  const Vector3d& low = kPictureLow_m;
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  const auto face = [&](double x0, double y0, double x1, double y1, double out, double spacing, int part) {
    lay_rectangle(low + x0 * x + y0 * y + out * z, (x1 - x0) * x, (y1 - y0) * y, spacing, 1.0, part, random,
                  samples);
  };
  const auto upright = [&](double x0, double y0, double x1, double y1, double out, double spacing, int part) {
    lay_rectangle(low + x1 * x + y0 * y + out * z, (y1 - y0) * y, (x0 - x1) * x, spacing, 1.0, part, random,
                  samples);
  };
  face(0, 0, width, border, depth, 0.0044, kFrame);
  face(0, height - border, width, height, depth, 0.0044, kFrame);
  upright(0, border, border, height - border, depth, 0.0044, kFrame);
  upright(width - border, border, width, height - border, depth, 0.0044, kFrame);
  // Outer sides of the frame.
  lay_rectangle(low, width * x, depth * z, 0.005, 2.0, kFrame, random, samples);
  lay_rectangle(low + height * y + depth * z, width * x, -depth * z, 0.005, 2.0, kFrame, random, samples);
  lay_rectangle(low + depth * z, height * y, -depth * z, 0.005, 2.0, kFrame, random, samples);
  lay_rectangle(low + width * x, height * y, depth * z, 0.005, 2.0, kFrame, random, samples);
  const double a = border, b = border + mat;
  face(a, a, width - a, b, 0.010, 0.008, kMat);
  face(a, height - b, width - a, height - a, 0.010, 0.008, kMat);
  face(a, b, b, height - b, 0.010, 0.008, kMat);
  face(width - b, b, width - a, height - b, 0.010, 0.008, kMat);
  face(b, b, width - b, height - b, 0.0095, 0.0058, kPrint);
}

// Distance of a point of the back wall inside the frame's outline, metres; negative outside. No kernels are
// placed behind the picture, because wide kernels so close would be drawn over it from the side.
double picture_depth_m(const Vector3d& p) {
  return std::min({p.x() - kPictureLow_m.x(), kPictureLow_m.x() + kPictureWidth_m - p.x(),
                   p.y() - kPictureLow_m.y(), kPictureLow_m.y() + kPictureHeight_m - p.y()});
}

// Plaster, irregular so that no rows are visible; finer along the edges so that they are straight.
void lay_wall(const std::function<Vector3d(double, double)>& position_m, bool behind_picture, Random& random,
              SurfaceSamples& samples) {
  ParametricSurface wall;
  wall.position_m = position_m;
  wall.u_min = -kRoomHalf_m + 0.002;
  wall.u_max = kRoomHalf_m - 0.012;
  wall.v_min = kSkirtingHeight_m - 0.02;
  wall.v_max = kWallHeight_m - 0.012;
  wall.spacing_m = 0.040;
  wall.part = kWall;
  wall.cells_u = wall.cells_v = 160;
  if (behind_picture) wall.keep = [](const Vector3d& p) { return picture_depth_m(p) < 0.012; };
  wall.refinement = [position_m, behind_picture](double u, double v) {
    const double frame_m = behind_picture ? std::abs(picture_depth_m(position_m(u, v))) : 1.0;
    const double edge_m =
        std::min({frame_m, kRoomHalf_m - std::abs(u), kWallHeight_m - v, v - kSkirtingHeight_m + 0.05});
    return 0.32 + 0.68 * smooth_step(0.02, 0.12, edge_m);
  };
  sample_surface(wall, random, samples);
}

}  // namespace

GaussianAsset make_room_corner(uint64_t seed) {
  Random random(seed * 8 + 7);
  SurfaceSamples samples;
  lay_parquet(random, samples);
  lay_wall([](double u, double v) { return Vector3d(u, v, -kRoomHalf_m); }, true, random, samples);
  lay_wall([](double u, double v) { return Vector3d(-kRoomHalf_m, v, -u); }, false, random, samples);
  lay_skirting(random, samples);
  lay_picture(random, samples);
  BakeOptions options;
  options.sh_degree = 1;
  options.contact_height_m = 0.05;
  options.exposure = 1.0;
  options.occlusion_cells = 0;
  return bake_kernels(samples, Decor(seed * 613), options, random);
}

}  // namespace livegs
