// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/division/picture_votes.h"

#include <algorithm>
#include <limits>

#include "analysis/division/label_boxes.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

// Least share of a kernel's votes for its part. Below, its pixels contradict each other and it is ignored.
constexpr double kMinVoteShare = 0.6;
// Least share of the surface that votes decide, that a part has, and that the boxes in space reproduce.
constexpr double kMinDecidedShare = 0.3, kMinPartShare = 0.003, kMinAgreement = 0.75;

constexpr size_t kNoPart = std::numeric_limits<size_t>::max();

// Part of each cell of a picture.
std::vector<size_t> parts_of_cells(const PictureSights& picture, size_t index,
                                   std::span<const BoxedPart> parts) {
  size_t rest = kNoPart;
  for (size_t i = 0; i < parts.size() && rest == kNoPart; ++i) {
    if (parts[i].boxes.empty() && !parts[i].inside) rest = i;
  }
  std::vector<size_t> cells(static_cast<size_t>(picture.columns) * static_cast<size_t>(picture.rows), rest);
  std::vector<double> areas(cells.size(), std::numeric_limits<double>::infinity());
  for (size_t i = 0; i < parts.size(); ++i) {
    for (const PictureBox& box : parts[i].boxes) {
      if (box.picture != index) continue;
      const double area = (box.right - box.left) * (box.bottom - box.top);
      for (int row = 0; row < picture.rows; ++row) {
        const double y = (row + 0.5) / picture.rows;
        if (y < box.top || y > box.bottom) continue;
        for (int column = 0; column < picture.columns; ++column) {
          const double x = (column + 0.5) / picture.columns;
          const size_t cell =
              static_cast<size_t>(row) * static_cast<size_t>(picture.columns) + static_cast<size_t>(column);
          if (x < box.left || x > box.right || area >= areas[cell]) continue;
          cells[cell] = i;
          areas[cell] = area;
        }
      }
    }
  }
  return cells;
}

}  // namespace

std::vector<std::vector<float>> picture_votes(std::span<const PictureSights> pictures,
                                              std::span<const BoxedPart> parts, size_t kernel_count) {
  std::vector<std::vector<float>> votes(parts.size(), std::vector<float>(kernel_count, 0.0f));
  for (size_t index = 0; index < pictures.size(); ++index) {
    const PictureSights& picture = pictures[index];
    // A picture without marked parts is ignored, also for the remaining volume.
    const bool marked = std::any_of(parts.begin(), parts.end(), [&](const BoxedPart& part) {
      return std::any_of(part.boxes.begin(), part.boxes.end(),
                         [&](const PictureBox& box) { return box.picture == index; });
    });
    if (!marked) continue;
    const std::vector<size_t> cells = parts_of_cells(picture, index, parts);
    for (const PictureSights::Seen& seen : picture.seen) {
      if (seen.cell >= cells.size() || seen.kernel >= kernel_count) continue;
      if (const size_t part = cells[seen.cell]; part != kNoPart) votes[part][seen.kernel] += seen.weight;
    }
  }
  return votes;
}

VotedDivision divide_by_votes(const SurfaceKernels& kernels, std::span<const std::vector<float>> votes,
                              std::span<const std::optional<PartHolder>> holder, MaterialParts& parts) {
  const size_t count = kernels.positions_m.size();
  std::vector<uint8_t> labels(count, kNoLabel);
  std::vector<double> shares(votes.size(), 0.0);
  double whole = 0, decided = 0;
  for (size_t i = 0; i < count; ++i) {
    double sum = 0, most = 0;
    size_t best = 0;
    for (size_t part = 0; part < votes.size(); ++part) {
      sum += votes[part][i];
      if (votes[part][i] > most) most = votes[part][i], best = part;
    }
    whole += kernels.weights[i];
    if (!(most > 0) || most < kMinVoteShare * sum) continue;
    labels[i] = static_cast<uint8_t>(best);
    shares[best] += kernels.weights[i];
    decided += kernels.weights[i];
  }
  const auto one_part = [](std::string why) { return VotedDivision{false, "one part: " + std::move(why)}; };
  if (!(decided >= kMinDecidedShare * whole) || !(decided > 0))
    return one_part(format_text("the boxes decide about %.0f %% of the surface only",
                                whole > 0 ? 100 * decided / whole : 0.0));
  for (size_t part = 0; part < votes.size(); ++part) {
    if (holder[part] || shares[part] >= kMinPartShare * decided) continue;
    return one_part("hardly any kernel is in the boxes of its part \"" +
                    parts[static_cast<int>(part)].name() + "\"");
  }
  MaterialParts placed = parts;
  place_parts(kernels, labels, holder, placed);
  const PartPlaces places(placed);
  if (!places.divided()) return one_part("no box in space separates its parts");
  double agreed = 0;
  for (size_t i = 0; i < count; ++i) {
    if (labels[i] != kNoLabel && places.at(kernels.positions_m[i].cast<double>()) == labels[i])
      agreed += kernels.weights[i];
  }
  if (agreed < kMinAgreement * decided)
    return one_part(
        format_text("boxes in space agree with only %.0f %% of the votes", 100 * agreed / decided));
  parts = std::move(placed);
  return {true, format_text("boxes on the pictures, by the votes of %.0f %% of the surface; %.0f %% of them "
                            "agree with the boxes in space",
                            100 * decided / whole, 100 * agreed / decided)};
}

}  // namespace livegs
