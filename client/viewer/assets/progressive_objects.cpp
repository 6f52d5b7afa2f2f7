// SPDX-License-Identifier: Apache-2.0
#include "viewer/assets/progressive_objects.h"

#include <chrono>
#include <utility>

namespace livegs {
namespace {

template <class Value>
bool is_ready(const std::future<Value>& future) {
  return future.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

}  // namespace

std::future<Result<ProgressiveObjects::Binding>> ProgressiveObjects::bind_more(const StreamedObject& object,
                                                                               size_t than_step, bool whole) {
  return std::async(std::launch::async, [&assets = assets_, object, than_step, whole]() -> Result<Binding> {
    auto arrived = assets.wait_for_more(object.asset_hash, than_step);
    while (whole && arrived && arrived->part)
      arrived = assets.wait_for_more(object.asset_hash, arrived->step);
    if (!arrived) return arrived.error();
    RestBody rest = arrived->part ? rest_of_part(object.rest, arrived->part->indices) : object.rest;
    auto bound = bind_object(object.id, arrived->asset, std::move(rest), object.environment);
    if (!bound) return Error{bound.error().code, object.name + ": " + bound.error().message};
    return Binding{object, *std::move(bound), arrived->step, !arrived->part};
  });
}

std::future<Result<ProgressiveObjects::Binding>> ProgressiveObjects::bind(const StreamedObject& object,
                                                                          bool whole) {
  return bind_more(object, 0, whole);
}

void ProgressiveObjects::remove_coarse(uint32_t object_id) {
  const auto known = coarse_.find(object_id);
  if (known == coarse_.end()) return;
  if (known->second.finer.valid()) unwanted_.push_back(std::move(known->second.finer));
  coarse_.erase(known);
}

void ProgressiveObjects::show(Binding binding, SceneView& view, bool added) {
  const uint32_t id = binding.object.id;
  remove_coarse(id);
  if (!binding.whole)
    coarse_[id] = {std::move(binding.object), binding.bound.asset->size(), binding.step, {}};
  added ? view.add(id, std::move(binding.bound)) : view.change(id, std::move(binding.bound));
}

Result<void> ProgressiveObjects::add(const StreamedObject& object, SceneView& view) {
  auto binding = bind(object).get();
  if (!binding) return binding.error();
  show(*std::move(binding), view, true);
  return {};
}

void ProgressiveObjects::remove(uint32_t object_id, SceneView& view) {
  remove_coarse(object_id);
  view.remove(object_id);
}

Result<std::vector<uint32_t>> ProgressiveObjects::refine(SceneView& view) {
  std::erase_if(unwanted_, [](const auto& one) { return is_ready(one); });
  std::vector<uint32_t> refined;
  for (auto at = coarse_.begin(); at != coarse_.end();) {
    auto& [id, coarse] = *at;
    if (!coarse.finer.valid() && assets_.has_more(coarse.object.asset_hash, coarse.step))
      coarse.finer = bind_more(coarse.object, coarse.step);
    if (!coarse.finer.valid() || !is_ready(coarse.finer)) {
      ++at;
      continue;
    }
    auto binding = coarse.finer.get();
    if (!binding) return binding.error();
    coarse.shown = binding->bound.asset->size();
    coarse.step = binding->step;
    const bool whole = binding->whole;
    view.refine(id, std::move(binding->bound));
    refined.push_back(id);
    at = whole ? coarse_.erase(at) : std::next(at);
  }
  return refined;
}

ProgressiveObjects::Progress ProgressiveObjects::progress() const {
  Progress progress;
  for (const auto& [id, coarse] : coarse_) {
    ++progress.objects;
    progress.kernels_shown += coarse.shown;
    progress.kernels_total += coarse.object.kernel_count;
  }
  return progress;
}

}  // namespace livegs
