// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "study/stability/stability_run.h"

// Scenes in which solvers fail: fast spin, shock, thin and overstretched bodies, deep overlaps, mass ratios.
// Each figure has a bar from a closed form or a conservation law.

namespace livegs::study {

struct StabilityScene {
  std::string name;
  std::string what;                                    // bodies and figures, for the page
  bool elastic, rigid;                                 // has such bodies
  std::vector<Measurement> (*run)(StabilityRun& run);  // empty: a body was refused
};

std::span<const StabilityScene> stability_scenes();

// Sampled cubes, cylinders and capsules of 10 kPa and 1 MPa, and a block of rubber, fall tilted from 0.3 m.
// `gain`: of energy over the start. `awake`: mean time until they sleep, at most 12 s.
std::vector<Measurement> soft_landing(StabilityRun& run);
// Sheets of 0.3 m and 2 mm, 1 and 10 kPa, nu 0.3 and 0.49, spin at 30 rad/s for 4 s without gravity. `gain`:
// of energy. `momentum`: relative drift of the angular momentum.
std::vector<Measurement> limp_spin(StabilityRun& run);
// A soft cube hits another without gravity. `linear` and `angular`: largest relative drift of the momentum.
std::vector<Measurement> soft_collision(StabilityRun& run);
// Couples on boxes of 1 to 6 cells. `spin`: relative error of the angular velocity.
std::vector<Measurement> couple(StabilityRun& run);
// A box spins freely for 4 s at 3 rad/s about its axis of the largest moment. `angle`: error of its
// orientation, rad. `momentum`: relative drift of the angular momentum.
std::vector<Measurement> soft_flight(StabilityRun& run);
// A ball and a cylinder roll down slopes for 1 s. `way`: relative to that of a rigid one less the rolling
// resistance of the loss factor (Johnson 1985, Contact mechanics, 4.2, 9.4).
std::vector<Measurement> soft_rolling(StabilityRun& run);

// A cube of nu 0 under its weight. `sag`: of the centre, relative to rho g H² / 3E. `awake`: until it sleeps.
std::vector<Measurement> resting_block(StabilityRun& run);
// A bar held at one end under a small load at the other. `sag`: where it sleeps, relative to a bar that may
// not sleep.
std::vector<Measurement> held_bar(StabilityRun& run);
// Boxes of 5 and 8 kg on pillows of 5 and 20 kPa. `aside`: distance from the start. `awake`: until both
// sleep.
std::vector<Measurement> loaded_pillow(StabilityRun& run);
// Twelve soft boxes fall into a bin. `awake`: bodies awake after 5 s. `sink`: particles below the floor.
std::vector<Measurement> soft_heap(StabilityRun& run);
// A block falls on a shelf of 4 mm. `passed`: share of its particles below the shelf.
std::vector<Measurement> thin_shelf(StabilityRun& run);

// 100 N pull at the end of a thin strip of 100 kPa. `energy`: relative to the strain energy at a stretch of
// 4. `length`: of the strip, relative to the stretch of 4.
std::vector<Measurement> overstretched_strip(StabilityRun& run);
// Blocks start scrambled. `shape`: largest distance from the rest shape after 2 s, of thin blocks 4 s,
// relative to the size.
std::vector<Measurement> scrambled_block(StabilityRun& run);
// Blocks start scrambled around a bar. `energy`: mean elastic energy after 3 s, relative to 1.5 J.
std::vector<Measurement> impaled_block(StabilityRun& run);
// A plastic plant of a pot, a stem and leaves is jerked and released. `gain`: of energy. `flow`: largest
// energy that plastic flow returned, relative to the energy at the release.
std::vector<Measurement> jerked_plant(StabilityRun& run);
// A soft ball in a haze of nearly weightless particles falls. `gain`: of energy. `apart`: largest distance
// of a particle from the centre, relative to that at rest.
std::vector<Measurement> haze(StabilityRun& run);

// Cards, rods and facetted balls fly against thin plates at 15 to 100 m/s. `passed`: share that passed.
// `sink`: of balls into a fixed plate.
std::vector<Measurement> fast_plate(StabilityRun& run);
// Two bodies at the same place, boxes, balls and notched ones, without gravity. `apart`: share of pairs that
// do not separate within 3 s. `speed`: the highest, m/s.
std::vector<Measurement> coincident_bodies(StabilityRun& run);
// A cup falls from 4 m and breaks into 64. `weight`: largest sum of contact impulses of the heap, relative to
// its weight: once for the floor and twice for each pair of fragments.
std::vector<Measurement> fragment_heap(StabilityRun& run);
// A level chain with a heavy end is released and snaps tight. `stretch`: relative. `gain`: of energy,
// relative to the fall of the weight.
std::vector<Measurement> snapping_chain(StabilityRun& run);
// A cube on another, 1000 times as heavy and 0.1 m wide. `sink`: relative to a cube.
std::vector<Measurement> heavy_on_light_box(StabilityRun& run);
// Books under a heavy box. `sink`: relative to the pile.
std::vector<Measurement> pile_of_books(StabilityRun& run);

}  // namespace livegs::study
