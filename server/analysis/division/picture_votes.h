// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/division/part_places.h"
#include "analysis/division/place_parts.h"
#include "analysis/estimate.h"

// Boxes around parts on pictures of an object, lifted to its kernels by votes: a kernel votes with its alpha
// times transmittance in each pixel, for the part whose box contains the pixel (server/parts/label does the
// same for the things of a room).

namespace livegs {

// Cells along the longer side of a picture: the precision of boxes, 0.4 %. All cells fit 16 bits.
inline constexpr int kSightCells = 250;

// Kernels of an object that one picture shows.
struct PictureSights {
  struct Seen {
    uint32_t kernel;  // index in SurfaceKernels
    uint16_t cell;    // row * columns + column, from the top left
    float weight;     // alpha times transmittance, summed over the cell
  };
  int columns = 0, rows = 0;
  std::vector<Seen> seen;
};

// A rectangle on a picture: fractions of its width from the left and of its height from the top.
struct PictureBox {
  size_t picture = 0;
  double left = 0, top = 0, right = 1, bottom = 1;
};

// Boxes of one part; `inside`: another part encloses it.
struct BoxedPart {
  std::vector<PictureBox> boxes;
  bool inside = false;
};

// Votes of each kernel for each part, [part][kernel]. Where boxes overlap, the smallest one counts. Pixels
// outside of all boxes count for the first part without boxes that is not enclosed, if there is one.
std::vector<std::vector<float>> picture_votes(std::span<const PictureSights> pictures,
                                              std::span<const BoxedPart> parts, size_t kernel_count);

// Divides an object by votes. A kernel belongs to the part with most of its votes; boxes decide for unseen
// kernels. `holder` as for place_parts(). Returns the reason for the division or for a single part: too few
// seen kernels, a part that is hardly visible, or parts that boxes do not separate.
struct VotedDivision {
  bool divided = false;
  std::string reason;
};
VotedDivision divide_by_votes(const SurfaceKernels& kernels, std::span<const std::vector<float>> votes,
                              std::span<const std::optional<PartHolder>> holder, MaterialParts& parts);

}  // namespace livegs
