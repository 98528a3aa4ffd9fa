// Result<T>: a value, or the one-line error of what the world (files, flags, devices) did wrong.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>

namespace kindling {

// What kind of wrong it was: decides the exit code of the command line.
enum class ErrorKind {
  scene_invalid, // a scene file breaks its specification or needs what is not supported
  input_output,  // a file cannot be read or written, or is not what it claims to be
  usage,         // a flag or option makes no sense
  render_failed, // the render itself could not be done (memory, cancelled build)
};

// One line: the place, what was found and what would be accepted.
struct Error {
  ErrorKind kind = ErrorKind::input_output;
  std::string message;
};

[[nodiscard]] inline Error usage_error(std::string message) { return {ErrorKind::usage, std::move(message)}; }

template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}
  Result(Error error) : error_(std::move(error)) {}

  [[nodiscard]] bool ok() const { return value_.has_value(); }
  explicit operator bool() const { return ok(); }

  [[nodiscard]] T& value() & {
    assert(ok());
    return *value_;
  }
  [[nodiscard]] const T& value() const& {
    assert(ok());
    return *value_;
  }
  [[nodiscard]] T&& value() && {
    assert(ok());
    return *std::move(value_);
  }
  [[nodiscard]] const Error& error() const {
    assert(!ok());
    return error_;
  }

 private:
  std::optional<T> value_;
  Error error_;
};

// The result of an action that yields nothing but success.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}

  [[nodiscard]] bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  [[nodiscard]] const Error& error() const {
    assert(!ok());
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

} // namespace kindling
