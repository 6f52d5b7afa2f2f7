// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>
#include <variant>

// A value or an Error: the result of a call on the outside world (files, network, devices, users). The
// interface is that of std::expected, which g++ 12 offers only in C++23; a later change is an alias.

namespace livegs {

enum class ErrorCode {
  InvalidArgument,  // the input of the caller or the user is wrong
  InvalidData,      // a file or message violates its format
  NotFound,
  Unsupported,  // well-formed, but not handled by this build
  TooLarge,     // over a stated limit
  Unavailable,  // a peer or a device is missing
  PermissionDenied,
  Internal,
};

// The message is one line: the object, the problem and, if there is one, the remedy: "cushion.ply: element
// vertex has no property opacity; give a Gaussian splat file"
struct Error {
  ErrorCode code = ErrorCode::Internal;
  std::string message;
};

inline Error invalid_argument(std::string message) {
  return {ErrorCode::InvalidArgument, std::move(message)};
}
inline Error invalid_data(std::string message) { return {ErrorCode::InvalidData, std::move(message)}; }
inline Error not_found(std::string message) { return {ErrorCode::NotFound, std::move(message)}; }
inline Error unsupported(std::string message) { return {ErrorCode::Unsupported, std::move(message)}; }

// The error with a remedy at the end of its line, unless the line has one already (after "; ").
inline Error with_remedy(Error error, const std::string& remedy) {
  if (error.message.find("; ") == std::string::npos) error.message += "; " + remedy;
  return error;
}

namespace detail {
[[noreturn]] inline void bad_result_access(const char* message) {
  std::fprintf(stderr, "livegs: value() of a failed Result: %s\n", message);
  std::abort();
}
}  // namespace detail

template <class T>
class [[nodiscard]] Result {
 public:
  using value_type = T;

  Result(T value)
      : state_(std::in_place_index<0>, std::move(value)) {}  // NOLINT: implicit like std::expected
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT

  bool has_value() const { return state_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  T& value() & { return require(), *std::get_if<0>(&state_); }
  const T& value() const& { return require(), *std::get_if<0>(&state_); }
  T&& value() && { return require(), std::move(*std::get_if<0>(&state_)); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  // Precondition: !has_value().
  const Error& error() const { return *std::get_if<1>(&state_); }

 private:
  void require() const {
    if (!has_value()) detail::bad_result_access(error().message.c_str());
  }
  std::variant<T, Error> state_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  using value_type = void;

  Result() = default;
  Result(Error error) : error_(std::move(error)) {}  // NOLINT: implicit like std::expected

  bool has_value() const { return !error_; }
  explicit operator bool() const { return has_value(); }
  void value() const {
    if (error_) detail::bad_result_access(error_->message.c_str());
  }
  const Error& error() const { return *error_; }

 private:
  std::optional<Error> error_;
};

}  // namespace livegs
