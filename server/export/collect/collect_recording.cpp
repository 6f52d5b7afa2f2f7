// SPDX-License-Identifier: GPL-3.0-or-later
#include "export/collect_recording.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <set>

#include "core/clock.h"
#include "core/math/nearest_rotation.h"
#include "core/text/shown_text.h"
#include "gaussian/progressive_asset.h"
#include "recording/recording_reader.h"
#include "wire/frame_stream.h"
#include "wire/rest_body_codec.h"

namespace livegs {
namespace {

// The rigid motion that is nearest to that of the lattice nodes (Umeyama 1991).
Pose rigid_fit(const RestBody& rest, const std::vector<Eigen::Vector3f>& nodes_m) {
  const auto rest_m = [&](size_t n) -> Eigen::Vector3d {
    return rest.object_from_lattice * (rest.cell_width_m * rest.node_coordinates[n].cast<double>());
  };
  const double share = 1.0 / static_cast<double>(nodes_m.size());
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::Zero();
  for (size_t n = 0; n < nodes_m.size(); ++n) {
    from += share * rest_m(n);
    to += share * nodes_m[n].cast<double>();
  }
  Eigen::Matrix3d match = Eigen::Matrix3d::Zero();
  for (size_t n = 0; n < nodes_m.size(); ++n)
    match += (nodes_m[n].cast<double>() - to) * (rest_m(n) - from).transpose();
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(nearest_rotation(match)).normalized();
  return {to - rotation * from, rotation};
}

// A frame's state of one object.
struct Sample {
  size_t key = 0;
  uint32_t revision = 0;
  std::vector<Pose> poses;
  std::vector<Eigen::Vector3f> nodes_m;
};

// Recorded data of one object id: its descriptions by revision.
struct RecordedObject {
  std::string name;
  struct Description {
    RestBody rest;
    std::string asset_hash;
  };
  std::map<uint32_t, Description> descriptions;
  std::vector<Sample> samples;
};

class Motion {
 public:
  explicit Motion(PortableScene& scene) : scene_(scene) {
    for (size_t i = 0; i < scene.bodies.size(); ++i) {
      names_.insert(scene.bodies[i].name);
      if (!scene.bodies[i].drawn_only) by_name_[scene.bodies[i].name] = i;
    }
  }

  Result<void> take(const RecordedEvent& recorded) {
    const v1::SessionEvent& event = recorded.event;
    if (event.has_object_added()) return describe(event.object_added());
    if (event.has_object_changed()) return describe(event.object_changed());
    return {};
  }

  Result<void> take(TickRecord& tick) {
    if (tick.frame.empty()) return {};
    if (tick.key) reader_ = StreamReader();
    auto drivers = reader_.read(tick.frame);
    if (!drivers) return drivers.error();
    if (times_s_.empty() && !tick.key) return {};
    if (times_s_.empty()) first_ns_ = drivers->simulated_ns;
    const double time_s = seconds_from_ns(drivers->simulated_ns - first_ns_);
    // Paused ticks repeat a state; a reset starts the time again.
    if (!times_s_.empty() && drivers->simulated_ns == last_ns_) return {};
    if (!times_s_.empty() && drivers->simulated_ns < last_ns_)
      return unsupported("the scene was reset during the recording; record without a reset");
    last_ns_ = drivers->simulated_ns;
    const size_t key = times_s_.size();
    times_s_.push_back(time_s);
    for (ObjectDrivers& object : drivers->objects) {
      const auto found = objects_.find(object.object_id);
      if (found == objects_.end()) continue;  // the background
      std::vector<Sample>& samples = found->second.samples;
      // A frame that leaves out an object: it keeps its state.
      while (!samples.empty() && samples.back().key + 1 < key) {
        samples.push_back(samples.back());
        ++samples.back().key;
      }
      samples.push_back({key, object.revision, std::move(object.poses), std::move(object.positions_m)});
    }
    return {};
  }

  Result<void> finish(RecordingReader& recording) {
    if (times_s_.empty()) return invalid_data("has no frames; record again without --record-inputs-only");
    PortableAnimation animation;
    animation.times_s = std::move(times_s_);
    for (auto& [id, object] : objects_) {
      if (object.samples.empty()) continue;
      if (auto added = add(object, recording, animation); !added)
        return Error{added.error().code, "object " + quoted_name(object.name) + ": " + added.error().message};
    }
    for (const auto& [name, body] : by_name_) animation.tracks.push_back({body, 0, {}, {}});  // never there
    scene_.animation = std::move(animation);
    return {};
  }

 private:
  Result<void> describe(const v1::ObjectDescription& object) {
    if (object.environment()) return {};
    auto rest = decode_rest_body(std::as_bytes(std::span(object.rest_body())));
    if (!rest) return rest.error();
    RecordedObject& one = objects_[object.object_id()];
    one.name = object.name();
    const uint32_t revision = rest->revision;
    one.descriptions[revision] = {std::move(*rest), object.asset_hash()};
    return {};
  }

  Result<std::shared_ptr<const GaussianAsset>> asset(const std::string& hash, RecordingReader& recording) {
    auto& known = assets_[hash];
    if (known) return known;
    const auto bytes = recording.asset(hash);
    if (!bytes)
      return not_found("its asset " + shown_line(hash.substr(0, 12)) +
                       " is not in the recording; record with assets (--record-assets)");
    auto decoded = decode_progressive(*bytes);
    if (!decoded) return decoded.error();
    known = std::make_shared<const GaussianAsset>(std::move(*decoded));
    return known;
  }

  std::string fresh_name(const std::string& wanted) {
    std::string name = wanted;
    for (int n = 2; !names_.insert(name).second; ++n) name = wanted + " " + std::to_string(n);
    return name;
  }

  // A body that is only drawn.
  size_t add_drawn(const std::string& name, std::shared_ptr<const GaussianAsset> drawn, const RestBody& rest,
                   v1::Physics::Behavior behavior) {
    PortableBody body;
    body.name = fresh_name(name);
    body.behavior = behavior;
    body.drawn_only = true;
    body.kernel_count = drawn->size();
    body.asset = std::move(drawn);
    body.object_from_asset = rest.object_from_asset;
    if (rest.kind == DriverKind::Lattice) {
      body.elastic.emplace();
      body.elastic->lattice = rest;
    }
    scene_.bodies.push_back(std::move(body));
    return scene_.bodies.size() - 1;
  }

  // Pose of the object's frame for body `index`: the object as if it were whole and moved with that body.
  static Pose object_pose(const Pose& world_from_body, const RestBody& rest, size_t index) {
    return world_from_body * rest.bodies[index].inverse();
  }

  Result<void> check(const RecordedObject& object, const Sample& sample) const {
    const auto found = object.descriptions.find(sample.revision);
    if (found == object.descriptions.end()) return invalid_data("a frame has no description of it");
    const RestBody& rest = found->second.rest;
    const bool fits = rest.kind == DriverKind::Rigid
                          ? !sample.poses.empty() && sample.poses.size() == rest.bodies.size()
                      : rest.kind == DriverKind::Lattice
                          ? !sample.nodes_m.empty() && sample.nodes_m.size() == rest.node_coordinates.size()
                          : false;
    if (!fits && rest.kind == DriverKind::Particles)
      return unsupported("moves by particles (solver livegs-v1); record with the solver cells");
    if (!fits) return invalid_data("a frame does not have the bodies of its description");
    return {};
  }

  Result<void> add(RecordedObject& object, RecordingReader& recording, PortableAnimation& animation) {
    for (const Sample& sample : object.samples) {
      if (auto checked = check(object, sample); !checked) return checked;
    }
    const auto whole = std::find_if(object.samples.begin(), object.samples.end(),
                                    [](const Sample& sample) { return sample.revision > 0; });
    if (whole != object.samples.begin()) {
      if (auto added = add_whole(object, {object.samples.begin(), whole}, recording, animation); !added)
        return added;
    }
    if (whole == object.samples.end()) return {};
    return add_fragments(object, {whole, object.samples.end()}, recording, animation);
  }

  Result<void> add_whole(const RecordedObject& object, std::span<Sample> samples, RecordingReader& recording,
                         PortableAnimation& animation) {
    const RecordedObject::Description& description = object.descriptions.at(0);
    const RestBody& rest = description.rest;
    PortableTrack track;
    const auto in_scene = by_name_.find(object.name);
    if (in_scene != by_name_.end()) {
      track.body = in_scene->second;
      by_name_.erase(in_scene);  // a later object with this name is another one
      const PortableBody& body = scene_.bodies[track.body];
      const size_t nodes = body.elastic ? body.elastic->lattice.node_coordinates.size() : 0;
      if (nodes != rest.node_coordinates.size())
        return invalid_argument("is not the body of the scene; export the scene that was recorded");
    } else {
      auto drawn = asset(description.asset_hash, recording);
      if (!drawn) return drawn.error();
      track.body = add_drawn(object.name, *drawn, rest,
                             rest.kind == DriverKind::Lattice ? v1::Physics::ELASTIC : v1::Physics::RIGID);
    }
    track.first_key = samples.front().key;
    for (Sample& sample : samples) {
      if (rest.kind == DriverKind::Lattice) {
        track.world_from_object.push_back(rigid_fit(rest, sample.nodes_m));
        track.nodes_m.push_back(std::move(sample.nodes_m));
      } else {
        track.world_from_object.push_back(object_pose(sample.poses[0], rest, 0));
      }
    }
    PortableBody& body = scene_.bodies[track.body];
    if (body.drawn_only) body.world_from_object = track.world_from_object[0];
    animation.tracks.push_back(std::move(track));
    return {};
  }

  // The fragments of the last revision, which are parts of those of all earlier ones. In an earlier frame a
  // fragment moves with the body that has its kernels.
  Result<void> add_fragments(const RecordedObject& object, std::span<const Sample> samples,
                             RecordingReader& recording, PortableAnimation& animation) {
    const RecordedObject::Description& last = object.descriptions.at(samples.back().revision);
    auto drawn = asset(last.asset_hash, recording);
    if (!drawn) return drawn.error();
    const GaussianAsset& all = **drawn;
    std::map<uint32_t, std::vector<uint32_t>> body_of_kernel;  // by revision
    for (const Sample& sample : samples) {
      std::vector<uint32_t>& bodies = body_of_kernel[sample.revision];
      if (!bodies.empty()) continue;
      const RestBody& rest = object.descriptions.at(sample.revision).rest;
      for (const RestBody::KernelRun& run : rest.kernel_runs) {
        if (run.body >= rest.bodies.size() || bodies.size() + run.count > all.size())
          return invalid_data("its kernels do not match its fragments");
        bodies.insert(bodies.end(), run.count, run.body);
      }
      if (bodies.size() != all.size()) return invalid_data("its kernels do not match its fragments");
    }
    const std::vector<uint32_t>& final = body_of_kernel.at(samples.back().revision);
    for (uint32_t fragment = 0; fragment < last.rest.bodies.size(); ++fragment) {
      auto part = std::make_shared<GaussianAsset>();
      part->sh_degree = all.sh_degree;
      part->antialiased = all.antialiased;
      std::optional<size_t> first;
      const size_t rest_count = all.sh_rest_count();
      for (size_t i = 0; i < all.size(); ++i) {
        if (final[i] != fragment) continue;
        if (!first) first = i;
        part->positions.push_back(all.positions[i]);
        part->log_scales.push_back(all.log_scales[i]);
        part->rotations.push_back(all.rotations[i]);
        part->opacity_logits.push_back(all.opacity_logits[i]);
        part->sh_dc.push_back(all.sh_dc[i]);
        for (size_t k = 0; k < rest_count; ++k) part->sh_rest.push_back(all.sh_rest[i * rest_count + k]);
      }
      if (!first) continue;  // a fragment inside that nothing shows
      PortableTrack track;
      track.body = add_drawn(object.name + " fragment " + std::to_string(fragment), std::move(part),
                             last.rest, v1::Physics::RIGID);
      track.first_key = samples.front().key;
      for (const Sample& sample : samples) {
        const uint32_t body = body_of_kernel.at(sample.revision)[*first];
        track.world_from_object.push_back(
            object_pose(sample.poses[body], object.descriptions.at(sample.revision).rest, body));
      }
      scene_.bodies[track.body].world_from_object = track.world_from_object[0];
      animation.tracks.push_back(std::move(track));
    }
    return {};
  }

  PortableScene& scene_;
  std::set<std::string> names_;
  std::map<std::string, size_t> by_name_;
  std::map<uint32_t, RecordedObject> objects_;
  std::map<std::string, std::shared_ptr<const GaussianAsset>> assets_;  // by hash
  std::vector<double> times_s_;
  StreamReader reader_;
  int64_t first_ns_ = 0, last_ns_ = 0;
};

}  // namespace

Result<void> collect_recording(const std::filesystem::path& path, PortableScene& scene) {
  auto recording = RecordingReader::open(path);
  if (!recording) return recording.error();
  PortableScene taken = scene;
  Motion motion(taken);
  const auto fail = [&](const Error& error) {
    const Error named{error.code, path.string() + ": " + error.message};
    return error.code == ErrorCode::InvalidData ? with_remedy(named, "copy the recording again") : named;
  };
  for (auto item = recording->next();; item = recording->next()) {
    if (!item) return item.error();
    if (!*item) break;
    const auto done = std::visit([&](auto& one) { return motion.take(one); }, **item);
    if (!done) return fail(done.error());
  }
  if (auto finished = motion.finish(*recording); !finished) return fail(finished.error());
  scene = std::move(taken);
  return {};
}

}  // namespace livegs
