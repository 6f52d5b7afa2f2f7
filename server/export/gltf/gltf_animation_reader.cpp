// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "export/gltf/gltf_values.h"

namespace livegs::gltf {

Result<std::optional<PortableAnimation>> read_animation(const Values& values, const Json& own,
                                                        const std::vector<PortableBody>& bodies,
                                                        const std::map<size_t, size_t>& body_of_node) {
  const Json& index = part_of(own, "times");
  if (index.is_null()) return std::optional<PortableAnimation>();
  PortableAnimation animation;
  const auto times = values.document().numbers(index, 1);
  if (!times) return times.error();
  for (size_t i = 0; i < times->count; ++i) {
    animation.times_s.push_back(times->at(i, 0));
    if (!std::isfinite(animation.times_s[i]) || (i > 0 && !(animation.times_s[i] > animation.times_s[i - 1])))
      return values.problem("the times of the animation do not increase");
  }
  // The samplers of each node by path.
  std::map<std::pair<size_t, std::string>, const Json*> outputs;
  const Json& animations = part_of(values.document().json(), "animations");
  if (animations.is_array() && !animations.empty()) {
    const Json& channels = part_of(animations[0], "channels");
    const Json& samplers = part_of(animations[0], "samplers");
    for (size_t i = 0; channels.is_array() && i < channels.size(); ++i) {
      const auto sampler = values.entry_of(samplers, part_of(channels[i], "sampler"), "a channel", "sampler");
      if (!sampler) return sampler.error();
      const Json& target = part_of(channels[i], "target");
      const Json& node = part_of(target, "node");
      if (!values.document().entry("nodes", node)) return values.problem("a channel has no valid node");
      outputs[{static_cast<size_t>(node.get<double>()), text_of(target, "path")}] =
          &part_of(**sampler, "output");
    }
  }
  for (const auto& [node, body] : body_of_node) {
    const std::string where = name_of_node(node);
    const Json& extension = extension_of(values.document().json()["nodes"][node], "LIVEGS_physics");
    const Json& span = part_of(extension, "track");
    if (!span.is_object()) continue;
    const auto first = values.number(span, "first_key", 0, where),
               keys = values.number(span, "keys", 0, where);
    if (!first || !keys || *first < 0 || *keys < 0 || *first != std::floor(*first) ||
        *keys != std::floor(*keys) || *first + *keys > static_cast<double>(animation.times_s.size()))
      return values.bad(where, "has a track beyond the times of the animation");
    PortableTrack track;
    track.body = body;
    track.first_key = static_cast<size_t>(*first);
    const auto size = static_cast<size_t>(*keys);
    if (size > 0) {
      const auto moved = outputs.find({node, "translation"}), turned = outputs.find({node, "rotation"});
      if (moved == outputs.end() || turned == outputs.end())
        return values.bad(where, "has a track without channels");
      const auto positions = values.document().numbers(*moved->second, 3);
      const auto rotations = values.document().numbers(*turned->second, 4);
      if (!positions) return positions.error();
      if (!rotations) return rotations.error();
      if (auto within = values.spend(7 * size); !within) return within.error();
      if (positions->count != size || rotations->count != size)
        return values.bad(where, "has a track with the wrong number of keys");
      for (size_t i = 0; i < size; ++i) {
        const Eigen::Quaterniond q(rotations->at(i, 3), rotations->at(i, 0), rotations->at(i, 1),
                                   rotations->at(i, 2));
        if (!(q.norm() > 0.5 && q.norm() < 2)) return values.bad(where, "has a key without a valid rotation");
        track.world_from_object.push_back(
            {{positions->at(i, 0), positions->at(i, 1), positions->at(i, 2)}, q.normalized()});
      }
    }
    const Json& cache = part_of(extension, "point_cache");
    if (cache.is_object() && size > 0) {
      const auto positions = values.document().numbers(part_of(cache, "positions"), 3);
      if (!positions) return positions.error();
      const size_t nodes = bodies[body].elastic ? bodies[body].elastic->lattice.node_coordinates.size() : 0;
      if (nodes == 0 || positions->count != nodes * size)
        return values.bad(where, "has a point cache with the wrong number of positions");
      if (auto within = values.spend(3 * positions->count); !within) return within.error();
      for (size_t key = 0; key < size; ++key) {
        auto& list = track.nodes_m.emplace_back();
        for (size_t i = key * nodes; i < (key + 1) * nodes; ++i)
          list.push_back(
              Eigen::Vector3d(positions->at(i, 0), positions->at(i, 1), positions->at(i, 2)).cast<float>());
      }
    }
    animation.tracks.push_back(std::move(track));
  }
  return std::optional(std::move(animation));
}

}  // namespace livegs::gltf
