// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>

#include "cli/csv_file.h"
#include "core/result.h"
#include "scene/scene.h"
#include "scene/views/scene_drawing.h"

namespace livegs {

// The CSV files of `livegs simulate`: one row a thing a frame, frame 0 before any step, world axes, SI units;
// twelve digits of what is computed in double, nine of what is single.
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
  std::filesystem::path folder_;
  CsvFile bodies_, energy_, events_;
  std::optional<CsvFile> particles_, kernels_;
};

}  // namespace livegs
