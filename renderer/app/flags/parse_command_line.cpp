// Parses the command line by command, and has the help of the whole program.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/parse_command_line.h"

#include "renderer/app/flags/command_flags.h"
#include "renderer/app/flags/completion.h"
#include "renderer/app/flags/farm_flags.h"
#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/manual_page.h"
#include "renderer/app/flags/resume_flags.h"
#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/options/resume_options.h"
#include "renderer/app/terminal/version.h"
#include "renderer/app/text/parse_values.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>

namespace kindling::app {

namespace {

constexpr std::string_view kHelp =
    R"(kindling {}: a path tracer for glTF 2.0 scenes

Usage:
  kindling render SCENE [-o FILE]... [flags]   render a .gltf or .glb file to PNG and EXR
  kindling resume FILE.kacc [flags]            resume an interrupted render, or add samples to one
  kindling view SCENE [flags]                  render a scene in a browser, as camera and settings change
  kindling merge PART... -o FILE [flags]       add up parts that were rendered separately
  kindling denoise FILE -o FILE [flags]        denoise an .exr image or a .kacc file
  kindling relight FILE --group NAME=FACTOR    change the lights of an image with light groups
  kindling info SCENE [flags]                  print the contents of a scene
  kindling info FILE.kacc [--json]             print the contents of a checkpoint or part, and check it
  kindling shootout SCENE... [flags]           race the accelerators on the scenes' own rays
  kindling farm ACTION ...                     render in parts on the machines of a Slurm cluster
  kindling scaling SCENE... [flags]            measure thread scaling, from loading to the image
  kindling info --list-extensions              print the supported glTF extensions
  kindling COMMAND --help                      all flags of a command
  kindling manual                              print the manual page
  kindling completion bash|zsh                 print a shell's completion script
  kindling --version                           version, compiler and libraries

Exit codes: 0 done, 1 render failed, 2 wrong usage, 3 scene invalid, 4 a file cannot be read or written,
5 parts are missing, 6 a farm is in progress, 129, 130 and 143 interrupted (the images and the checkpoint are written).
Results go to standard output, all else to standard error.
)";

// Describes a word that belongs to no flag or operand, with a suggestion.
std::string describe_extra(const std::string& word, const FlagSet& flags, std::string_view operand_given) {
  if (word.starts_with('-') && word.size() > 1) {
    const std::string name = word.substr(0, word.find('='));
    const std::string nearest = nearest_name(name, flags.names());
    return nearest.empty() ? fmt::format("unknown flag '{}'", name)
                           : fmt::format("unknown flag '{}'; did you mean {}?", name, nearest);
  }
  return fmt::format("unexpected argument '{}'{}", word,
                     operand_given.empty() ? "" : fmt::format("; there can be one {}", operand_given));
}

// Explanations of the operands in the help.
constexpr const char* kSceneHelp =
    "\n\nSCENE is a .gltf or .glb file, or a mesh (.ply, .obj, .stl). [Defaults] are in brackets; the last use of a "
    "flag counts.";
constexpr const char* kSceneOrAccumulationHelp = "\n\nFILE is a scene (.gltf, .glb), a mesh (.ply, .obj, .stl), or a "
                                                 "checkpoint, part or merge (.kacc). [Defaults] are "
                                                 "in brackets.";
constexpr const char* kCheckpointHelp =
    "\n\nFILE.kacc is the checkpoint of a render. [Defaults] are in brackets; the last use of a flag counts.";
constexpr const char* kPartHelp =
    "\n\nPART is a .kacc file: a part, a checkpoint or a merge, in any order. [Defaults] are in brackets.";

constexpr const char* kImageHelp = "\n\nFILE is an EXR image, of this or another renderer, with layers of albedo and "
                                   "normal if it has some, or a .kacc "
                                   "file. [Defaults] are in brackets.";

constexpr const char* kGroupsHelp = "\n\nFILE is an EXR image or a .kacc file of a render with --light-groups, or an "
                                    "EXR image of Blender with light groups. [Defaults] are in brackets.";

// A command of the program: its name, operand and flags. A new command gets a specialization here
// and an entry in Commands.
template <typename Options>
struct Command;

template <>
struct Command<RenderOptions> {
  static constexpr std::string_view kName = "render";
  static constexpr const char* kDescription = "Renders a glTF scene to PNG and EXR images.";
  static constexpr const char* kOperand = "SCENE";
  static constexpr const char* kUsage = "SCENE [-o FILE]... [flags]";
  static constexpr const char* kOperandHelp = kSceneHelp;
  static std::filesystem::path& operand(RenderOptions& options) { return options.scene_file; }
  static void add_flags(FlagSet& flags, RenderOptions& options) { add_render_flags(flags, options); }
  static Result<void> check(const FlagSet& flags, RenderOptions& options) { return check_render_flags(flags, options); }
};

template <>
struct Command<ResumeOptions> {
  static constexpr std::string_view kName = "resume";
  static constexpr const char* kDescription = "Resumes an interrupted render, or adds samples to one.";
  static constexpr const char* kOperand = "FILE.kacc";
  static constexpr const char* kUsage = "FILE.kacc [flags]";
  static constexpr const char* kOperandHelp = kCheckpointHelp;
  static std::filesystem::path& operand(ResumeOptions& options) { return options.file; }
  static void add_flags(FlagSet& flags, ResumeOptions& options) { add_resume_flags(flags, options); }
  static Result<void> check(const FlagSet& flags, ResumeOptions& options) { return check_resume_flags(flags, options); }
};

template <>
struct Command<InfoOptions> {
  static constexpr std::string_view kName = "info";
  static constexpr const char* kDescription = "Prints the contents of a glTF or .kacc file.";
  static constexpr const char* kOperand = "SCENE";
  static constexpr const char* kUsage = "FILE [flags]";
  static constexpr const char* kOperandHelp = kSceneOrAccumulationHelp;
  static std::filesystem::path& operand(InfoOptions& options) { return options.scene_file; }
  static void add_flags(FlagSet& flags, InfoOptions& options) { add_info_flags(flags, options); }
  static Result<void> check(const FlagSet& flags, InfoOptions& options) { return check_info_flags(flags, options); }
};

template <>
struct Command<ShootoutOptions> {
  static constexpr std::string_view kName = "shootout";
  static constexpr const char* kDescription = "Races accelerators on the rays that path tracing a glTF scene takes.";
  static constexpr const char* kOperand = "SCENE";
  static constexpr const char* kUsage = "SCENE... [flags]";
  static constexpr const char* kOperandHelp = kSceneHelp;
  static std::vector<std::filesystem::path>& operand(ShootoutOptions& options) { return options.scene_files; }
  static void add_flags(FlagSet& flags, ShootoutOptions& options) { add_shootout_flags(flags, options); }
  static Result<void> check(const FlagSet& flags, ShootoutOptions& options) {
    return check_shootout_flags(flags, options);
  }
};

template <>
struct Command<MergeOptions> {
  static constexpr std::string_view kName = "merge";
  static constexpr const char* kDescription = "Adds up parts of an image that were rendered separately.";
  static constexpr const char* kOperand = "PART";
  static constexpr const char* kUsage = "PART... -o FILE [-o FILE]... [flags]";
  static constexpr const char* kOperandHelp = kPartHelp;
  static std::vector<std::filesystem::path>& operand(MergeOptions& options) { return options.parts; }
  static void add_flags(FlagSet& flags, MergeOptions& options) { add_merge_flags(flags, options); }
  static Result<void> check(const FlagSet& flags, MergeOptions& options) { return check_merge_flags(flags, options); }
};

template <>
struct Command<DenoiseOptions> {
  static constexpr std::string_view kName = "denoise";
  static constexpr const char* kDescription = "Denoises a finished image by Open Image Denoise.";
  static constexpr const char* kOperand = "FILE";
  static constexpr const char* kUsage = "FILE.exr|FILE.kacc -o FILE [-o FILE]... [flags]";
  static constexpr const char* kOperandHelp = kImageHelp;
  static std::filesystem::path& operand(DenoiseOptions& options) { return options.file; }
  static void add_flags(FlagSet& flags, DenoiseOptions& options) { add_denoise_flags(flags, options); }
  static Result<void> check(const FlagSet& flags, DenoiseOptions& options) {
    return check_denoise_flags(flags, options);
  }
};

template <>
struct Command<RelightOptions> {
  static constexpr std::string_view kName = "relight";
  static constexpr const char* kDescription = "Changes the lights of a finished image that has light groups.";
  static constexpr const char* kOperand = "FILE";
  static constexpr const char* kUsage = "FILE.exr|FILE.kacc --group GROUP=FACTOR[,...] [-o FILE]... [flags]";
  static constexpr const char* kOperandHelp = kGroupsHelp;
  static std::filesystem::path& operand(RelightOptions& options) { return options.file; }
  static void add_flags(FlagSet& flags, RelightOptions& options) { add_relight_flags(flags, options); }
  static Result<void> check(const FlagSet& flags, RelightOptions& options) {
    return check_relight_flags(flags, options);
  }
};

template <>
struct Command<ScalingOptions> {
  static constexpr std::string_view kName = "scaling";
  static constexpr const char* kDescription = "Measures thread scaling, from loading a glTF scene to its image.";
  static constexpr const char* kOperand = "SCENE";
  static constexpr const char* kUsage = "SCENE... [flags]";
  static constexpr const char* kOperandHelp = kSceneHelp;
  static std::vector<std::filesystem::path>& operand(ScalingOptions& options) { return options.scene_files; }
  static void add_flags(FlagSet& flags, ScalingOptions& options) { add_scaling_flags(flags, options); }
  static Result<void> check(const FlagSet& flags, ScalingOptions& options) {
    return check_scaling_flags(flags, options);
  }
};

template <>
struct Command<LiveOptions> {
  static constexpr std::string_view kName = "view";
  static constexpr const char* kDescription = "Renders a glTF scene in a browser, as camera and settings change.";
  static constexpr const char* kOperand = "SCENE";
  static constexpr const char* kUsage = "SCENE [flags]";
  static constexpr const char* kOperandHelp = kSceneHelp;
  static std::filesystem::path& operand(LiveOptions& options) { return options.image.scene_file; }
  static void add_flags(FlagSet& flags, LiveOptions& options) { add_view_flags(flags, options); }
  static Result<void> check(const FlagSet& flags, LiveOptions& options) { return check_view_flags(flags, options); }
};

// Returns a set with the flags of one command, which parse into `options`.
template <typename Options>
FlagSet declare_flags(Options& options) {
  using This = Command<Options>;
  FlagSet flags(This::kDescription, "kindling " + std::string(This::kName));
  flags.usage(std::string(This::kUsage) + This::kOperandHelp);
  This::add_flags(flags, options);
  return flags;
}

// Returns the flags of one command as rows, for the manual.
template <typename Options>
CommandTable command_table() {
  Options options;
  CommandTable table = declare_flags(options).table();
  table.name = Command<Options>::kName;
  return table;
}

// Parses the flags of one command into `options`. Returns the help text if --help was among them.
template <typename Options>
Result<std::optional<PrintText>> parse_command(std::span<const char* const> arguments, Options& options) {
  using This = Command<Options>;
  FlagSet flags = declare_flags(options);
  auto& operand = This::operand(options);
  constexpr bool kSeveral = std::is_same_v<decltype(operand), std::vector<std::filesystem::path>&>;
  std::conditional_t<kSeveral, std::vector<std::string>, std::string> words;
  flags.operand(This::kOperand, words);
  const Result<bool> help = flags.parse(arguments);
  if (!help.ok()) return help.error();
  if (help.value()) return std::optional<PrintText>(PrintText{flags.help()});
  if (const std::vector<std::string> extras = flags.extras(); !extras.empty())
    return usage_error(describe_extra(extras.front(), flags, words.empty() ? "" : This::kOperand));
  if constexpr (kSeveral)
    operand.assign(words.begin(), words.end());
  else
    operand = words;
  if (Result<void> checked = This::check(flags, options); !checked.ok()) return checked.error();
  return std::optional<PrintText>();
}

template <typename... Options>
struct CommandList {
  static std::vector<std::string> names() { return {std::string(Command<Options>::kName)...}; }
  static std::vector<CommandTable> tables() { return {command_table<Options>()...}; }

  // Returns nothing if there is no such command.
  static std::optional<Result<CommandLine>> parse(std::string_view name, std::span<const char* const> arguments) {
    std::optional<Result<CommandLine>> line;
    const auto try_one = [&]<typename One>(One options) {
      if (name != Command<One>::kName) return;
      Result<std::optional<PrintText>> parsed = parse_command(arguments, options);
      if (!parsed.ok())
        line.emplace(parsed.error());
      else if (parsed.value())
        line.emplace(CommandLine{*std::move(parsed).value(), {}});
      else
        line.emplace(CommandLine{std::move(options), {}});
    };
    (try_one(Options{}), ...);
    return line;
  }
};

using Commands = CommandList<RenderOptions, ResumeOptions, InfoOptions, ShootoutOptions, ScalingOptions, MergeOptions,
                             DenoiseOptions, RelightOptions, LiveOptions>;

// The command with several actions, which has a parser of its own.
constexpr std::string_view kFarm = "farm";
// Commands that print a text made of all others' flags.
constexpr std::string_view kManual = "manual";
constexpr std::string_view kCompletion = "completion";

std::vector<std::string> command_names() {
  std::vector<std::string> names = Commands::names();
  names.emplace_back(kFarm);
  names.emplace_back(kManual);
  names.emplace_back(kCompletion);
  return names;
}

// The manual page or a shell's completion.
Result<PrintText> parse_documentation(std::string_view command, std::span<const char* const> arguments) {
  const std::string_view word = arguments.empty() ? "" : arguments.front();
  if (command == kManual) {
    if (word == "--help" || word == "-h")
      return PrintText{
          "Usage: kindling manual\n\nPrints the manual page, to be read with: kindling manual | man -l -\n"};
    if (!word.empty()) return usage_error(fmt::format("manual: unexpected argument '{}'", word));
    return PrintText{manual_page(command_tables(), version())};
  }
  if (word == "--help" || word == "-h")
    return PrintText{
        "Usage: kindling completion bash|zsh\n\nPrints the completion script of a shell. bash: source <(kindling "
        "completion bash); zsh: write it to a file _kindling in a folder of $fpath.\n"};
  if (arguments.size() > 1) return usage_error(fmt::format("completion: unexpected argument '{}'", arguments[1]));
  if (word == "bash") return PrintText{bash_completion(command_tables())};
  if (word == "zsh") return PrintText{zsh_completion(command_tables())};
  return unknown_name("shell", word, {"bash", "zsh"});
}

} // namespace

std::vector<CommandTable> command_tables() {
  std::vector<CommandTable> tables = Commands::tables();
  for (CommandTable& table : farm_tables()) tables.push_back(std::move(table));
  return tables;
}

Result<CommandLine> parse_command_line(std::span<const char* const> arguments) {
  CommandLine line;
  line.text = "kindling";
  for (const char* argument : arguments) line.text += ' ' + shell_quote(argument);

  if (arguments.empty()) return usage_error("no command; use " + join_choices(command_names()));
  const std::string_view command = arguments.front();
  if (command == "--help" || command == "-h" || command == "help") {
    line.command = PrintText{fmt::format(fmt::runtime(kHelp), version())};
    return line;
  }
  if (command == "--version" || command == "-V") {
    line.command = PrintText{version_text()};
    return line;
  }
  if (command == kManual || command == kCompletion) {
    Result<PrintText> text = parse_documentation(command, arguments.subspan(1));
    if (!text.ok()) return text.error();
    line.command = std::move(text).value();
    return line;
  }
  if (command == kFarm) {
    Result<FarmCommandLine> farm = parse_farm_command(arguments.subspan(1));
    if (!farm.ok()) return farm.error();
    if (farm.value().help.empty())
      line.command = std::move(farm.value().options);
    else
      line.command = PrintText{std::move(farm.value().help)};
    return line;
  }
  if (std::optional<Result<CommandLine>> parsed = Commands::parse(command, arguments.subspan(1))) {
    if (!parsed->ok()) return parsed->error();
    line.command = std::move(*parsed).value().command;
    if (auto* render = std::get_if<RenderOptions>(&line.command))
      render->arguments.assign(arguments.begin(), arguments.end());
    return line;
  }

  const std::string extension = std::filesystem::path(command).extension().string();
  if (extension == ".gltf" || extension == ".glb" || extension == ".ply" || extension == ".obj" || extension == ".stl")
    return usage_error(fmt::format("'{}' is not a command; did you mean 'kindling render {}'?", command, command));
  return usage_error(fmt::format("unknown {} '{}'; use {}", command.starts_with('-') ? "flag" : "command", command,
                                 join_choices(command_names())));
}

std::string help_hint(std::span<const char* const> arguments) {
  if (!arguments.empty())
    for (const std::string& command : command_names())
      if (command == arguments.front()) return fmt::format(" (try 'kindling {} --help')", command);
  return " (try 'kindling --help')";
}

} // namespace kindling::app
