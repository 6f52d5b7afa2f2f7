// SPDX-License-Identifier: Apache-2.0
#include "record.h"

#include <png.h>

#include <cstdlib>

namespace livegs::simulated {

Record::Record() {
  const char* folder = std::getenv("LIVEGS_XR_OUTPUT");
  folder_ = folder ? folder : "";
  frames_ = open("frames.csv",
                 "frame,waited_s,ended_s,displayed_s,eye,hash,px,py,pz,qw,qx,qy,qz,left_rad,right_rad,up_rad,"
                 "down_rad,png");
  haptics_ = open("haptics.csv", "time_s,hand,amplitude,duration_ns");
  states_ = open("states.csv", "time_s,state");
  profiles_ = open("profiles.csv", "time_s,profile");
  views_ = open("views.csv",
                "frame,eye,answers,first_lead_s,first_x,first_y,first_z,last_lead_s,last_x,last_y,last_z");
  handles_ = open("handles.csv", "destroyed,kind,made,left");
  misuse_ = open("misuse.txt", nullptr);
}

Record::~Record() {
  for (std::FILE* file : {frames_, haptics_, states_, profiles_, views_, handles_, misuse_}) {
    if (file) std::fclose(file);
  }
}

std::FILE* Record::open(const char* name, const char* header) const {
  if (folder_.empty()) return nullptr;
  std::FILE* file = std::fopen((folder_ + "/" + name).c_str(), "a");
  if (file && header && std::ftell(file) == 0) std::fprintf(file, "%s\n", header), std::fflush(file);
  return file;
}

void Record::frame(uint64_t index, double time_s, double ended_s, double displayed_s,
                   const std::vector<EyeRecord>& eyes, bool keep) {
  if (!frames_ || !views_) return;
  if (eyes.empty())
    std::fprintf(frames_, "%lu,%.6f,%.6f,%.6f,,,,,,,,,,,,,,\n", static_cast<unsigned long>(index), time_s,
                 ended_s, displayed_s);
  for (size_t e = 0; e < eyes.size(); ++e) {
    const EyeRecord& eye = eyes[e];
    char name[64] = "";
    if (keep) {
      std::snprintf(name, sizeof name, "frame_%05lu_%zu.png", static_cast<unsigned long>(index), e);
      png_image image{};
      image.version = PNG_IMAGE_VERSION;
      image.width = static_cast<png_uint_32>(eye.width);
      image.height = static_cast<png_uint_32>(eye.height);
      image.format = PNG_FORMAT_RGB;
      std::vector<uint8_t> rgb;  // layers without blending are opaque
      for (size_t i = 0; i < eye.rgba.size(); i += 4) rgb.insert(rgb.end(), &eye.rgba[i], &eye.rgba[i] + 3);
      png_image_write_to_file(&image, (folder_ + "/" + name).c_str(), 0, rgb.data(), 0, nullptr);
    }
    const XrPosef& p = eye.pose;
    std::fprintf(frames_,
                 "%lu,%.6f,%.6f,%.6f,%zu,%016lx,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%s\n",
                 static_cast<unsigned long>(index), time_s, ended_s, displayed_s, e,
                 static_cast<unsigned long>(eye.hash), p.position.x, p.position.y, p.position.z,
                 p.orientation.w, p.orientation.x, p.orientation.y, p.orientation.z, eye.fov.angleLeft,
                 eye.fov.angleRight, eye.fov.angleUp, eye.fov.angleDown, name);
    const EyePrediction& prediction = eye.prediction;
    std::fprintf(views_, "%lu,%zu,%d,%.6f,%.9g,%.9g,%.9g,%.6f,%.9g,%.9g,%.9g\n",
                 static_cast<unsigned long>(index), e, prediction.answers, prediction.first_lead_s,
                 prediction.first.x, prediction.first.y, prediction.first.z, prediction.last_lead_s,
                 prediction.last.x, prediction.last.y, prediction.last.z);
  }
  std::fflush(frames_);
  std::fflush(views_);
}

void Record::haptic(double time_s, const std::string& hand, const XrHapticVibration& vibration) {
  if (!haptics_) return;
  std::fprintf(haptics_, "%.6f,%s,%.4f,%ld\n", time_s, hand.c_str(), vibration.amplitude,
               static_cast<long>(vibration.duration));
  std::fflush(haptics_);
}

void Record::state(double time_s, const std::string& state) {
  if (!states_) return;
  std::fprintf(states_, "%.6f,%s\n", time_s, state.c_str());
  std::fflush(states_);
}

void Record::profile(double time_s, const std::string& profile) {
  if (!profiles_) return;
  std::fprintf(profiles_, "%.6f,%s\n", time_s, profile.c_str());
  std::fflush(profiles_);
}

void Record::handles(const char* destroyed, const char* kind, size_t made, size_t left) {
  if (!handles_) return;
  std::fprintf(handles_, "%s,%s,%zu,%zu\n", destroyed, kind, made, left);
  std::fflush(handles_);
}

void Record::misuse(const std::string& what) {
  std::fprintf(stderr, "simulated runtime: %s\n", what.c_str());
  if (!misuse_) return;
  std::fprintf(misuse_, "%s\n", what.c_str());
  std::fflush(misuse_);
}

}  // namespace livegs::simulated
