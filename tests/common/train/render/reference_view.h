// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "train/render/trained_view.h"

namespace livegs {

// The renderer of trained kernels again, in double precision, pixel by pixel without tiles, from the inverse
// covariance. Rows are those of KernelParameters.
struct ReferenceKernels {
  std::array<std::vector<double>, kFamilies> families;
  explicit ReferenceKernels(const KernelParameters& parameters);
};
struct ReferencePicture {
  std::vector<double> red, green, blue, alpha;
  std::vector<double> spread;  // sum of w w |z - z| over all pairs of kernels
};
ReferencePicture reference_view(const ReferenceKernels& kernels, const Camera& camera,
                                const TrainedViewOptions& options);

}  // namespace livegs
