// Result<T>: a value, or a one-line error caused from outside (files, flags, devices).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>

namespace kindling {

// The kind of an error; determines the exit code of the command line.
enum class ErrorKind {
  scene_invalid, // a scene file violates its specification or needs an unsupported feature
  input_output,  // a file cannot be read or written, or does not have the claimed format
  usage,         // an invalid flag or option
  render_failed, // the render failed (memory, cancelled build)
};

// An error with a one-line message: the place, the value found and the accepted values.
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

// The result of an operation without a value.
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
