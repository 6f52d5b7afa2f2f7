// SPDX-License-Identifier: Apache-2.0
// Cost of the `cells` solver by size, on one core. Prints CSV: `elastic_bench >
// results/<machine>/elastic.csv`.
// A block of cells drops by 5 mm onto a floor and rests there with sleep disabled, so that contact and the
// momentum ledger are included. After 30 warm-up frames (300 for `settled`), windows of 2 ms or of one frame
// are timed for one second; the minimum is reported, because the machine is shared. Settled blocks are
// strained by their own weight, the larger ones by more than half, so they use first-order steps and the
// energy limiter.
// `peak` is the speed of the machine in the same run: eight-lane fused multiply-adds per second on one core,
// measured before and after each row. `peaks_per_node_substep` is the cost in units of these, which is
// comparable between machines.
// --table: contact with a rigid body in comparison with the floor.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>

#include "geometry/surface/shape_mesh.h"
#include "physics/elastic_body.h"
#include "server/physics/elastic/quarter_shell.h"
#include "study/peers/bullet_body.h"

using namespace livegs;
using namespace livegs::test;

namespace {

// Eight-lane multiply-adds per second, best of ten.
double peak_per_s() {
  typedef float Lanes8 __attribute__((vector_size(32)));
  Lanes8 chain[10];
  for (int i = 0; i < 10; ++i) chain[i] = Lanes8{} + (1.0f + 1e-3f * static_cast<float>(i));
  double best_s = 1e300;
  for (int part = 0; part < 10; ++part) {
    const auto start = std::chrono::steady_clock::now();
    for (int k = 0; k < 200000; ++k) {
      for (Lanes8& value : chain) value = value * 0.999999f + 1e-7f;
    }
    asm volatile("" : : "m"(chain) : "memory");
    best_s =
        std::min(best_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return 2e6 / best_s;
}

double seconds_of(Stage& stage, int frames) {
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < frames; ++i) stage.frame();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

enum class By { Cells, Bullet };

// Bounds: time per node and substep at 3000 nodes with contact, time per frame of an object of the paper's
// size, and memory per node.
constexpr double kGoal_ns = 20.0, kGoal_bytes = 300.0;
constexpr const char* kGoal_ms = "0.25";
constexpr int kMaxSettledCells =
    36;  // cells along an edge; the largest has 1.1 times its modulus of weight on it

// Returns the cost of a frame, ms. `table` replaces the floor.
double report(const char* name, const ElasticBodyDescription& description, bool floor, By by = By::Cells,
              RigidProxy* table = nullptr, int warm_up_frames = 30) {
  Stage stage;
  stage.rate_hz = 90.0;
  if (floor) {
    stage.gravity_m_s2 = kGravity;
    if (table) {
      stage.bodies = {table};
    } else {
      stage.add_floor();
    }
  }
  auto made = by == By::Bullet ? study::make_bullet_body(description, stage.rate_hz, stage.substeps)
                               : make_elastic_body(description, stage.rate_hz, stage.substeps, false);
  if (!made) {
    std::fprintf(stderr, "%s: %s\n", name, made.error().message.c_str());
    return 0.0;
  }
  stage.body = std::move(*made);
  const ElasticAccuracy accuracy = stage.body->accuracy();
  seconds_of(stage, warm_up_frames);
  const double work = static_cast<double>(accuracy.nodes) * accuracy.substeps;
  const double once_s = seconds_of(stage, 4) / 4;
  const int frames = std::clamp(static_cast<int>(2e-3 / once_s), 1, 100);
  const int windows = std::clamp(static_cast<int>(1.0 / (once_s * frames)), 5, 500);
  double best_s = 1e300, peak = peak_per_s();
  for (int part = 0; part < windows; ++part) best_s = std::min(best_s, seconds_of(stage, frames) / frames);
  peak = std::max(peak, peak_per_s());
  std::printf("%s,%zu,%zu,%zu,%d,%.3f,%.4f,%.2f,%.0f,%.2f,%.0f,%g,%s,%g\n", name, accuracy.nodes,
              accuracy.cells, accuracy.particles, accuracy.substeps, accuracy.courant, 1e3 * best_s,
              1e9 * best_s / work, static_cast<double>(accuracy.bytes) / static_cast<double>(accuracy.nodes),
              1e-9 * peak, best_s / work * peak, kGoal_ns,
              std::string(name).starts_with("paper") ? kGoal_ms : "", kGoal_bytes);
  std::fflush(stdout);
  return 1e3 * best_s;
}

ElasticBodyDescription block(int cells, double cell_m, double youngs_modulus_pa) {
  ElasticBodyDescription description =
      describe(particle_grid(Vector3d::Constant(cells * cell_m), cell_m), youngs_modulus_pa, 0.3, cell_m);
  description.material.loss_factor = 0.1;
  description.world_from_object.position_m.y() = 0.5 * cells * cell_m + 0.005;
  return description;
}

// The same block on a nearly immovable rigid table of its width and on the static floor: the additional cost
// of contact with a moving body.
void report_table(int cells) {
  const RigidShape shape = mesh_shape(box_mesh({0.5, 0.1, 0.5}), Vector3d::Zero());
  RigidProxy table;
  table.body_id = 1;
  table.shape = &shape;
  table.start.position_m = table.before.position_m = {0, -0.05, 0};
  table.inverse_mass = 1e-9;
  const std::string size = "block " + std::to_string(cells) + "^3";
  const double on_floor = report((size + " on floor").c_str(), block(cells, 0.02, 1e4), true);
  const double on_table =
      report((size + " on table").c_str(), block(cells, 0.02, 1e4), true, By::Cells, &table);
  const double free = report((size + " free").c_str(), block(cells, 0.02, 1e4), false);
  std::fprintf(stderr, "%s: cost on a rigid body relative to the floor: frame %.2f, contact %.1f\n",
               size.c_str(), on_table / on_floor, (on_table - free) / std::max(1e-6, on_floor - free));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::string(argv[1]) == "--table") {
    for (const int cells : {7, 14}) report_table(cells);
    return 0;
  }
  std::printf(
      "scene,nodes,cells,particles,substeps,courant,ms_per_frame,ns_per_node_substep,bytes_per_node,peak_per_"
      "ns,"
      "peaks_per_node_substep,goal_ns,goal_ms,goal_bytes\n");
  for (const int cells : {3, 5, 7, 14, 24, 36, 58}) {
    const std::string size = "block " + std::to_string(cells) + "^3";
    report((size + " free").c_str(), block(cells, 0.02, 1e4), false);
    report((size + " on floor").c_str(), block(cells, 0.02, 1e4), true);
    if (cells <= kMaxSettledCells)
      report((size + " settled").c_str(), block(cells, 0.02, 1e4), true, By::Cells, nullptr, 300);
  }
  // The bar of the studies, 16 x 4 x 4 cells, swinging freely, and Bullet's deformable body on the same nodes
  // (bullet_body.h: five tetrahedra per cell, implicit, default solver).
  ElasticBodyDescription bar = describe_bar(1e4, 0.3, 0.025);
  bar.initial_deformation.diagonal() = Vector3d(1.02, 1, 1);
  report("bar cells", bar, false);
  report("bar bullet", bar, false, By::Bullet);
  // A curved sheet thinner than its cells, with plain cells and with thin cells (plate_cell.h).
  report("quarter shell plain", describe_quarter(5.0, 0.3, false), false);
  report("quarter shell thin", describe_quarter(5.0, 0.3, true), false);
  // LIVE-GS: at most about 15^3 particles per object. The body selects its own cells and substeps.
  for (const double youngs_modulus_pa : {1e4, 1e5, 1e6}) {
    ElasticBodyDescription object =
        describe(particle_grid(Vector3d::Constant(0.3), 0.02), youngs_modulus_pa, 0.3);
    object.material.loss_factor = 0.1;
    object.world_from_object.position_m.y() = 0.155;
    char name[64];
    std::snprintf(name, sizeof name, "paper-size object E %g", youngs_modulus_pa);
    report(name, object, true);
    std::snprintf(name, sizeof name, "paper-size object E %g settled", youngs_modulus_pa);
    report(name, object, true, By::Cells, nullptr, 300);
  }
}
