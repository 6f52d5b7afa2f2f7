// SPDX-License-Identifier: Apache-2.0
#include "viewer/camera/window_picture.h"

#include "core/text/format_text.h"

namespace livegs {

Result<void> WindowPicture::draw(SceneView& view, const OrbitCamera& camera, const Eigen::Vector2i& window_px,
                                 int64_t now_ns) {
  const Camera window = camera.camera(window_px.x(), window_px.y());
  const StillPicture::Draw draw = still_.next(window, view.version(), now_ns);
  drawn_ = draw != StillPicture::Draw::Nothing;
  if (!drawn_) return {};
  const bool full = draw == StillPicture::Draw::Full;
  const Camera eye = full ? window : camera.camera(scale_.of(window_px.x()), scale_.of(window_px.y()));
  const float min_contribution_px = full ? 0 : scale_.min_contribution_px();
  view.set_min_contribution(min_contribution_px);
  if (!full && scale_.value() == 1.0 && min_contribution_px == 0) still_.drew_in_full();
  if (auto done = view.draw(std::span(&eye, 1), images_); !done) return done;
  if (!full) scale_.drew(view.last_times().raster_ms);
  return {};
}

std::string WindowPicture::text() const {
  if (rests()) return "resolution 100 %, at rest";
  // Kept short enough for one line: longer text would be broken after the decimal point.
  return format_text("resolution %.0f %%", 100.0 * scale_.value()) +
         (scale_.min_contribution_px() > 0
              ? format_text(", culling under %.1g px", scale_.min_contribution_px())
              : "");
}

}  // namespace livegs
