// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "core/result.h"
#include "livegs/v1/author.pb.h"

namespace livegs {

// Editing of a running scene by clients. Any thread. Calls that build objects return at once and answer
// later, on a thread of their own and in the order of the calls.
class AuthorControl {
 public:
  virtual ~AuthorControl() = default;
  template <class Reply>
  using Answer = std::function<void(Result<Reply>)>;
  virtual void edit(v1::EditSceneRequest request, Answer<v1::EditSceneReply> answer) = 0;
  virtual void undo(bool redo, Answer<v1::EditSceneReply> answer) = 0;
  virtual void save(v1::SaveSceneRequest request, Answer<v1::SaveSceneReply> answer) = 0;
  virtual Result<void> carry(const v1::CarryObjectRequest& request) = 0;
  virtual v1::SceneDocument document() = 0;
  virtual v1::ListAssetsReply assets() = 0;
  // Things of a captured room. The first call of room_parts() begins to find them.
  virtual v1::RoomParts room_parts() = 0;
  virtual void take_part(v1::TakePartRequest request, Answer<v1::TakePartReply> answer) = 0;
  virtual void put_back(const std::string& object, Answer<v1::EditSceneReply> answer) = 0;
  // A revision of an object's sidecar, made by a user: becomes a step of the log.
  virtual void note_physics(const std::string& object) = 0;

  // A file that a client sends: begin, then its bytes, then finish. Without finish nothing is kept.
  class Upload {
   public:
    virtual ~Upload() = default;
    virtual Result<void> add(std::span<const std::byte> bytes) = 0;
    virtual Result<std::string> finish() = 0;  // its path as Object.asset
  };
  virtual Result<std::unique_ptr<Upload>> upload(const std::string& name) = 0;
};

}  // namespace livegs
