// A thin layer over CLI11: each flag has one parser that returns a Result, and a wrapped help text.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <CLI/CLI.hpp>

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kindling::app {

class FlagSet {
 public:
  explicit FlagSet(CLI::App& app);

  // The heading in the help of the flags that follow.
  void group(std::string name) { group_ = std::move(name); }

  // `parse` gets the value's text; its error becomes "NAME: ERROR". A flag given twice counts as given last.
  // `label` stands for the value in the help; `description` has unit and default.
  void value(const std::string& name, const std::string& label, const std::string& description,
             std::function<Result<void>(std::string_view)> parse);
  // The same for a flag that adds up: `parse` is called for each use.
  void repeated(const std::string& name, const std::string& label, const std::string& description,
                std::function<Result<void>(std::string_view)> parse);
  void toggle(const std::string& name, const std::string& description, std::function<void()> when_given);
  void toggle(const std::string& name, const std::string& description, bool& target, bool value = true);

  [[nodiscard]] bool given(const std::string& name) const { return app_.get_option(name)->count() > 0; }
  // Every flag's long name, for suggestions.
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  CLI::App& app_;
  std::string group_;
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
