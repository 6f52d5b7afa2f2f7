// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample/tools/surface_sampler.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sample/tools/poisson_disk.h"

namespace livegs::sample {
namespace {

// Random sequential packing saturates at 0.70 discs per spacing². The later darts per disc only fill holes.
constexpr double kSaturation = 0.70;
constexpr double kDartsPerDisc = 6.5;
constexpr double kFillStartShare = 0.55;  // fraction of the darts after which holes are filled
constexpr double kGolden = 0.6180339887498949;
constexpr double kMaxTurn_rad = 0.35;  // maximum rotation of the normal within one spacing

struct Cell {
  double u, v, spacing_m, cumulative;
};

struct Frame {
  Eigen::Vector3d normal, tangent;
};

Frame frame_at(const ParametricSurface& surface, double u, double v) {
  const double du = (surface.u_max - surface.u_min) * 1.5e-3, dv = (surface.v_max - surface.v_min) * 1.5e-3;
  const double u0 = std::max(surface.u_min, u - du), u1 = std::min(surface.u_max, u + du);
  const double v0 = std::max(surface.v_min, v - dv), v1 = std::min(surface.v_max, v + dv);
  Eigen::Vector3d along = surface.position_m(u1, v) - surface.position_m(u0, v);
  const Eigen::Vector3d across = surface.position_m(u, v1) - surface.position_m(u, v0);
  Eigen::Vector3d normal = along.cross(across);
  if (normal.norm() < 1e-18) normal = Eigen::Vector3d::UnitY();
  normal.normalize();
  along -= normal * normal.dot(along);
  if (along.norm() < 1e-15) along = normal.unitOrthogonal();
  return {normal, along.normalized()};
}

}  // namespace

void sample_surface(const ParametricSurface& surface, Random& random, SurfaceSamples& samples) {
  const int nu = surface.cells_u, nv = surface.cells_v;
  const double du = (surface.u_max - surface.u_min) / nu, dv = (surface.v_max - surface.v_min) / nv;
  std::vector<Eigen::Vector3d> corners(static_cast<size_t>((nu + 1) * (nv + 1)));
  for (int j = 0; j <= nv; ++j)
    for (int i = 0; i <= nu; ++i)
      corners[j * (nu + 1) + i] = surface.position_m(surface.u_min + i * du, surface.v_min + j * dv);
  const auto corner = [&](int i, int j) -> const Eigen::Vector3d& { return corners[j * (nu + 1) + i]; };

  // Cell normals, then the largest rotation per metre towards the next cell in either direction.
  std::vector<Eigen::Vector3d> normals(static_cast<size_t>(nu) * nv);
  std::vector<double> areas(normals.size());
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i) {
      const Eigen::Vector3d cross =
          (corner(i + 1, j + 1) - corner(i, j)).cross(corner(i, j + 1) - corner(i + 1, j));
      areas[j * nu + i] = 0.5 * cross.norm();
      normals[j * nu + i] = cross.norm() > 1e-18 ? cross.normalized() : Eigen::Vector3d::Zero();
    }
  const auto centre = [&](int i, int j) {
    return Eigen::Vector3d(0.25 *
                           (corner(i, j) + corner(i + 1, j) + corner(i, j + 1) + corner(i + 1, j + 1)));
  };
  std::vector<Cell> cells;
  cells.reserve(normals.size());
  double total = 0.0, largest_m = 0.0;
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i) {
      double curvature = 0.0;
      for (const auto& [di, dj] : {std::pair{1, 0}, {0, 1}, {-1, 0}, {0, -1}}) {
        const int ni = i + di, nj = j + dj;
        if (ni < 0 || nj < 0 || ni >= nu || nj >= nv) continue;
        const double step_m = (centre(ni, nj) - centre(i, j)).norm();
        if (step_m < 1e-9 || areas[nj * nu + ni] < 1e-14) continue;
        curvature = std::max(curvature, (normals[nj * nu + ni] - normals[j * nu + i]).norm() / step_m);
      }
      double spacing_m = surface.spacing_m;
      const double u = surface.u_min + (i + 0.5) * du, v = surface.v_min + (j + 0.5) * dv;
      if (surface.refinement) spacing_m *= surface.refinement(u, v);
      if (curvature * spacing_m > kMaxTurn_rad)
        spacing_m = std::max(spacing_m / 3.0, kMaxTurn_rad / curvature);
      total += areas[j * nu + i] * kSaturation * kDartsPerDisc / (spacing_m * spacing_m * surface.stretch);
      largest_m = std::max(largest_m, spacing_m);
      cells.push_back({u - 0.5 * du, v - 0.5 * dv, spacing_m, total});
    }

  // Darts in a low-discrepancy order over the area, so that all parts of the surface fill at the same rate.
  const size_t dart_count = static_cast<size_t>(total) + 1;
  PoissonDisk board(largest_m, dart_count / 6);
  double phase = random.uniform();
  for (size_t dart = 0; dart < dart_count; ++dart) {
    phase += kGolden;
    if (phase >= 1.0) phase -= 1.0;
    const auto cell = std::lower_bound(cells.begin(), cells.end(), phase * total,
                                       [](const Cell& c, double value) { return c.cumulative < value; });
    if (cell == cells.end()) continue;
    const double u = cell->u + du * random.uniform(), v = cell->v + dv * random.uniform();
    const Eigen::Vector3d position_m = surface.position_m(u, v);
    if (surface.keep && !surface.keep(position_m)) continue;
    const Eigen::Vector3d metric = surface.metric ? surface.metric(u, v, position_m) : position_m;
    const Eigen::Vector3d& side = normals[static_cast<size_t>(cell - cells.begin())];
    const bool filling = static_cast<double>(dart) > kFillStartShare * static_cast<double>(dart_count);
    if (!(filling ? board.fill(metric, side, cell->spacing_m) : board.take(metric, side, cell->spacing_m)))
      continue;
    const Frame frame = frame_at(surface, u, v);
    samples.push_back(
        {position_m, frame.normal, frame.tangent, u, v, cell->spacing_m, surface.stretch, surface.part});
  }
}

void sample_implicit(const ImplicitSurface& surface, Random& random, SurfaceSamples& samples) {
  constexpr int kCells = 64;  // along the longest side
  const Eigen::Vector3d size = surface.max_m - surface.min_m;
  const double width_m = size.maxCoeff() / kCells;
  // Darts start in a shell around the surface and are projected onto it along the gradient. A cell crossed by
  // the shell has its centre within the shell's width plus half a diagonal (0.87 widths) of the surface.
  const double shell_m = 1.5 * surface.spacing_m;
  std::vector<Eigen::Vector3d> corners;  // corners of those cells
  for (int k = 0; k * width_m < size.z(); ++k)
    for (int j = 0; j * width_m < size.y(); ++j)
      for (int i = 0; i * width_m < size.x(); ++i) {
        const Eigen::Vector3d low = surface.min_m + width_m * Eigen::Vector3d(i, j, k);
        const Eigen::Vector3d centre = low + Eigen::Vector3d::Constant(0.5 * width_m);
        if (std::abs(surface.distance_m(centre)) < shell_m + 0.95 * width_m) corners.push_back(low);
      }
  // Tetrahedral finite differences: four evaluations.
  const auto gradient = [&](const Eigen::Vector3d& p) {
    constexpr double kStep_m = 2e-5;
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (int corner = 0; corner < 4; ++corner) {
      const Eigen::Vector3d k(corner == 1 || corner == 3 ? 1 : -1, corner >= 2 ? 1 : -1,
                              corner == 0 || corner == 3 ? 1 : -1);
      g += k * surface.distance_m(p + kStep_m * k);
    }
    return Eigen::Vector3d(g / (4 * kStep_m));
  };
  const double dart_area_m2 = surface.spacing_m * surface.spacing_m / (kSaturation * kDartsPerDisc);
  const double dart_volume_m3 = dart_area_m2 * 2 * shell_m * (surface.refinement ? 0.65 : 1.0);
  const size_t dart_count =
      static_cast<size_t>(static_cast<double>(corners.size()) * width_m * width_m * width_m / dart_volume_m3);
  PoissonDisk board(surface.spacing_m, dart_count / 16);
  double phase = random.uniform();
  for (size_t dart = 0; dart < dart_count; ++dart) {
    phase += kGolden;
    if (phase >= 1.0) phase -= 1.0;
    const Eigen::Vector3d& low = corners[static_cast<size_t>(phase * static_cast<double>(corners.size()))];
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    Eigen::Vector3d point = low + width_m * Eigen::Vector3d(x, y, z);
    double distance_m = surface.distance_m(point);
    if (std::abs(distance_m) > shell_m) continue;
    const Eigen::Vector3d downhill = gradient(point);
    if (downhill.squaredNorm() < 0.05) continue;
    for (int step = 0; step < 3 && std::abs(distance_m) > 0.01 * surface.spacing_m; ++step) {
      point -= downhill * (distance_m / downhill.squaredNorm());
      distance_m = surface.distance_m(point);
    }
    if (std::abs(distance_m) > 0.05 * surface.spacing_m) continue;
    const double spacing_m = surface.spacing_m * (surface.refinement ? surface.refinement(point) : 1.0);
    const Eigen::Vector3d side = downhill.normalized();
    const bool filling = static_cast<double>(dart) > kFillStartShare * static_cast<double>(dart_count);
    if (!(filling ? board.fill(point, side, spacing_m) : board.take(point, side, spacing_m))) continue;
    const Eigen::Vector3d normal = gradient(point).normalized();
    samples.push_back({point, normal, normal.unitOrthogonal(), 0.0, 0.0, spacing_m, 1.0, 0});
  }
}

}  // namespace livegs::sample
