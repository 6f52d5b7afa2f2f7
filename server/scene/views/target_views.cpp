// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/views/target_views.h"

#include "analysis/views/object_views.h"
#include "analysis/views/part_picture.h"
#include "splat/image.h"

namespace livegs {
namespace {

Result<AnalysisImage> png_of(const Image& image, const char* caption) {
  auto bytes = encode_png(image);
  if (!bytes) return bytes.error();
  return AnalysisImage{caption, "image/png",
                       std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size())};
}

}  // namespace

Result<std::vector<TargetView>> target_views(const ViewedScene& scene, uint32_t object_id, int count,
                                             std::stop_token stop) {
  std::vector<DrawnObject> drawn;
  for (const ViewedScene::Object& object : scene.objects) {
    drawn.push_back({object.asset.get(), &object.kernels, object.object_id});
  }
  ViewOptions options;
  for (const ViewedScene::Object& object : scene.objects) {
    if (object.object_id == object_id) options.sight_stride = surface_stride(object.asset->size());
  }
  options.long_side_px = kViewLongSide_px;
  options.view_count = count;
  options.stop = std::move(stop);
  auto views = object_views(drawn, object_id, options);
  if (!views) return views.error();
  std::vector<TargetView> targets;
  for (ObjectView& view : *views) {
    auto outlined = png_of(view.outlined, "outlined");
    auto cutout = png_of(view.cutout, "cut-out");
    auto mask = png_of(view.mask, "mask");
    if (!outlined) return outlined.error();
    if (!cutout) return cutout.error();
    if (!mask) return mask.error();
    targets.push_back({{std::move(*outlined), std::move(*cutout)},
                       describe_camera(view),
                       std::move(*mask),
                       camera_slots(view),
                       std::move(view.sights)});
  }
  return targets;
}

Result<std::vector<AnalysisImage>> part_pictures(const TargetView& view, const ObjectFacts& facts,
                                                 const v1::PhysicalParameters& physics) {
  std::vector<AnalysisImage> images;
  for (size_t i = 0; facts.kernels && i < view.sights.size(); ++i) {
    auto image =
        png_of(part_picture(view.sights[i], *facts.kernels, physics.parts()), "in the colours of its parts");
    if (!image) return image.error();
    images.push_back(std::move(*image));
  }
  return images;
}

}  // namespace livegs
