// SPDX-License-Identifier: Apache-2.0
#include "server/analysis/division/composite_objects.h"

#include <numbers>

#include "sample/rooms/solid_kernels.h"
#include "sample/tools/random.h"

namespace livegs {
namespace {

using Eigen::Vector3d;
using sample::Solid;
using sample::SolidShape;

struct PartSolid {
  Solid solid;
  uint16_t part;
  double density_kg_m3;  // mass over outer volume
  bool hidden = false;   // has mass, but is not seen
};

// Densities of materials, from handbooks.
constexpr double kSteelDensity = 7850, kAsh = 700, kPine = 500;

double solid_volume(const Solid& solid) {
  const double box = solid.size_m.prod();
  if (solid.shape == SolidShape::Cylinder) return box * std::numbers::pi / 4;
  return solid.shape == SolidShape::Ball ? box * std::numbers::pi / 6 : box;
}

CompositeObject assembled(const std::string& name, const std::vector<PartSolid>& solids, double spacing_m,
                          const Eigen::Quaterniond& lying = Eigen::Quaterniond::Identity()) {
  CompositeObject object;
  object.name = name;
  object.object_from_asset.rotation = Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX());
  sample::SolidKernels kernels;
  sample::Random random(7);
  double mass_kg = 0;
  for (size_t i = 0; i < solids.size(); ++i) {
    const auto& [solid, part, density_kg_m3, hidden] = solids[i];
    const double one_kg = density_kg_m3 * solid_volume(solid);
    mass_kg += one_kg;
    object.centre_of_mass_m += one_kg * (lying * (solid.base_m + Vector3d(0, 0.5 * solid.size_m.y(), 0)));
    if (hidden) continue;
    for (const sample::SurfacePoint& point : sample::solid_points(solid, spacing_m, 11 + i)) {
      // Points within another solid are not seen.
      bool covered = false;
      for (size_t k = 0; k < solids.size(); ++k)
        covered = covered || (k != i && !solids[k].hidden &&
                              solids[k].solid.distance_m(point.position_m) < -0.3 * spacing_m);
      if (covered) continue;
      Vector3d rgb = solid.colour_at(point, 3 + i);
      for (int c = 0; c < 3; ++c) rgb[c] += 0.03 * random.normal();
      sample::SurfacePoint placed = point;
      placed.position_m = lying * point.position_m;
      placed.normal = lying * point.normal;
      placed.tangent = lying * point.tangent;
      kernels.add(placed, rgb, part);
    }
  }
  object.centre_of_mass_m /= mass_kg;
  object.asset = std::move(kernels.asset);
  object.part = std::move(kernels.owner);
  return object;
}

Eigen::Quaterniond aslant(double tilt_rad, double yaw_rad) {
  return Eigen::AngleAxisd(yaw_rad, Vector3d::UnitY()) * Eigen::AngleAxisd(tilt_rad, Vector3d::UnitZ());
}

const Vector3d kSteel(0.45, 0.46, 0.48), kWood(0.72, 0.52, 0.3), kDarkSteel(0.22, 0.22, 0.24);

CompositeObject potted_plant() {
  std::vector<PartSolid> solids = {
      {{"pot", SolidShape::Cylinder, {0.17, 0.15, 0.17}, {0, 0, 0}, 0, {0.75, 0.4, 0.25}},
       0,
       640},  // terracotta of 1900, a third of the volume
      {{"soil", SolidShape::Cylinder, {0.145, 0.012, 0.145}, {0, 0.145, 0}, 0, {0.22, 0.15, 0.1}}, 1, 1200},
      {{"soil below", SolidShape::Cylinder, {0.145, 0.125, 0.145}, {0, 0.02, 0}, 0, {0.2, 0.1, 0.1}},
       1,
       1200,
       true}};
  sample::Random random(5);
  for (int i = 0; i < 90; ++i) {
    // Leaves around a stem; the lowest hang outside the pot below its rim.
    const double angle = random.uniform(0, 2 * std::numbers::pi), radius = random.uniform(0.02, 0.2);
    const double height = 0.42 - 6.5 * radius * radius + random.uniform(-0.06, 0.06);
    if (radius < 0.1 && height < 0.18) continue;
    solids.push_back({{"leaf",
                       SolidShape::Box,
                       {0.05, 0.006, 0.025},
                       {radius * std::sin(angle), height, radius * std::cos(angle)},
                       angle,
                       {0.2 + 0.1 * random.uniform(), 0.5 + 0.15 * random.uniform(), 0.18}},
                      2,
                      600});
  }
  solids.push_back(
      {{"stem", SolidShape::Cylinder, {0.02, 0.25, 0.02}, {0, 0.155, 0}, 0, {0.35, 0.45, 0.2}}, 2, 800});
  return assembled("potted plant", solids, 0.005);
}

}  // namespace

// Not solid: the wedge of the axe, the blade of the shovel (2 mm of its 12), the shade of the lamp (0.5
// kg/m²), its tube and its bulb, and the bristles of the broom.
std::vector<CompositeObject> composite_objects() {
  std::vector<CompositeObject> objects;
  objects.push_back(
      assembled("hammer",
                {{{"head", SolidShape::Box, {0.12, 0.035, 0.035}, {0, 0.26, 0}, 0, kSteel}, 0, kSteelDensity},
                 {{"handle", SolidShape::Cylinder, {0.03, 0.29, 0.03}, {0, 0, 0}, 0, kWood}, 1, kAsh}},
                0.004, aslant(1.1, 0.5)));
  objects.push_back(
      assembled("axe",
                {{{"head", SolidShape::Box, {0.14, 0.09, 0.025}, {0.04, 0.4, 0}, 0, kDarkSteel},
                  0,
                  0.6 * kSteelDensity},
                 {{"handle", SolidShape::Box, {0.035, 0.5, 0.022}, {0, 0, 0}, 0, kWood}, 1, kAsh}},
                0.006, aslant(0.8, -0.4)));
  objects.push_back(assembled(
      "screwdriver",
      {{{"shaft", SolidShape::Cylinder, {0.007, 0.12, 0.007}, {0, 0.1, 0}, 0, kSteel}, 0, kSteelDensity},
       {{"handle", SolidShape::Cylinder, {0.03, 0.1, 0.03}, {0, 0, 0}, 0, {0.8, 0.12, 0.1}}, 1, 1200}},
      0.002, aslant(1.57, 0.9)));
  objects.push_back(assembled(
      "shovel",
      {{{"blade", SolidShape::Box, {0.2, 0.28, 0.012}, {0, 0, 0}, 0, kDarkSteel}, 0, kSteelDensity / 6},
       {{"shaft", SolidShape::Cylinder, {0.036, 0.95, 0.036}, {0, 0.26, 0}, 0, kWood}, 1, kAsh}},
      0.008, aslant(1.3, 0.2)));
  objects.push_back(assembled(
      "lamp",
      {{{"shade", SolidShape::Cylinder, {0.26, 0.19, 0.26}, {0, 0.24, 0}, 0, {0.93, 0.88, 0.76}}, 0, 7.7},
       {{"base", SolidShape::Cylinder, {0.16, 0.025, 0.16}, {0, 0, 0}, 0, {0.3, 0.25, 0.2}}, 1, 2300},
       {{"stand", SolidShape::Cylinder, {0.022, 0.22, 0.022}, {0, 0.025, 0}, 0, {0.32, 0.27, 0.21}}, 1, 1700},
       {{"bulb", SolidShape::Ball, {0.06, 0.06, 0.06}, {0, 0.28, 0}, 0, {1, 1, 1}}, 2, 350, true}},
      0.006));
  objects.push_back(potted_plant());
  objects.push_back(
      assembled("broom",
                {{{"head", SolidShape::Box, {0.3, 0.12, 0.06}, {0, 0, 0}, 0, {0.15, 0.35, 0.75}}, 0, 130},
                 {{"shaft", SolidShape::Cylinder, {0.026, 1.1, 0.026}, {0, 0.12, 0}, 0, kWood}, 1, kPine}},
                0.008, aslant(0.3, 1.1)));
  objects.push_back(assembled(
      "kitchen knife",
      {{{"blade", SolidShape::Box, {0.042, 0.2, 0.0025}, {0, 0.12, 0}, 0, {0.72, 0.73, 0.75}},
        0,
        kSteelDensity},
       {{"handle", SolidShape::Box, {0.028, 0.12, 0.018}, {0, 0, 0}, 0, {0.16, 0.12, 0.1}}, 1, 1350}},
      0.003, aslant(1.45, -0.7)));
  return objects;
}

}  // namespace livegs
