// SPDX-License-Identifier: Apache-2.0
// Rows of one eye in up to three buffers (Rows0, Rows1, Rows2), constants.part_rows each.

SplatRow row_of(uint place) {
  if (place < constants.part_rows) return rows_0[place];  // nearly always
  if (place < 2 * constants.part_rows) return rows_1[place - constants.part_rows];
  return rows_2[place - 2 * constants.part_rows];
}
