// SPDX-License-Identifier: GPL-3.0-or-later
#include "baseline/elastic_solvers.h"
#include "livegs/v1/recording.pb.h"
#include "scene/scene.h"

namespace livegs {

v1::SceneSource Scene::source() const {
  v1::SceneSource source;
  source.set_name(name_);
  source.set_folder(std::filesystem::absolute(folder_.empty() ? "." : folder_).lexically_normal().string());
  *source.mutable_file() = built_file_;
  if (options_.rate_hz) source.set_rate_hz(*options_.rate_hz);
  if (options_.substeps) source.set_substeps(*options_.substeps);
  source.set_seed(options_.seed);
  source.set_sleep(options_.sleep);
  for (const auto& [name, make] : elastic_solvers()) {
    if (make == options_.make_elastic) source.set_elastic_solver(name);
  }
  source.set_cut_fragile(options_.cut_fragile);
  source.set_waited_for_pieces(options_.wait_for_pieces);
  source.set_first_object_id(options_.first_object_id);
  for (const SceneObject& object : objects_) {
    if (object.sidecar) (*source.mutable_sidecars())[object.name] = *object.sidecar;
  }
  return source;
}

Result<Scene> Scene::build_again(const v1::SceneSource& source, const std::filesystem::path& folder) {
  SceneOptions options;
  if (source.has_rate_hz()) options.rate_hz = source.rate_hz();
  if (source.has_substeps()) options.substeps = source.substeps();
  const auto solver = elastic_solvers().find(source.elastic_solver());
  if (solver == elastic_solvers().end())
    return unsupported("elastic solver \"" + source.elastic_solver() + "\": not supported by this version");
  options.make_elastic = solver->second;
  options.seed = source.seed();
  options.sleep = source.sleep();
  options.cut_fragile = source.cut_fragile();
  options.wait_for_pieces = source.waited_for_pieces();
  options.first_object_id = source.first_object_id();
  options.recorded_cuts = true;
  options.sidecars = std::make_shared<const std::map<std::string, v1::PhysicsFile>>(source.sidecars().begin(),
                                                                                    source.sidecars().end());
  return build(source.file(), folder, source.name(), options);
}

}  // namespace livegs
