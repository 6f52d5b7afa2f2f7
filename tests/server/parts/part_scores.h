// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gaussian/gaussian_asset.h"
#include "splat/camera.h"
#include "splat/image.h"

// Scores of a segmentation on views that it did not use.

namespace livegs {

// The label with the largest share of each pixel; 0 where coverage is under a half.
std::vector<uint16_t> label_picture(const GaussianAsset& asset, std::span<const uint16_t> label,
                                    const Camera& camera);

struct ThingScore {
  uint16_t truth = 0;
  uint16_t label = 0;                // that overlaps most
  double iou = 0, boundary_iou = 0;  // sums over all views
};
struct PartScores {
  std::vector<ThingScore> things;
  size_t found = 0;  // things with an IoU of at least a half
  size_t extra = 0;  // other labels that show
  double mean_iou = 0, mean_boundary_iou = 0, mean_found_iou = 0;
};
// One picture per view each, of equal sizes. A boundary is within 2 % of the picture's diagonal (Cheng et al.
// 2021, Boundary IoU). `ignored` truths, such as a table, are no things and may have no label.
PartScores score_parts(std::span<const std::vector<uint16_t>> truth,
                       std::span<const std::vector<uint16_t>> found, int width,
                       std::span<const uint16_t> ignored = {});

// A thing drawn alone where its kernels cover at least a half of a pixel, compared with its true masks, one
// per view. Pixels where `hidden` is nonzero, behind other things, do not count.
struct AloneScore {
  double iou = 0, boundary_iou = 0;
};
AloneScore score_alone(const GaussianAsset& thing, std::span<const Camera> cameras,
                       std::span<const std::vector<uint8_t>> truth,
                       std::span<const std::vector<uint8_t>> hidden);

// Of the kernels whose weights in all views add up to a pixel or more: the share of those of which less than
// 80 % shows in the pixels of one label.
double mixed_kernels(const GaussianAsset& asset, std::span<const Camera> cameras,
                     std::span<const std::vector<uint16_t>> pictures);

// A picture with a colour for each label over the grey picture.
Image paint_labels(const Image& picture, std::span<const uint16_t> labels);

// Cameras around the middle at two elevations.
std::vector<Camera> orbit(const Eigen::Vector3d& middle_m, const Eigen::Vector3d& up, double radius_m,
                          size_t count, int width, double first_azimuth_rad, double sweep_rad);

}  // namespace livegs
