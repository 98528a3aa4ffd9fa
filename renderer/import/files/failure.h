// How reading a file stops or complains: one exception that never leaves this folder, and the collected warnings.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"

#include <string>
#include <string_view>
#include <vector>

namespace kindling::gltf {

// Thrown by the importer's parts, turned into a Result by load_gltf(). The message lacks the file's name.
struct ImportFailure {
  Error error;
};

// The one-line form "pointer: message (CODE)"; CODE is the glTF validator's name for the fault, where it has one.
[[nodiscard]] std::string place_message(std::string_view pointer, std::string_view message, std::string_view code);

[[noreturn]] void fail(std::string_view pointer, std::string_view message, std::string_view code = {},
                       ErrorKind kind = ErrorKind::scene_invalid);

// Text of the file made safe to show: in quotes, control characters escaped, shortened.
[[nodiscard]] std::string in_quotes(std::string_view text);

// Warnings of one piece of work. Of each kind only the first is kept, with the number of its repetitions; of kinds at most 100.
class Warnings {
 public:
  void add(std::string_view kind, std::string_view pointer, std::string_view message, std::string_view code = {});
  void append(const Warnings& other);
  void send(std::string_view file, ProgressListener* listener) const;

 private:
  struct Entry {
    std::string kind;
    std::string message;
    size_t count = 1;
  };
  void add(Entry entry);

  std::vector<Entry> entries_;
  size_t left_out_ = 0;
};

} // namespace kindling::gltf
