// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <openxr/openxr.h>

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace livegs::simulated {

// Eye positions that xrLocateViews predicted for one display time: the first and the last answer, and how
// long before display each was given.
struct EyePrediction {
  double first_lead_s = 0, last_lead_s = 0;
  XrVector3f first{}, last{};  // in stage space
  int answers = 0;
};

// The submitted view of one eye.
struct EyeRecord {
  XrPosef pose;  // in stage space
  XrFovf fov;
  uint64_t hash = 0;
  int width = 0, height = 0;
  std::vector<uint8_t> rgba;
  EyePrediction prediction;
};

// Appends events to files in the folder LIVEGS_XR_OUTPUT, if it is set:
//   frames.csv      one row per submitted frame
//   views.csv       one row per eye of a submitted frame
//   haptics.csv, states.csv, profiles.csv
//   handles.csv     for each destroyed session or instance, the number of handles created and not destroyed
//   misuse.txt      one line per call that violates the specification; also written to standard error
//   frame_NNNNN_E.png  frames that are kept
class Record {
 public:
  Record();
  ~Record();
  void frame(uint64_t index, double time_s, double ended_s, double displayed_s,
             const std::vector<EyeRecord>& eyes, bool keep);
  void haptic(double time_s, const std::string& hand, const XrHapticVibration& vibration);
  void state(double time_s, const std::string& state);
  void profile(double time_s, const std::string& profile);
  // destroyed: "session" or "instance". left: number of child handles that were destroyed with it.
  void handles(const char* destroyed, const char* kind, size_t made, size_t left);
  void misuse(const std::string& what);

 private:
  std::FILE* open(const char* name, const char* header) const;
  std::string folder_;
  std::FILE *frames_ = nullptr, *haptics_ = nullptr, *states_ = nullptr, *profiles_ = nullptr,
            *views_ = nullptr, *handles_ = nullptr, *misuse_ = nullptr;
};

}  // namespace livegs::simulated
