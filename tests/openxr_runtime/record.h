// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <openxr/openxr.h>

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace livegs::simulated {

// Where xrLocateViews said that an eye would be when a frame is seen: in the first answer and in the last,
// and how long before.
struct EyeForetold {
  double first_lead_s = 0, last_lead_s = 0;
  XrVector3f first{}, last{};  // in the stage
  int answers = 0;
};

// What an eye was given.
struct EyeRecord {
  XrPosef pose;  // in the stage
  XrFovf fov;
  uint64_t hash = 0;
  int width = 0, height = 0;
  std::vector<uint8_t> rgba;
  EyeForetold foretold;
};

// Writes what happened into the folder LIVEGS_XR_OUTPUT, if it is set: frames.csv, a row a submitted frame;
// haptics.csv; states.csv; profiles.csv; views.csv, a row an eye of a submitted frame; handles.csv, what was
// made of a session or an instance that is destroyed, and what of it was never destroyed; misuse.txt, a line
// a call that breaks the rules (standard error, too); frame_NNNNN_E.png of frames that are kept. What is in
// the files already stays.
class Record {
 public:
  Record();
  ~Record();
  void frame(uint64_t index, double time_s, double ended_s, double displayed_s,
             const std::vector<EyeRecord>& eyes, bool keep);
  void haptic(double time_s, const std::string& hand, const XrHapticVibration& vibration);
  void state(double time_s, const std::string& state);
  void profile(double time_s, const std::string& profile);
  // destroyed: "session" or "instance"; left: those it took along.
  void handles(const char* destroyed, const char* kind, size_t made, size_t left);
  void misuse(const std::string& what);

 private:
  std::FILE* open(const char* name, const char* header) const;
  std::string folder_;
  std::FILE *frames_ = nullptr, *haptics_ = nullptr, *states_ = nullptr, *profiles_ = nullptr,
            *views_ = nullptr, *handles_ = nullptr, *misuse_ = nullptr;
};

}  // namespace livegs::simulated
