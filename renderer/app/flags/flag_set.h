// A thin layer over CLI11: each flag has one parser that returns a Result, and a wrapped help text.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/flag_table.h"
#include "renderer/base/result.h"

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace CLI {
class App;
} // namespace CLI

namespace kindling::app {

class FlagSet {
 public:
  // `program` is the name in the help: "kindling render".
  FlagSet(const std::string& description, const std::string& program);
  ~FlagSet();
  FlagSet(FlagSet&& other) noexcept;

  // Sets the text after the command's name in the help: its operands in the first line,
  // explanations in the others.
  void usage(const std::string& text) { usage_ = text; }

  // Sets the heading in the help for the flags that follow.
  void group(std::string name) { group_ = std::move(name); }

  // Limits the flags that follow to those of these long names, for a command that takes some flags
  // of another one; {} lifts it.
  void only(std::vector<std::string> long_names) { only_ = std::move(long_names); }

  // Declares a flag with a value. `parse` gets the value's text; its error becomes "NAME: ERROR".
  // The last use of a flag counts. `label` names the value in the help; `description` has its unit
  // and default.
  void value(const std::string& name, const std::string& label, const std::string& description,
             std::function<Result<void>(std::string_view)> parse);
  // The same for a flag that may be given several times: `parse` is called for each use.
  void repeated(const std::string& name, const std::string& label, const std::string& description,
                std::function<Result<void>(std::string_view)> parse);
  void toggle(const std::string& name, const std::string& description, std::function<void()> when_given);
  void toggle(const std::string& name, const std::string& description, bool& target, bool value = true);

  // True if the flag was given; false if it is not declared.
  [[nodiscard]] bool given(const std::string& name) const;

  // After parse(): the flags that were given, except for these long names, as words that give the
  // same options: "--env", "sky.hdr".
  [[nodiscard]] std::vector<std::string> given_words(const std::vector<std::string>& except) const;

  // Declares the operand of the command: one word, or several.
  void operand(const std::string& name, std::string& word);
  void operand(const std::string& name, std::vector<std::string>& words);

  // Calls the parsers of all flags that were given. Returns true if help was asked for; fails
  // (usage). Declare all flags before.
  [[nodiscard]] Result<bool> parse(std::span<const char* const> arguments);
  // After parse(): the words that belong to no declared flag or operand.
  [[nodiscard]] std::vector<std::string> extras() const;
  [[nodiscard]] std::string help() const;

  // The long names of all flags, for suggestions.
  [[nodiscard]] std::vector<std::string> names() const;
  // The flags in the order of the help, --help included.
  [[nodiscard]] CommandTable table() const;

 private:
  [[nodiscard]] bool wanted(const std::string& names) const;

  std::unique_ptr<CLI::App> app_;
  std::string usage_;
  std::string group_;
  std::vector<std::string> only_; // empty: all
};

// Stores the parsed value in `target`, or returns the error.
template <typename Target, typename Parsed>
Result<void> store(Result<Parsed> parsed, Target& target) {
  if (!parsed.ok()) return parsed.error();
  target = static_cast<Target>(std::move(parsed).value());
  return {};
}
template <typename Target, typename Parsed>
Result<void> store(Result<Parsed> parsed, std::optional<Target>& target) {
  if (!parsed.ok()) return parsed.error();
  target = static_cast<Target>(std::move(parsed).value());
  return {};
}

} // namespace kindling::app
