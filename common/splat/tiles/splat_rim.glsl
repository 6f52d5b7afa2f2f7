// SPDX-License-Identifier: Apache-2.0
// GPU twin of raster/ellipse_rim.h: the ellipse in the frame of its triangular root. At v the rim is at
// x = centre + (-slope v +- sqrt(rim - v v)) width.

struct SplatRim {
  float centre_x;
  float centre_y;
  float down_y;
  float slope;
  float width;
  float rim;
  float reach;
  float v_rightmost;
};

// `rim`: u u + v v there, positive.
SplatRim rim_of(SplatRow row, float rim) {
  const float reach = sqrt(rim);
  const float slope = row.across_y / row.down_y;
  return SplatRim(row.centre_x_px, row.centre_y_px, row.down_y, slope, 1.0 / row.across_x, rim, reach,
                  -slope * reach / sqrt(1.0 + slope * slope));
}

// First and last pixel with its centre in [begin, end], clamped to [0, size).
ivec2 pixels_between(float begin, float end, float size) {
  return ivec2(int(ceil(clamp(begin - 0.5, 0.0, size))), int(floor(clamp(end - 0.5, -1.0, size - 1.0))));
}

ivec2 rows_of(SplatRim r, float height) {
  const float reach_y = r.reach / r.down_y;
  return pixels_between(r.centre_y - reach_y, r.centre_y + reach_y, height);
}

// First and last pixel column inside the ellipse in the pixel rows [top, bottom); empty if first > last.
ivec2 columns_of(SplatRim r, float top, float bottom, float width) {
  const float v_top = (top + 0.5 - r.centre_y) * r.down_y;
  const float v_bottom = (bottom - 0.5 - r.centre_y) * r.down_y;
  if (v_top > r.reach || v_bottom < -r.reach) return ivec2(1, 0);
  const float v_right = clamp(r.v_rightmost, v_top, v_bottom);
  const float v_left = clamp(-r.v_rightmost, v_top, v_bottom);
  const float half_right = sqrt(max(0.0, r.rim - v_right * v_right));
  const float half_left = sqrt(max(0.0, r.rim - v_left * v_left));
  return pixels_between(r.centre_x + (-r.slope * v_left - half_left) * r.width,
                        r.centre_x + (-r.slope * v_right + half_right) * r.width, width);
}
