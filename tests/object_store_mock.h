// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "test_http_server.h"

namespace livegs {

// An HTTP store on 127.0.0.1: GET with ranges and versions (ETag, If-Range), HEAD and PUT of objects by path,
// and faults on request.
class ObjectStoreMock {
 public:
  // A reply in place of the store's own; nothing: its own. `index`: of the request for this path, from 0 on.
  using Fault = std::function<std::optional<Reply>(const SeenRequest& request, int index)>;

  std::string url() const { return server_.origin(); }

  void set(const std::string& name, std::string bytes) {
    std::lock_guard lock(mutex_);
    objects_["/" + name] = std::move(bytes);
  }
  std::string get(const std::string& name) const {
    std::lock_guard lock(mutex_);
    const auto found = objects_.find("/" + name);
    return found == objects_.end() ? "" : found->second;
  }
  void remove_below(const std::string& folder) {
    std::lock_guard lock(mutex_);
    std::erase_if(objects_, [&](const auto& one) { return one.first.starts_with("/" + folder); });
  }
  std::vector<std::string> names() const {
    std::lock_guard lock(mutex_);
    std::vector<std::string> all;
    for (const auto& [path, bytes] : objects_) all.push_back(path.substr(1));
    return all;
  }
  void set_fault(Fault fault) {
    std::lock_guard lock(mutex_);
    fault_ = std::move(fault);
    counts_.clear();
  }
  void ignore_ranges() { ranges_ = false; }      // before the first request
  void ignore_versions() { versions_ = false; }  // likewise: no If-Range
  // Likewise; milliseconds before each piece of a request's body, of at most 64 KiB.
  void receive_slowly(int pause_ms) { server_.receive_slowly(pause_ms); }
  static std::string etag_of(const std::string& bytes) {
    return '"' + std::to_string(std::hash<std::string>{}(bytes)) + '"';
  }

  std::vector<SeenRequest> requests() const {
    std::lock_guard lock(mutex_);
    return requests_;
  }
  size_t sent_bytes() const {  // of bodies of GET, as far as a fault did not cut them
    std::lock_guard lock(mutex_);
    return sent_bytes_;
  }

 private:
  Reply answer(const SeenRequest& request) {
    std::lock_guard lock(mutex_);
    requests_.push_back(request);
    if (fault_) {
      if (auto reply = fault_(request, counts_[request.path]++)) return *std::move(reply);
    }
    Reply reply;
    reply.content_type = "application/octet-stream";
    reply.keep_alive = true;
    if (request.method == "PUT") {
      objects_[request.path] = request.body;
      return reply;
    }
    const auto found = objects_.find(request.path);
    if (found == objects_.end()) {
      reply.status = 404;
      return reply;
    }
    const std::string& bytes = found->second;
    const std::string etag = etag_of(bytes);
    reply.headers.push_back("ETag: " + etag);
    const size_t range = request.head.find("\r\nRange: bytes=");
    const bool other_version = versions_ && request.head.find("If-Range: ") != std::string::npos &&
                               request.head.find("If-Range: " + etag) == std::string::npos;
    if (range == std::string::npos || !ranges_ || other_version) {
      reply.body = bytes;
    } else {
      const size_t from = std::strtoull(request.head.c_str() + range + 15, nullptr, 10);
      if (from >= bytes.size()) {
        reply.status = 416;
        reply.headers.push_back("Content-Range: bytes */" + std::to_string(bytes.size()));
        return reply;
      }
      reply.status = 206;
      reply.body = bytes.substr(from);
      reply.headers.push_back("Content-Range: bytes " + std::to_string(from) + "-" +
                              std::to_string(bytes.size() - 1) + "/" + std::to_string(bytes.size()));
    }
    if (request.method == "GET") sent_bytes_ += reply.body.size();
    return reply;
  }

  mutable std::mutex mutex_;  // guards everything but the server
  std::map<std::string, std::string> objects_;
  std::map<std::string, int> counts_;
  std::vector<SeenRequest> requests_;
  Fault fault_;
  bool ranges_ = true, versions_ = true;
  size_t sent_bytes_ = 0;
  TestHttpServer server_{[this](const SeenRequest& request) { return answer(request); }};
};

}  // namespace livegs
