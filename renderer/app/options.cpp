// From arguments to a command and its options.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/options.h"

#include "renderer/app/flag_set.h"
#include "renderer/app/parse_values.h"
#include "renderer/app/text_format.h"
#include "renderer/app/version.h"

#include <fmt/format.h>

#include <algorithm>

namespace kindling::app {

namespace {

constexpr std::string_view kHelp =
    R"(kindling {}: a path tracer for glTF 2.0 scenes

Usage:
  kindling render SCENE [-o FILE]... [flags]   render a .gltf or .glb file to PNG and EXR
  kindling info SCENE [flags]                  print what is in a file
  kindling shootout SCENE... [flags]           race the accelerators on the scenes' own rays
  kindling info --list-extensions              print the glTF extensions that are understood
  kindling COMMAND --help                      all flags of a command
  kindling --version                           version, compiler and libraries

Exit codes: 0 done, 1 render failed, 2 wrong usage, 3 scene invalid, 4 a file cannot be read or written,
130 and 143 interrupted (the images are written). Results go to standard output, all else to standard error.
)";

Error usage_error(std::string message) { return {ErrorKind::usage, std::move(message)}; }

// What was typed and nothing declared.
std::string describe_extra(const std::string& word, const FlagSet& flags, bool scene_given) {
  if (word.starts_with('-') && word.size() > 1) {
    const std::string name = word.substr(0, word.find('='));
    const std::string nearest = nearest_name(name, flags.names());
    return nearest.empty() ? fmt::format("unknown flag '{}'", name)
                           : fmt::format("unknown flag '{}'; did you mean {}?", name, nearest);
  }
  return fmt::format("unexpected argument '{}'{}", word, scene_given ? "; there can be one SCENE" : "");
}

// Parses the flags of one command; a text if --help was among them.
template <typename Options>
Result<std::optional<PrintText>> parse_command(std::span<const char* const> arguments, const std::string& command,
                                               const std::string& description, Options& options,
                                               void (*add_flags)(FlagSet&, Options&)) {
  CLI::App app(description, "kindling " + command);
  app.set_help_flag();
  FlagSet flags(app);
  constexpr bool kSeveralScenes = std::is_same_v<Options, ShootoutOptions>;
  std::conditional_t<kSeveralScenes, std::vector<std::string>, std::string> scene;
  add_flags(flags, options);
  app.add_option("SCENE", scene);
  app.set_help_flag("-h,--help", "Print this text")->group("Reports");
  try {
    std::vector<std::string> reversed(arguments.rbegin(), arguments.rend()); // CLI11 wants the last one first
    app.parse(std::move(reversed));
  } catch (const CLI::CallForHelp&) {
    return std::optional<PrintText>(PrintText{app.help()});
  } catch (const CLI::ArgumentMismatch& error) {
    const std::string_view what = error.what();
    return usage_error(fmt::format("{}: needs a value", what.substr(0, what.find(':'))));
  } catch (const CLI::ParseError& error) {
    return usage_error(error.what());
  }
  if (const std::vector<std::string> extras = app.remaining(); !extras.empty())
    return usage_error(describe_extra(extras.front(), flags, !scene.empty()));
  if constexpr (kSeveralScenes)
    options.scene_files.assign(scene.begin(), scene.end());
  else
    options.scene_file = scene;
  Result<void> checked = [&] {
    if constexpr (std::is_same_v<Options, RenderOptions>)
      return check_render_flags(flags, options);
    else if constexpr (kSeveralScenes)
      return check_shootout_flags(flags, options);
    else
      return check_info_flags(flags, options);
  }();
  if (!checked.ok()) return checked.error();
  return std::optional<PrintText>();
}

} // namespace

Result<CommandLine> parse_command_line(std::span<const char* const> arguments) {
  CommandLine line;
  line.text = "kindling";
  for (const char* argument : arguments) line.text += ' ' + shell_quote(argument);

  if (arguments.empty()) return usage_error("no command; use render, info or shootout");
  const std::string_view command = arguments.front();
  const auto rest = arguments.subspan(1);
  if (command == "--help" || command == "-h" || command == "help") {
    line.command = PrintText{fmt::format(fmt::runtime(kHelp), version())};
    return line;
  }
  if (command == "--version" || command == "-V") {
    line.command = PrintText{version_text()};
    return line;
  }
  const auto take = [&](auto options, const char* description, auto add_flags) -> Result<CommandLine> {
    Result<std::optional<PrintText>> parsed =
        parse_command(rest, std::string(command), description, options, add_flags);
    if (!parsed.ok()) return parsed.error();
    if (parsed.value())
      line.command = *std::move(parsed).value();
    else
      line.command = std::move(options);
    return line;
  };
  if (command == "render")
    return take(RenderOptions{}, "Renders a glTF scene to PNG and EXR pictures.", add_render_flags);
  if (command == "info") return take(InfoOptions{}, "Prints what is in a glTF file.", add_info_flags);
  if (command == "shootout")
    return take(ShootoutOptions{}, "Races accelerators on the rays that path tracing a glTF scene takes.",
                add_shootout_flags);

  const std::string extension = std::filesystem::path(command).extension().string();
  if (extension == ".gltf" || extension == ".glb")
    return usage_error(fmt::format("'{}' is not a command; did you mean 'kindling render {}'?", command, command));
  return usage_error(fmt::format("unknown {} '{}'; use render, info or shootout",
                                 command.starts_with('-') ? "flag" : "command", command));
}

std::string help_hint(std::span<const char* const> arguments) {
  if (!arguments.empty())
    for (const std::string_view command : {"render", "info", "shootout"})
      if (command == arguments.front()) return fmt::format(" (try 'kindling {} --help')", command);
  return " (try 'kindling --help')";
}

} // namespace kindling::app
