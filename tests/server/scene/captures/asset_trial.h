// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <vector>
#include "rates.h"

// A captured asset as rigid, as elastic and as fragile, dropped, thrown, pulled and stacked on a floor: what
// became of it.

namespace livegs::testing {

enum class TrialBody { Rigid, Elastic, Fragile };
enum class TrialAction { Dropped, Thrown, Pulled, Stacked };
const char* name_of(TrialBody body);
const char* name_of(TrialAction action);

struct AssetTrial {
  std::string asset;
  TrialBody body = TrialBody::Rigid;
  TrialAction action = TrialAction::Dropped;
  std::string error;  // it could not be loaded, and why; nothing below is filled
  double rate_hz = 90;
  double seconds = 0;          // simulated
  size_t bodies = 0;           // rigid ones at the end, or 1
  size_t pieces = 0;           // that a fragile one was cut into; of three the fewest
  bool broke = false;          // any of them
  double size_m = 0;           // longest side
  bool finite = true;          // every driver at every tick
  double lowest_m = 0;         // of points of the captured surface above the floor, ever, by size_m
  double lowest_centre_m = 0;  // of centres of mass, by size_m
  double energy_ratio = 0;     // the most there was of it, over what it started with and the hand's work
  double let_go_ratio =
      0;  // pulled: the most there was of it after the hand let go, over what there was then
  double end_speed_m_s = 0;  // of the fastest body, or of an elastic one's centre
  bool asleep = false;       // all of it
  double tick_p99_ms = 0;    // processor time
};

// Runs one. `path` is an asset file. Deterministic but for times.
AssetTrial run_asset_trial(const std::string& path, TrialBody body, TrialAction action, double seconds,
                           double rate_hz = 90.0);

std::string csv_header();
std::string csv_row(const AssetTrial& trial);

// Bars every trial is held to. Reported by gtest.
void expect_nothing_exploded(const AssetTrial& trial);

}  // namespace livegs::testing
