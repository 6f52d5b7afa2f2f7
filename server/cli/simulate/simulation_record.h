// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>

#include "cli/simulate/csv_file.h"
#include "core/result.h"
#include "scene/scene.h"
#include "scene/views/scene_drawing.h"

namespace livegs {

// Writes the CSV files of `livegs simulate`: one row per item and frame, frame 0 before the first step. World
// axes, SI units. Twelve digits for double precision values, nine for single precision.
class SimulationRecord {
 public:
  struct Options {
    bool particles = false;
    bool kernels = false;
  };
  static Result<SimulationRecord> open(const std::filesystem::path& folder, const Options& options);

  // Writes the current state of the scene. If kernels are recorded, `drawing` must just have posed it. Takes
  // the world's events.
  void write(Scene& scene, const SceneDrawing& drawing);
  // Fails if any write failed, for example on a full disk.
  Result<void> close();

 private:
  std::filesystem::path folder_;
  CsvFile bodies_, energy_, events_;
  std::optional<CsvFile> particles_, kernels_;
};

}  // namespace livegs
