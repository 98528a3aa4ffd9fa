// CLI11 behind FlagSet, with the layout of the help text.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/flag_set.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <memory>

namespace kindling::app {

namespace {

constexpr size_t kNameColumn = 34;
constexpr size_t kHelpWidth = 110;
constexpr const char* kUsageLabel = "Usage";

// Breaks the description at spaces; the formatter indents the lines after the first.
std::string wrap(const std::string& text) {
  constexpr size_t kWidth = kHelpWidth - kNameColumn;
  std::string wrapped;
  size_t column = 0;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find(' ', begin), text.size());
    const size_t length = end - begin;
    if (column > 0) {
      const bool fits = column + 1 + length <= kWidth;
      wrapped += fits ? ' ' : '\n';
      column = fits ? column + 1 : 0;
    }
    wrapped.append(text, begin, length);
    column += length;
    begin = end + 1;
  }
  return wrapped;
}

// Writes "Usage:" with the operands as a person types them, and no section for positional
// arguments.
class HelpFormatter final : public CLI::Formatter {
 public:
  std::string make_usage(const CLI::App*, std::string name) const override {
    return "\nUsage: " + name + " " + get_label(kUsageLabel) + "\n\n";
  }
  std::string make_positionals(const CLI::App*) const override { return {}; }
  std::string make_group(std::string group, bool positional, std::vector<const CLI::Option*> options) const override {
    const std::string text = CLI::Formatter::make_group(std::move(group), positional, std::move(options));
    const size_t begin = std::min(text.find_first_not_of('\n'), text.size());
    return text.substr(begin, text.find_last_not_of('\n') + 1 - begin) + "\n";
  }
};

// CLI11 turns this exception into its own control flow; parse() turns it into an Error.
void require(const Result<void>& parsed, const std::string& flag) {
  if (!parsed.ok()) throw CLI::ValidationError(flag, parsed.error().message);
}

// "-o,--output" is shown and reported as "--output".
std::string long_name(const std::string& names) {
  const size_t at = names.find("--");
  return at == std::string::npos ? names : names.substr(at);
}

} // namespace

FlagSet::FlagSet(const std::string& description, const std::string& program)
    : app_(std::make_unique<CLI::App>(description, program)) {
  app_->set_help_flag();
  app_->formatter(std::make_shared<HelpFormatter>());
  app_->get_formatter()->column_width(kNameColumn);
  app_->allow_extras(); // reported by us, with a suggestion
}

FlagSet::~FlagSet() = default;
FlagSet::FlagSet(FlagSet&& other) noexcept = default;

bool FlagSet::wanted(const std::string& names) const {
  return only_.empty() || std::find(only_.begin(), only_.end(), long_name(names)) != only_.end();
}

void FlagSet::value(const std::string& name, const std::string& label, const std::string& description,
                    std::function<Result<void>(std::string_view)> parse) {
  if (!wanted(name)) return;
  app_->add_option_function<std::string>(
          name,
          [parse = std::move(parse), flag = long_name(name)](const std::string& text) { require(parse(text), flag); },
          wrap(description))
      ->option_text(label)
      ->group(group_)
      ->take_last();
}

void FlagSet::repeated(const std::string& name, const std::string& label, const std::string& description,
                       std::function<Result<void>(std::string_view)> parse) {
  if (!wanted(name)) return;
  app_->add_option_function<std::vector<std::string>>(
          name,
          [parse = std::move(parse), flag = long_name(name)](const std::vector<std::string>& texts) {
            for (const std::string& text : texts) require(parse(text), flag);
          },
          wrap(description))
      ->option_text(label)
      ->group(group_)
      ->take_all()
      ->allow_extra_args(false);
}

void FlagSet::toggle(const std::string& name, const std::string& description, std::function<void()> when_given) {
  if (!wanted(name)) return;
  app_->add_flag_callback(name, std::move(when_given), wrap(description))->group(group_);
}

void FlagSet::toggle(const std::string& name, const std::string& description, bool& target, bool value) {
  toggle(name, description, [&target, value] { target = value; });
}

bool FlagSet::given(const std::string& name) const {
  const CLI::Option* option = app_->get_option_no_throw(name);
  return option != nullptr && option->count() > 0;
}

std::vector<std::string> FlagSet::given_words(const std::vector<std::string>& except) const {
  std::vector<std::string> words;
  for (const CLI::Option* option : app_->get_options()) {
    if (option->count() == 0 || option->get_lnames().empty()) continue;
    const std::string name = "--" + option->get_lnames().front();
    if (std::find(except.begin(), except.end(), name) != except.end()) continue;
    if (option->get_items_expected_max() == 0) { // takes no value
      words.push_back(name);
      continue;
    }
    const bool adds_up = option->get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
    const std::vector<std::string>& values = option->results();
    for (size_t i = adds_up ? 0 : values.size() - 1; i < values.size(); ++i) {
      if (values[i].starts_with('-')) { // which would be read as a flag
        words.push_back(name + "=" + values[i]);
        continue;
      }
      words.push_back(name);
      words.push_back(values[i]);
    }
  }
  return words;
}

void FlagSet::operand(const std::string& name, std::string& word) { app_->add_option(name, word); }
void FlagSet::operand(const std::string& name, std::vector<std::string>& words) { app_->add_option(name, words); }

Result<bool> FlagSet::parse(std::span<const char* const> arguments) {
  app_->get_formatter()->label(kUsageLabel, usage_);
  app_->set_help_flag("-h,--help", "Print this text")->group("Reports");
  try {
    std::vector<std::string> reversed(arguments.rbegin(), arguments.rend()); // CLI11 wants the last one first
    app_->parse(std::move(reversed));
  } catch (const CLI::CallForHelp&) {
    return true;
  } catch (const CLI::ArgumentMismatch& error) {
    const std::string_view what = error.what();
    return usage_error(fmt::format("{}: needs a value", what.substr(0, what.find(':'))));
  } catch (const CLI::ParseError& error) {
    return usage_error(error.what());
  }
  return false;
}

CommandTable FlagSet::table() const {
  CommandTable table;
  table.name = app_->get_name();
  table.usage = usage_.substr(0, usage_.find('\n'));
  table.description = app_->get_description();
  for (const std::string& group : app_->get_groups())
    for (const CLI::Option* option : app_->get_options()) {
      if (option->get_group() != group || option->get_lnames().empty()) continue;
      FlagRow row;
      row.short_name = option->get_snames().empty() ? "" : "-" + option->get_snames().front();
      row.long_name = "--" + option->get_lnames().front();
      row.label = option->get_items_expected_max() > 0 ? option->get_option_text() : "";
      row.description = option->get_description();
      std::replace(row.description.begin(), row.description.end(), '\n', ' ');
      row.group = group;
      table.flags.push_back(std::move(row));
    }
  return table;
}

std::vector<std::string> FlagSet::extras() const { return app_->remaining(); }
std::string FlagSet::help() const { return app_->help(); }

std::vector<std::string> FlagSet::names() const {
  std::vector<std::string> names;
  for (const CLI::Option* option : app_->get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

} // namespace kindling::app
