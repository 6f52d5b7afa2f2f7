// SPDX-License-Identifier: Apache-2.0
#include "render/splat_renderer.h"

namespace livegs {
namespace {

class CpuSplatRenderer final : public SplatRenderer {
 public:
  const std::string& name() const override { return name_; }

  Result<void> draw(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                    const RenderOptions& options, std::vector<Image>& images) override {
    std::vector<DrawnObject> drawn;
    for (const RenderedObject& object : objects) drawn.push_back(object.drawn);
    times_ = {};
    images.resize(eyes.size());
    for (size_t e = 0; e < eyes.size(); ++e) {
      rasteriser_.draw(drawn, eyes[e],
                       {options.background, options.order, options.max_sh_degree, options.min_contribution_px, options.max_radius_px}, view_);
      std::swap(images[e], view_.image);
      const Rasteriser::Times& times = rasteriser_.last_times();
      times_.project_ms += times.project_ms;
      times_.sort_ms += times.sort_ms;
      times_.draw_ms += times.blend_ms;
    }
    return {};
  }

  const RenderTimes& last_times() const override { return times_; }

 private:
  std::string name_ = "cpu";
  Rasteriser rasteriser_;
  RasterisedView view_;
  RenderTimes times_;
};

}  // namespace

std::unique_ptr<SplatRenderer> create_cpu_renderer() { return std::make_unique<CpuSplatRenderer>(); }

}  // namespace livegs
