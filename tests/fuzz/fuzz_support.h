// Helpers of the harnesses: files in a folder of their own, and checks of what a reader returns.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace kindling::fuzz {

using Bytes = std::span<const std::byte>;

// Returns libFuzzer's input.
[[nodiscard]] inline Bytes input_bytes(const uint8_t* data, size_t size) {
  return std::as_bytes(std::span(data, size));
}
[[nodiscard]] inline std::string_view input_text(const uint8_t* data, size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

// TBB runs everything on the calling thread from now on, so that an input has the same coverage
// every time. Called by LLVMFuzzerInitialize().
void use_one_thread();

// A folder in $TMPDIR, removed when the process ends in order. Readers that take a path get their
// input from it; a $TMPDIR in memory makes that fast.
class InputFolder {
 public:
  InputFolder();
  ~InputFolder();
  InputFolder(const InputFolder&) = delete;
  InputFolder& operator=(const InputFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  // Writes the file, replacing what it holds, and returns its path.
  std::filesystem::path write(const std::filesystem::path& name, Bytes bytes) const;
  std::filesystem::path write(const std::filesystem::path& name, std::string_view text) const {
    return write(name, std::as_bytes(std::span(text)));
  }

 private:
  std::filesystem::path path_;
};

// Ends the process, as a finding, unless the condition holds.
void require(bool condition, const char* what);
// Requires an error to be one line of text that names the file.
void require_good_message(const Error& error, std::string_view named = {});

} // namespace kindling::fuzz
