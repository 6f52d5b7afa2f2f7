// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample/tools/baked_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/parallel_for.h"
#include "sample/tools/colour.h"
#include "sample/tools/lobe_to_sh.h"
#include "sample/tools/noise.h"

namespace livegs::sample {
namespace {

using Eigen::Vector3d;

constexpr int kKeyDirections = 10;
constexpr int kDirectionSets = 16;

const Vector3d kKeyColour(0.92, 0.85, 0.76);
const Vector3d kSkyColour(0.62, 0.65, 0.70);  // straight up
const Vector3d kHorizonColour(0.50, 0.49, 0.47);
const Vector3d kFloorColour(0.25, 0.22, 0.19);  // light reflected by the floor, away from the object

struct Directions {
  std::vector<Vector3d> sky;
  std::array<Vector3d, kKeyDirections> key;
};

// A Fibonacci sphere for the sky, and a small disc around the key direction for the window. The sets are
// rotated relative to each other, which turns the steps of single directions into fine grain.
Directions make_directions(int set, int sky_count) {
  Directions d;
  const double turn = 2 * std::numbers::pi * set / kDirectionSets;
  for (int i = 0; i < sky_count; ++i) {
    const double y = 1 - (2 * i + 1.0) / sky_count, r = std::sqrt(1 - y * y),
                 a = 2.399963229728653 * i + turn;
    d.sky.emplace_back(r * std::cos(a), y, r * std::sin(a));
  }
  const Vector3d key = key_direction(), side = key.unitOrthogonal(), other = key.cross(side);
  for (int i = 0; i < kKeyDirections; ++i) {
    const double r = 0.24 * std::sqrt((i + 0.5) / kKeyDirections), a = 2.399963229728653 * i + turn;
    d.key[i] = (key + r * std::cos(a) * side + r * std::sin(a) * other).normalized();
  }
  return d;
}

// Irradiance divided by pi on one side of a surface.
struct Light {
  Vector3d diffuse;
  double key_visibility;
  double sky_visibility;
};

class Illumination {
 public:
  Illumination(const SurfaceSamples& samples, const BakeOptions& options) : options_(options) {
    for (int set = 0; set < kDirectionSets; ++set)
      directions_[set] = make_directions(set, options.sky_directions);
    if (options.occlusion_cells > 0) grid_.emplace(samples, options.occlusion_cells);
  }

  Light at(const Vector3d& point_m, const Vector3d& face, const Vector3d& normal, size_t set) const {
    const Directions& directions = directions_[set % kDirectionSets];
    Light light{Vector3d::Zero(), 0.0, 0.0};
    double weights = 0.0;
    // Minimum light from below, because these objects can be turned over and a black underside would look
    // like a hole.
    constexpr double kMinFloorLight = 0.45;
    const double contact =
        kMinFloorLight +
        (1 - kMinFloorLight) * (1 - std::exp(-std::max(0.0, point_m.y()) / options_.contact_height_m));
    for (const Vector3d& d : directions.sky) {
      const double cosine = normal.dot(d);
      if (cosine <= 0.02 || face.dot(d) <= 0.0) continue;
      const double visible = seen(point_m, face, d);
      const Vector3d from =
          d.y() >= 0 ? blend(kHorizonColour, kSkyColour, d.y()) : Vector3d(kFloorColour * contact);
      light.diffuse += cosine * visible * from;
      light.sky_visibility += cosine * visible;
      weights += cosine;
    }
    // A tenth of the blocked light returns after bounces inside the object.
    if (weights > 0) {
      light.sky_visibility /= weights;
      light.diffuse = light.diffuse / weights + (1 - light.sky_visibility) * Vector3d(0.10, 0.09, 0.08);
    }
    double key = 0.0;
    for (const Vector3d& d : directions.key)
      if (face.dot(d) > -0.05) key += seen(point_m, face, d) / kKeyDirections;
    light.key_visibility = key;
    // A window is wide, so its light extends slightly past the terminator.
    const double wrapped = std::max(0.0, (normal.dot(key_direction()) + 0.15) / 1.15);
    light.diffuse += kKeyColour * key * wrapped;
    return light;
  }

 private:
  double seen(const Vector3d& point_m, const Vector3d& face, const Vector3d& direction) const {
    return grid_ ? grid_->transmittance(point_m, face, direction) : 1.0;
  }

  std::optional<OcclusionGrid> grid_;
  BakeOptions options_;
  std::array<Directions, kDirectionSets> directions_;
};

// A rotation by 180 degrees about x: y up to -Y up, z towards the viewer to z forward.
Vector3d asset_from_model(const Vector3d& v) { return {v.x(), -v.y(), -v.z()}; }

Vector3d reflect(const Vector3d& towards, const Vector3d& normal) {
  return 2 * normal.dot(towards) * normal - towards;
}

// Highlights by width, projected once; widths are rounded to steps of 0.05.
class LobeTable {
 public:
  explicit LobeTable(int degree) {
    for (size_t i = 0; i < lobes_.size(); ++i) {
      const double width = 0.05 * (static_cast<double>(i) + 1);
      lobes_[i] = project_lobe([&](double c) { return std::exp((c - 1) / (width * width)); }, degree);
    }
    grazing_ = project_zonal([](double c) { return std::pow(1 - std::abs(c), 3.0); }, degree);
    facing_ = ZonalLobe{};
    facing_.strength[1] = 4 * std::numbers::pi / 3;  // the cosine itself
  }
  const ZonalLobe& lobe(double width) const {
    return lobes_[std::clamp<size_t>(static_cast<size_t>(width / 0.05 - 0.5), 0, lobes_.size() - 1)];
  }
  const ZonalLobe& grazing() const { return grazing_; }
  const ZonalLobe& facing() const { return facing_; }

 private:
  std::array<ZonalLobe, 20> lobes_;
  ZonalLobe grazing_, facing_;
};

}  // namespace

Vector3d key_direction() { return Vector3d(0.55, 0.72, 0.52).normalized(); }

GaussianAsset bake_kernels(const SurfaceSamples& samples, const Material& material,
                           const BakeOptions& options, Random& random) {
  const Illumination illumination(samples, options);
  const LobeTable lobes(options.sh_degree);
  GaussianAsset asset;
  asset.sh_degree = options.sh_degree;
  asset.resize(samples.size());
  const size_t rest_count = asset.sh_rest_count();
  // The window is tall, so upright surfaces reflect its lower half. The bright room opposite is dimmer.
  const Vector3d window_direction = Vector3d(0.62, 0.24, 0.72).normalized();
  const Vector3d fill_direction = Vector3d(-0.7, 0.45, 0.55).normalized();
  std::vector<std::array<double, 2>> jitter(samples.size());  // of size and opacity, drawn in order
  for (auto& j : jitter) j = {random.uniform(-1, 1), random.uniform(-1, 1)};
  const auto bake_one = [&](size_t i, std::vector<Vector3d>& rest) {
    const SurfaceSample& s = samples[i];
    const Appearance a = material(s);
    const Vector3d normal = (s.normal + a.bump).normalized();
    const Light front = illumination.at(s.position_m, s.normal, normal, i);
    Vector3d front_radiance = options.exposure * front.diffuse.cwiseProduct(a.albedo);
    front_radiance +=
        a.subsurface * (0.4 + 0.6 * front.sky_visibility) * (1 - std::min(1.0, front.diffuse.mean()));

    Vector3d dc = Vector3d::Zero();
    std::fill(rest.begin(), rest.end(), Vector3d::Zero());
    Vector3d display;
    if (a.two_sided) {
      const Light back = illumination.at(s.position_m, -s.normal, -normal, i);
      const Vector3d leaf_light(0.75, 1.0, 0.25);  // light transmitted by a leaf is yellow-green
      Vector3d back_radiance = options.exposure * back.diffuse.cwiseProduct(a.back_albedo);
      const Vector3d through_front =
          a.translucency * back.diffuse.cwiseProduct(a.albedo).cwiseProduct(leaf_light);
      const Vector3d through_back =
          a.translucency * front.diffuse.cwiseProduct(a.albedo).cwiseProduct(leaf_light);
      const Vector3d front_display = display_from_radiance(front_radiance + through_front);
      const Vector3d back_display = display_from_radiance(back_radiance + through_back);
      display = 0.5 * (front_display + back_display);
      add_lobe(lobes.facing(), asset_from_model(-s.normal), 0.5 * (front_display - back_display), dc, rest);
    } else {
      display = display_from_radiance(front_radiance);
    }
    dc += (display - Vector3d::Constant(0.5)) / 0.28209479177387814;

    if (a.gloss > 0) {
      const double toward = normal.dot(key_direction());
      const double key = front.key_visibility * smooth_step(-0.05, 0.25, toward);
      const ZonalLobe& lobe = lobes.lobe(a.gloss_width);
      if (key > 0.01)
        add_lobe(lobe, asset_from_model(-reflect(key_direction(), normal)),
                 a.gloss * key * Vector3d(1, 0.98, 0.94), dc, rest);
      const double window =
          smooth_step(-0.05, 0.3, normal.dot(window_direction)) * (0.3 + 0.7 * front.key_visibility);
      if (window > 0.01)
        add_lobe(lobe, asset_from_model(-reflect(window_direction, normal)),
                 0.75 * a.gloss * window * Vector3d(1, 0.99, 0.96), dc, rest);
      const double fill = smooth_step(-0.05, 0.4, normal.dot(fill_direction)) * front.sky_visibility;
      if (fill > 0.01)
        add_lobe(lobe, asset_from_model(-reflect(fill_direction, normal)),
                 0.3 * a.gloss * fill * Vector3d(0.9, 0.95, 1), dc, rest);
    }
    if (a.sheen > 0)
      add_lobe(lobes.grazing(), asset_from_model(-s.normal),
               a.sheen * front.sky_visibility * Vector3d::Ones(), dc, rest);

    asset.positions[i] = asset_from_model(s.position_m).cast<float>();
    Eigen::Matrix3d axes;
    axes.col(0) = asset_from_model(a.across ? Vector3d(s.normal.cross(s.tangent)) : s.tangent);
    axes.col(2) = asset_from_model(s.normal);
    axes.col(1) = axes.col(2).cross(axes.col(0));
    asset.rotations[i] = Eigen::Quaterniond(axes).normalized().cast<float>();
    asset.rotations[i].normalize();
    const double size_m = a.overlap * s.spacing_m * (1 + 0.06 * jitter[i][0]);
    const double along_m = size_m * s.stretch * std::sqrt(a.elongation),
                 across_m = size_m / std::sqrt(a.elongation);
    asset.log_scales[i] =
        Vector3d(std::log(along_m), std::log(across_m), std::log(a.flatness * across_m)).cast<float>();
    const double opacity = std::clamp(a.opacity + 0.02 * jitter[i][1], 0.05, 0.99);
    asset.opacity_logits[i] = static_cast<float>(std::log(opacity / (1 - opacity)));
    asset.sh_dc[i] = dc.cast<float>();
    for (size_t k = 0; k < rest_count; ++k) asset.sh_rest[i * rest_count + k] = rest[k].cast<float>();
  };
  parallel_for(samples.size(), 1024, [&](size_t begin, size_t end) {
    std::vector<Vector3d> rest(rest_count);
    for (size_t i = begin; i < end; ++i) bake_one(i, rest);
  });
  return asset;
}

}  // namespace livegs::sample
