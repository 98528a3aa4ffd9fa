// Parses the five actions of `kindling farm` and their flags.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/farm_flags.h"

#include "renderer/app/flags/command_flags.h"
#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/frame_flags.h"
#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/options/farm_options.h"
#include "renderer/app/output/frame_names.h"
#include "renderer/app/output/outputs.h"
#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace kindling::app {

namespace {

constexpr std::string_view kFarmHelp = R"(Renders frames in parts on the machines of a Slurm cluster.

Usage:
  kindling farm submit SCENE --parts N --folder DIR -o FILE [flags] -- [flags of render]
                              submit a scene to Slurm: an array of tasks, and a job that merges them
  kindling farm status DIR    print the state; exit code 0 done, 6 in progress, 5 parts keep failing or are missing
  kindling farm retry DIR     submit the parts again that keep failing or are missing
  kindling farm work DIR N    render task N, as the tasks of the array do
  kindling farm merge DIR     merge the frames that are complete, as the merge job does
  kindling farm submit --help all flags

DIR must be a folder that all machines share.
)";

// Flags that the farm sets for each render, or that do not work with parts.
constexpr std::array<const char*, 16> kOwnFlags = {
    "--output", "--part",  "--tile-part", "--checkpoint", "--frames", "--force",           "--progress", "--threads",
    "--stats",  "--pixel", "--sample",    "--time-limit", "--quiet",  "--noise-threshold", "--tev",      "--tev-host"};

void add_submit_flags(FlagSet& flags, FarmSubmitOptions& o) {
  flags.group("What to render");
  flags.value("--parts", "N", "Parts of each frame, one task each, as with --part of 'kindling render' [required]",
              [&o](auto text) { return store(parse_integer(text, 1, 100000), o.parts); });
  flags.value("--frames", "A-B[xSTEP]", "Frames of an animation, as with --frames of 'kindling render' [one image]",
              [&o](auto text) { return store(parse_frames(text), o.frames); });
  flags.value("--folder", "DIR", "New folder for parts, records and logs, which all machines share [required]",
              [&o](auto text) { return set_path(text, o.folder); });
  flags.repeated("-o,--output", "FILE",
                 "Output file: .png, .exr or .kacc; may be given several times; #### is the frame number [required]",
                 [&o](auto text) {
                   std::filesystem::path path;
                   Result<void> set = set_path(text, path);
                   if (set.ok()) o.outputs.push_back(path);
                   return set;
                 });
  flags.value("--retries", "N", fmt::format("Further attempts at a part whose render fails [{}]", o.retries),
              [&o](auto text) { return store(parse_integer(text, 0, 100), o.retries); });
  flags.toggle("--no-check",
               "Check neither the scene nor the output folders now, for large scenes or files on other machines",
               o.check_scene, false);
  flags.group("Engine");
  flags.value("--engine", "NAME", fmt::format("Batch system: slurm [{}]", o.engine), [&o](auto text) -> Result<void> {
    if (text != "slurm") return unknown_name("engine", text, {"slurm"});
    o.engine = std::string(text);
    return {};
  });
  flags.value("--partition", "NAME", "Partition that tasks are queued in [the engine's default]",
              [&o](auto text) { return set_text(text, o.resources.partition); });
  flags.value("--threads-per-part", "N", "Processors of a task [all of a machine, exclusively]",
              [&o](auto text) { return store(parse_integer(text, 1, 1024), o.resources.threads_per_part); });
  flags.value("--memory", "SIZE", "Memory of a task, such as 4G [the engine's default]",
              [&o](auto text) { return set_text(text, o.resources.memory); });
  flags.value(
      "--time", "TIME",
      "Time limit of a task, such as 2:00:00; a part that takes longer is saved and resumed in another task [the "
      "engine's default]",
      [&o](auto text) { return set_text(text, o.resources.time); });
  flags.group("Reports");
}

FlagSet declare_submit_flags(FarmSubmitOptions& options) {
  FlagSet flags("Submits a scene to the machines of a farm.", "kindling farm submit");
  flags.usage("SCENE --parts N --folder DIR -o FILE [flags] -- [flags of render]\n\nSCENE is a .gltf or .glb file. "
              "[Defaults] are in brackets; the last use of a flag counts.");
  add_submit_flags(flags, options);
  return flags;
}

// True if help was asked for.
Result<bool> parse_words(FlagSet& flags, std::span<const char* const> arguments) {
  Result<bool> help = flags.parse(arguments);
  if (!help.ok() || help.value()) return help;
  if (const std::vector<std::string> extras = flags.extras(); !extras.empty()) {
    const std::string nearest = nearest_name(extras.front(), flags.names());
    return usage_error(fmt::format("unexpected '{}'{}", extras.front(),
                                   nearest.empty() ? "; flags of 'kindling render' come after --"
                                                   : "; did you mean " + nearest + "?"));
  }
  return false;
}

// Refuses flags of the render that the farm sets, in every spelling: the render's own parser reads
// them. Errors in other flags are found when the whole command is checked.
Result<void> check_render_words(const FarmSubmitOptions& o) {
  RenderOptions options;
  FlagSet flags("", "kindling render");
  add_render_flags(flags, options);
  std::string scene;
  flags.operand("SCENE", scene);
  std::vector<const char*> words{"scene"};
  for (const std::string& word : o.render_flags) words.push_back(word.c_str());
  const Result<bool> help = flags.parse(words);
  if (!help.ok()) return usage_error("after --: " + help.error().message);
  if (help.value()) return usage_error("--help: cannot be given after --; see 'kindling render --help'");
  for (const char* name : kOwnFlags)
    if (flags.given(name))
      return usage_error(
          fmt::format("{}: cannot be given after --; the farm sets it, or it does not work with parts", name));
  return {};
}

Result<void> check_submit(const FarmSubmitOptions& o) {
  if (o.scene_file.empty())
    return usage_error("no scene; use 'kindling farm submit SCENE --parts N --folder DIR -o FILE'");
  if (o.parts == 0) return usage_error("--parts: is missing; give the number of parts of each frame");
  if (o.folder.empty()) return usage_error("--folder: is missing; give a new folder that all machines share");
  if (o.outputs.empty()) return usage_error("-o: is missing; give the name of the image");
  constexpr size_t kMaxTasks = 1'000'000;
  if (std::max<size_t>(o.frames.size(), 1) * static_cast<size_t>(o.parts) > kMaxTasks)
    return usage_error(
        fmt::format("{} frames in {} parts are more than {} tasks", o.frames.size(), o.parts, kMaxTasks));
  for (const std::filesystem::path& output : o.outputs) {
    if (is_standard_output(output)) return usage_error(fmt::format("-o {}: a farm writes files", output.string()));
    if (const std::string sentence = is_accumulation(output) ? "" : unsupported_output(output); !sentence.empty())
      return usage_error("-o: " + sentence);
    if (o.frames.empty()) continue; // names are taken literally
    if (count_frame_groups(output) != 1 || count_frame_groups(output.filename()) != 1)
      return usage_error(
          fmt::format("-o {}: needs one #### in the file's name, for the frame number", output.string()));
  }
  if (!o.frames.empty()) {
    std::error_code code;
    const std::filesystem::path folder = std::filesystem::absolute(o.folder, code);
    if (code) return Error{ErrorKind::input_output, "the current folder: " + code.message()};
    if (count_frame_groups(folder) > 0)
      return usage_error(
          fmt::format("--folder {}: has a # in its name, which would be taken for a frame number", o.folder.string()));
  }
  return check_render_words(o);
}

Result<FarmCommandLine> parse_submit(std::span<const char* const> arguments) {
  const auto end =
      std::find_if(arguments.begin(), arguments.end(), [](const char* word) { return std::string_view(word) == "--"; });
  FarmSubmitOptions options;
  if (end != arguments.end()) options.render_flags.assign(end + 1, arguments.end());
  FlagSet flags = declare_submit_flags(options);
  std::string scene;
  flags.operand("SCENE", scene);
  Result<bool> help = parse_words(flags, arguments.first(static_cast<size_t>(end - arguments.begin())));
  if (!help.ok()) return help.error();
  if (help.value()) return FarmCommandLine{{}, flags.help()};
  options.scene_file = scene;
  if (Result<void> checked = check_submit(options); !checked.ok()) return checked.error();
  return FarmCommandLine{std::move(options), {}};
}

Result<FarmCommandLine> parse_folder_action(FarmAction action, std::span<const char* const> arguments) {
  FarmFolderOptions options;
  options.action = action;
  std::vector<std::string> words;
  for (const std::string_view word : arguments) {
    if (word == "-h" || word == "--help") return FarmCommandLine{{}, std::string(kFarmHelp)};
    if (word == "--json" && action == FarmAction::status)
      options.json = true;
    else if (word.starts_with('-') && word.size() > 1)
      return usage_error(fmt::format("unknown flag '{}'", word));
    else
      words.emplace_back(word);
  }
  const size_t wanted = action == FarmAction::work ? 2 : 1;
  if (words.size() != wanted)
    return usage_error(wanted == 2 ? "use 'kindling farm work DIR TASK'" : "use one folder of a farm");
  options.folder = words[0];
  if (wanted == 2) {
    Result<int64_t> task = parse_integer(words[1], 0, std::numeric_limits<int>::max());
    if (!task.ok()) return usage_error("TASK: " + task.error().message);
    options.task = static_cast<int>(task.value());
  }
  return FarmCommandLine{options, {}};
}

} // namespace

Result<FarmCommandLine> parse_farm_command(std::span<const char* const> arguments) {
  const std::string_view action = arguments.empty() ? "" : arguments.front();
  if (action.empty() || action == "-h" || action == "--help") {
    if (action.empty()) return usage_error("farm: no action; use submit, status, retry, work or merge");
    return FarmCommandLine{{}, std::string(kFarmHelp)};
  }
  const auto rest = arguments.subspan(1);
  if (action == "submit") return parse_submit(rest);
  if (action == "status") return parse_folder_action(FarmAction::status, rest);
  if (action == "retry") return parse_folder_action(FarmAction::retry, rest);
  if (action == "work") return parse_folder_action(FarmAction::work, rest);
  if (action == "merge") return parse_folder_action(FarmAction::merge, rest);
  return usage_error(fmt::format("farm: unknown action '{}'; use submit, status, retry, work or merge", action));
}

std::vector<CommandTable> farm_tables() {
  FarmSubmitOptions options;
  CommandTable submit = declare_submit_flags(options).table();
  submit.name = "farm submit";
  const FlagRow json{"", "--json", "", "Print JSON", "Reports"};
  return {std::move(submit),
          {"farm status", "DIR [--json]", "Prints the state of a farm.", {json}},
          {"farm retry", "DIR", "Submits again the tasks that were given up or are missing.", {}},
          {"farm work", "DIR TASK", "Renders one task; the engine runs it.", {}},
          {"farm merge", "DIR", "Merges the frames whose parts are all there; the engine runs it.", {}}};
}

} // namespace kindling::app
