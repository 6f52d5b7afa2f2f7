// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <vector>
#include "rates.h"

// Simulates a captured asset as rigid, elastic and fragile: dropped, thrown, pulled and stacked on a floor.

namespace livegs::testing {

enum class TrialBody { Rigid, Elastic, Fragile };
enum class TrialAction { Dropped, Thrown, Pulled, Stacked };
const char* name_of(TrialBody body);
const char* name_of(TrialAction action);

struct AssetTrial {
  std::string asset;
  TrialBody body = TrialBody::Rigid;
  TrialAction action = TrialAction::Dropped;
  std::string error;  // why the asset could not be loaded; other fields are then not set
  double rate_hz = 90;
  double seconds = 0;          // simulated time
  size_t bodies = 0;           // rigid bodies at the end, or 1
  size_t pieces = 0;           // number of pieces of a fragile asset; minimum over the objects
  bool broke = false;          // at least one object broke
  double size_m = 0;           // longest side
  bool finite = true;          // all drivers at all ticks
  double lowest_m = 0;         // minimum height of the captured surface above the floor, relative to size_m
  double lowest_centre_m = 0;  // minimum height of the centres of mass, relative to size_m
  double energy_ratio = 0;     // maximum energy relative to the initial energy plus the work of the hand
  double let_go_ratio = 0;   // pulled: maximum energy after the release relative to the energy at the release
  double end_speed_m_s = 0;  // of the fastest body, or the centre of an elastic one
  bool asleep = false;       // all bodies sleep
  double tick_p99_ms = 0;    // processor time, milliseconds
};

// Runs one trial. `path` is an asset file. Deterministic except for times.
AssetTrial run_asset_trial(const std::string& path, TrialBody body, TrialAction action, double seconds,
                           double rate_hz = 90.0);

std::string csv_header();
std::string csv_row(const AssetTrial& trial);

// Compares a trial with the bars of all trials. Reported by gtest.
void expect_nothing_exploded(const AssetTrial& trial);

}  // namespace livegs::testing
