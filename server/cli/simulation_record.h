// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "core/result.h"
#include "scene/scene.h"
#include "scene/scene_drawing.h"

namespace livegs {

// The CSV files of `livegs simulate`: one row a thing a frame, frame 0 before any step, world axes, SI units,
// enough digits to give back the same double.
class SimulationRecord {
 public:
  struct Options {
    bool particles = false;
    bool kernels = false;
  };
  static Result<SimulationRecord> open(const std::filesystem::path& folder, const Options& options);

  // Writes the scene as it is. `drawing` has just posed it when kernels are recorded. Takes the world's
  // events.
  void write(Scene& scene, const SceneDrawing& drawing);
  // Fails if anything could not be written (a full disk, say).
  Result<void> close();

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  using File = std::unique_ptr<std::FILE, Closer>;
  Result<File> create(const char* name, const char* header);

  std::filesystem::path folder_;
  File bodies_, particles_, kernels_, energy_, events_;
};

}  // namespace livegs
