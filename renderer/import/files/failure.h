// The importer's errors, thrown as one exception type, and its collected warnings.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"

#include <string>
#include <string_view>
#include <vector>

namespace kindling::gltf {

// Thrown by the importer's parts and converted to a Result by load_gltf(). The message lacks the
// file's name.
struct ImportFailure {
  Error error;
};

// The file needs more than ImportLimits permit. Never repaired: what is left out would not be the
// only thing too large.
struct BudgetFailure : ImportFailure {};

// Returns "pointer: message (CODE)"; CODE is the glTF validator's name for the fault, where it has
// one.
[[nodiscard]] std::string place_message(std::string_view pointer, std::string_view message, std::string_view code);

// Returns the code at the end of the message; empty if there is none.
[[nodiscard]] std::string_view code_of(const ImportFailure& failure);

[[noreturn]] void fail(std::string_view pointer, std::string_view message, std::string_view code = {},
                       ErrorKind kind = ErrorKind::scene_invalid);

// Returns text of the file in quotes, safe to print: control characters escaped, at most 80 bytes.
[[nodiscard]] std::string in_quotes(std::string_view text);

// Findings of one piece of work: warnings, and faults that an image survives. Only the first of
// each kind is stored, with a count of the others; at most 100 kinds are stored.
class Warnings {
 public:
  // Strict: repair() throws the fault, as a validator refuses the file.
  explicit Warnings(bool strict = false) : strict_(strict) {}
  [[nodiscard]] bool strict() const { return strict_; }

  // A remark about a valid file, or about values that are repaired in strict loads too.
  void add(std::string_view kind, std::string_view pointer, std::string_view message, std::string_view code = {});
  // A fault of the file, and the remedy with which it is read all the same: "the channel is
  // ignored". Throws the fault as an ImportFailure if strict.
  void repair(std::string_view kind, const ImportFailure& fault, std::string_view remedy);
  void repair(std::string_view kind, std::string_view pointer, std::string_view message, std::string_view code,
              std::string_view remedy);
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
  bool strict_ = false;
};

} // namespace kindling::gltf
