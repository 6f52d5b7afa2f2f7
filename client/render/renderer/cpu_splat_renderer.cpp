// SPDX-License-Identifier: Apache-2.0
#include "render/splat_renderer.h"

namespace livegs {
namespace {

class CpuSplatRenderer final : public SplatRenderer {
 public:
  explicit CpuSplatRenderer(std::string notice) : notice_(std::move(notice)) {}

  const std::string& name() const override { return name_; }

  Result<void> draw(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                    const RenderOptions& options, std::vector<Image>& images) override {
    std::vector<DrawnObject> drawn;
    for (const RenderedObject& object : objects) drawn.push_back(object.drawn);
    times_ = {};
    images.resize(eyes.size());
    Eigen::Vector3d between_m = Eigen::Vector3d::Zero();
    for (const Camera& eye : eyes)
      between_m += eye.world_from_camera.position_m / static_cast<double>(eyes.size());
    RasteriseOptions rasterised;
    rasterised.background = options.background;
    rasterised.order = options.order;
    rasterised.max_sh_degree = options.max_sh_degree;
    rasterised.min_contribution_px = options.min_contribution_px;
    rasterised.max_radius_px = options.max_radius_px;
    rasterised.image_only = true;
    rasterised.distance_from_m = between_m;
    rasterised.shadows = options.shadows;
    rasterised.environments = options.environments;
    for (size_t e = 0; e < eyes.size(); ++e) {
      rasteriser_.draw(drawn, eyes[e], rasterised, view_);
      std::swap(images[e], view_.image);
      const Rasteriser::Times& times = rasteriser_.last_times();
      times_.project_ms += times.project_ms;
      times_.sort_ms += times.sort_ms;
      times_.draw_ms += times.blend_ms;
    }
    return {};
  }

  const RenderTimes& last_times() const override { return times_; }
  std::string notice() const override { return notice_; }

 private:
  std::string name_ = "cpu", notice_;
  Rasteriser rasteriser_;
  RasterisedView view_;
  RenderTimes times_;
};

}  // namespace

std::unique_ptr<SplatRenderer> create_cpu_renderer() {
  return std::make_unique<CpuSplatRenderer>(std::string());
}

std::unique_ptr<SplatRenderer> create_cpu_renderer_instead_of(const std::string& device, const Error& why) {
  return std::make_unique<CpuSplatRenderer>(device + ": rendering continues on the CPU (" + why.message +
                                            ")");
}

}  // namespace livegs
