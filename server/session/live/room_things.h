// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/result.h"
#include "gaussian/asset_frame.h"
#include "livegs/v1/author.pb.h"
#include "livegs/v1/scene.pb.h"
#include "parts/click/kernel_graph.h"
#include "parts/labelled_room.h"
#include "parts/room_solids.h"

namespace livegs {

// The things of a captured room that authors can take out. They are found on an internal thread
// (parts/room_parts.h), or read from the labels that an earlier take wrote next to the scene.
class RoomThings {
 public:
  explicit RoomThings(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ~RoomThings();  // stops the search

  // State for the environment of a scene. Begins the search if there was none for its asset. Any thread.
  v1::RoomParts describe(const v1::Environment& environment);

  struct Thing {
    std::vector<uint16_t> labels;  // more than one: they become one thing
    uint32_t kernels = 0;          // their number
    // Those of the thing, if rays cut it out of its labels or across their borders; else empty. Indices in
    // the labelled room.
    std::vector<uint32_t> cut;
    Eigen::AlignedBox3d bounds_m;  // world frame
  };
  // The thing that the rays hit. Unavailable while the room is prepared. The thread of edits only.
  Result<Thing> under(const v1::TakePartRequest& request, const v1::Environment& environment);

  struct Taken {
    v1::Environment environment;  // with the thing left out
    v1::Object object;            // without name
  };
  // Writes the labels and the thing's asset into the scene's folder. The thread of edits only.
  Result<Taken> take(const Thing& thing, const v1::Environment& environment);
  // The environment including the thing again. Unavailable while the room is prepared.
  Result<v1::Environment> put_back(uint32_t label, v1::Environment environment);

  static constexpr int kMaxRays = 32;

 private:
  struct Known {
    Eigen::AlignedBox3d bounds;  // asset frame
    uint32_t kernels = 0;
  };
  struct Room {
    LabelledRoom labelled;
    std::map<uint16_t, Known> things;
    std::string labels_file;  // in the folder; empty: not written yet
    std::shared_ptr<const KernelGraph> graph;
  };
  void search(std::stop_token stop, const v1::Environment& environment);
  std::shared_ptr<const Room> room_for(const v1::Environment& environment) const;
  static Room room_of(LabelledRoom labelled, std::string labels_file,
                      std::shared_ptr<const KernelGraph> graph);
  // The thing's kernels get a label of their own, those of its fill and underside by their nearest kernels.
  static uint16_t divide(LabelledRoom& labelled, const Thing& thing);
  // The room that rays meet; kept for the next rays.
  struct Shown {
    std::shared_ptr<const Room> room;
    std::vector<uint32_t> taken, kept;
    GaussianAsset asset;
  };
  // Colliders of a room from which things are taken: its planes, and a box around each thing that is in it.
  // The field of the whole room, Environment.collide, is too coarse to stand on and has the things in it.
  void collide(const Room& room, v1::Environment& environment) const;
  v1::Collider box_around(const Known& thing, const v1::Environment& environment) const;
  const Shown& shown(std::shared_ptr<const Room> room, const v1::Environment& environment);

  // Axis and unit of the room (environment_frame.h). The file is read when it changes. Any thread.
  AssetFrame frame_of(const v1::Environment& environment) const;

  const std::filesystem::path folder_;
  mutable std::mutex frame_mutex_;  // guards the next two
  mutable std::string frame_stamp_;
  mutable AssetFrame named_frame_;  // of the asset
  std::mutex starting_;             // guards thread_; taken before mutex_
  mutable std::mutex mutex_;        // guards the members down to failed_
  std::string asset_;               // of the rooms
  // By file of labels; "": results of a search.
  std::map<std::string, std::shared_ptr<const Room>> rooms_;
  std::vector<RoomSolid> solids_;         // of the search; empty before it
  std::optional<std::string> searching_;  // file of labels of the current search or reading
  double progress_ = 0;
  std::optional<std::pair<std::string, std::string>> failed_;  // file of labels, reason
  Shown shown_;                                                // not guarded: the thread of edits
  std::jthread thread_;                                        // last: uses all members above
};

}  // namespace livegs
