// A thin layer over CLI11, whose headers it keeps to itself: each flag has one parser that returns a Result, and a wrapped help text.
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
  // `program` as the help names it: "kindling render".
  FlagSet(const std::string& description, const std::string& program);
  ~FlagSet();
  FlagSet(FlagSet&& other) noexcept;

  // The text behind the command's name in the help: what it works on in the first line, explanations in others.
  void usage(const std::string& text) { usage_ = text; }

  // The heading in the help of the flags that follow.
  void group(std::string name) { group_ = std::move(name); }

  // Of the flags that follow only those of these long names are declared, for a command that takes some of another's; {}: all.
  void only(std::vector<std::string> long_names) { only_ = std::move(long_names); }

  // `parse` gets the value's text; its error becomes "NAME: ERROR". A flag given twice counts as given last.
  // `label` stands for the value in the help; `description` has unit and default.
  void value(const std::string& name, const std::string& label, const std::string& description,
             std::function<Result<void>(std::string_view)> parse);
  // The same for a flag that adds up: `parse` is called for each use.
  void repeated(const std::string& name, const std::string& label, const std::string& description,
                std::function<Result<void>(std::string_view)> parse);
  void toggle(const std::string& name, const std::string& description, std::function<void()> when_given);
  void toggle(const std::string& name, const std::string& description, bool& target, bool value = true);

  // False for one that is not declared.
  [[nodiscard]] bool given(const std::string& name) const;

  // What the command works on: one word, or several.
  void operand(const std::string& name, std::string& word);
  void operand(const std::string& name, std::vector<std::string>& words);

  // Once all flags are declared: calls their parsers. True if help was asked for; fails (usage).
  [[nodiscard]] Result<bool> parse(std::span<const char* const> arguments);
  // After parse(): what was typed and nothing declared.
  [[nodiscard]] std::vector<std::string> extras() const;
  [[nodiscard]] std::string help() const;

  // Every flag's long name, for suggestions.
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

// Store what `parse` made of the text, or hand its error on.
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
