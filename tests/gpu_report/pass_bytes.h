// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "gaussian/asset/posed_kernel_row.h"
#include "skin/kernels/rest_kernel_row.h"
#include "skin/kernels/skin_lattice_layout.h"
#include "splat/passes/project_splats_layout.h"
#include "splat/passes/sort_keys_layout.h"

// Bytes that each pass has to read from and write to device memory, from the layouts of its rows. A row that
// several kernels share counts once, as if caches were perfect. A share of bandwidth below is these bytes by
// the time of the pass, so traffic on top of them lowers the share.

namespace livegs::gpu_report {

// One object on a lattice in one picture, with all kernels visible.
struct FrameShape {
  double kernels = 0, cells = 0, nodes = 0;
  double eyes = 1, pixels = 0;  // pixels of one eye
  double sh_row_words = 0;      // of 4 bytes: spherical harmonics of a kernel above the first band
  double blend_bytes = 8;       // of a blended pixel: 8 for 16-bit floats, 16 for 32-bit floats
};

struct PassBytes {
  double skin = 0, project = 0, sort = 0, draw = 0, resolve = 0;
};

constexpr double kWordBytes = 4;
constexpr double kCellBytes = 8 * kWordBytes;  // the nodes at the corners
constexpr double kNodeBytes = kLatticeNodeFloats * kWordBytes;
constexpr double kSortPasses = 8;    // four bits each
constexpr double kPictureBytes = 4;  // of a resolved pixel

inline PassBytes pass_bytes(const FrameShape& frame) {
  PassBytes bytes;
  // Reads the row at rest, the cells and the nodes; writes the posed row.
  bytes.skin = frame.kernels * (sizeof(RestKernelRow) + sizeof(PosedKernelRow)) + frame.cells * kCellBytes +
               frame.nodes * kNodeBytes;
  // Reads the posed row, the look and its bands; writes a row per eye and the key.
  bytes.project =
      frame.kernels * (sizeof(PosedKernelRow) + sizeof(KernelLookRow) + frame.sh_row_words * kWordBytes +
                       frame.eyes * sizeof(SplatRow) + kWordBytes);
  // In each pass, the count reads the key, and the scatter reads and writes key and value. The first pass
  // reads no values. A tile writes its counts, the scan reads and writes them, and the scatter reads them.
  const double tiles = frame.kernels / kSortTile;
  bytes.sort = kSortPasses * (frame.kernels * 5 * kWordBytes + tiles * kSortDigits * 4 * kWordBytes) -
               frame.kernels * kWordBytes;
  // Reads the order and the rows; writes each pixel once. Overlapping splats add to it.
  bytes.draw = frame.kernels * (kWordBytes + frame.eyes * sizeof(SplatRow)) +
               frame.eyes * frame.pixels * frame.blend_bytes;
  bytes.resolve = frame.eyes * frame.pixels * (frame.blend_bytes + kPictureBytes);
  return bytes;
}

}  // namespace livegs::gpu_report
