// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <openxr/openxr.h>

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace livegs::simulated {

// What an eye was given.
struct EyeRecord {
  XrPosef pose;  // in the stage
  XrFovf fov;
  uint64_t hash = 0;
  int width = 0, height = 0;
  std::vector<uint8_t> rgba;
};

// Writes what happened into the folder LIVEGS_XR_OUTPUT, if it is set: frames.csv, a row a submitted frame; haptics.csv;
// states.csv; misuse.txt, a line a call that breaks the rules (standard error, too); frame_NNNNN_E.png of frames that are kept.
// What is in the files already stays.
class Record {
 public:
  Record();
  ~Record();
  void frame(uint64_t index, double time_s, double ended_s, double displayed_s, const std::vector<EyeRecord>& eyes, bool keep);
  void haptic(double time_s, const std::string& hand, const XrHapticVibration& vibration);
  void state(double time_s, const std::string& state);
  void misuse(const std::string& what);

 private:
  std::FILE* open(const char* name, const char* header) const;
  std::string folder_;
  std::FILE *frames_ = nullptr, *haptics_ = nullptr, *states_ = nullptr, *misuse_ = nullptr;
};

}  // namespace livegs::simulated
