// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "compute/backend.h"

namespace livegs::test {

// Runs every dispatch on two backends and compares all of its buffers. The second continues with the result
// of the first, so that each comparison is of one pass only.
class ComparingBackend final : public Backend {
 public:
  ComparingBackend(Backend& first, Backend& second) : first_(first), second_(second) {}

  Result<BufferId> create_buffer(size_t bytes) override {
    auto one = first_.create_buffer(bytes);
    auto other = second_.create_buffer(bytes);
    if (!one || !other) return one ? other.error() : one.error();
    // Undefined content would be compared.
    const std::vector<std::byte> zero(bytes);
    if (auto done = first_.upload(*one, zero); !done) return done.error();
    if (auto done = second_.upload(*other, zero); !done) return done.error();
    const BufferId id{++last_};
    buffers_[id] = {*one, *other, bytes};
    return id;
  }
  Result<void> destroy_buffer(BufferId id) override {
    const Pair pair = buffers_.at(id);
    buffers_.erase(id);
    if (auto done = first_.destroy_buffer(pair.first); !done) return done;
    return second_.destroy_buffer(pair.second);
  }
  Result<void> upload(BufferId id, std::span<const std::byte> bytes) override {
    if (auto done = first_.upload(buffers_.at(id).first, bytes); !done) return done;
    return second_.upload(buffers_.at(id).second, bytes);
  }
  Result<void> dispatch(const Pass& pass, std::span<const BufferId> ids, std::span<const std::byte> constants,
                        uint32_t count) override {
    std::vector<BufferId> ones, others;
    for (const BufferId id : ids) {
      ones.push_back(buffers_.at(id).first);
      others.push_back(buffers_.at(id).second);
    }
    if (auto done = first_.dispatch(pass, ones, constants, count); !done) return done;
    if (auto done = second_.dispatch(pass, others, constants, count); !done) return done;
    ++compared_[std::string(pass.name)];
    for (size_t b = 0; b < ids.size(); ++b) {
      const size_t bytes = buffers_.at(ids[b]).bytes;
      std::vector<float> one(bytes / 4), other(bytes / 4);
      if (auto done = first_.read(ones[b], std::as_writable_bytes(std::span(one))); !done) return done;
      if (auto done = second_.read(others[b], std::as_writable_bytes(std::span(other))); !done) return done;
      compare(std::string(pass.name), b, one, other);
      if (auto done = second_.upload(others[b], std::as_bytes(std::span(one))); !done) return done;
    }
    return {};
  }
  Result<void> submit() override { return second_.submit(); }
  Result<void> read(BufferId id, std::span<std::byte> bytes) override {
    return first_.read(buffers_.at(id).first, bytes);
  }

  const std::map<std::string, int>& compared() const { return compared_; }

 private:
  struct Pair {
    BufferId first, second;
    size_t bytes;
  };
  // A few rounding errors of the operands: lengths of centimetres with steps of 4e-9 m; spins and momenta of
  // the ledger, which are differences of numbers of order one.
  static void compare(const std::string& pass, size_t binding, const std::vector<float>& one,
                      const std::vector<float>& other) {
    const float step = pass == "elastic_ledger" ? 2e-6f : 1e-7f;
    for (size_t i = 0; i < one.size(); ++i) {
      if (std::memcmp(&one[i], &other[i], 4) == 0) continue;
      ASSERT_LE(std::abs(one[i] - other[i]), 2e-5f * std::abs(one[i]) + step)
          << pass << ", binding " << binding << ", word " << i;
    }
  }
  Backend &first_, &second_;
  std::map<BufferId, Pair> buffers_;
  std::map<std::string, int> compared_;
  uint64_t last_ = 0;
};

}  // namespace livegs::test
