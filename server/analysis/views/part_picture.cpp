// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/views/part_picture.h"

#include <algorithm>

namespace livegs {

Image part_picture(const PictureSights& sights, const SurfaceKernels& kernels, const MaterialParts& parts) {
  const PartPlaces places(parts);
  Image image;
  image.width = sights.columns;
  image.height = sights.rows;
  const size_t cells = static_cast<size_t>(sights.columns) * static_cast<size_t>(sights.rows);
  image.pixels.assign(4 * cells, 1.0f);
  std::vector<Eigen::Vector3f> sums(cells, Eigen::Vector3f::Zero());
  std::vector<float> covers(cells, 0.0f);
  for (const PictureSights::Seen& seen : sights.seen) {
    if (seen.cell >= cells || seen.kernel >= kernels.positions_m.size()) continue;
    const Eigen::Vector3f own = kernels.rgb[seen.kernel];
    Eigen::Vector3f rgb = Eigen::Vector3f::Constant(own.mean());
    if (places.divided())
      rgb = shaded_part_rgb(places.at(kernels.positions_m[seen.kernel].cast<double>()), own);
    sums[seen.cell] += seen.weight * rgb;
    covers[seen.cell] += seen.weight;
  }
  // Every k-th kernel is known; a full cell has this cover.
  const float full = 1.0f / static_cast<float>(kernels.stride);
  for (size_t i = 0; i < cells; ++i) {
    if (!(covers[i] > 0)) continue;
    const float alpha = std::min(1.0f, covers[i] / full);
    for (int c = 0; c < 3; ++c)
      image.pixels[4 * i + static_cast<size_t>(c)] = alpha * sums[i][c] / covers[i] + 1 - alpha;
  }
  return image;
}

}  // namespace livegs
