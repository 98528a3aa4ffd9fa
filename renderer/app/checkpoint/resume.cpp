// Rebuilds the options of a render from its checkpoint.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/checkpoint/resume.h"

#include "renderer/app/flags/device_flag.h"
#include "renderer/app/flags/parse_command_line.h"
#include "renderer/app/options/resume_options.h"
#include "renderer/app/output/outputs.h"
#include "renderer/app/terminal/version.h"
#include "renderer/base/text.h"
#include "renderer/session/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>

namespace kindling::app {

namespace fs = std::filesystem;

namespace {

void make_absolute(fs::path& path) {
  std::error_code ignored;
  if (!path.empty()) path = fs::absolute(path, ignored);
}

ResumeOptions with_absolute_names(ResumeOptions resume) {
  for (fs::path* path : {&resume.file, &resume.folder, &resume.scene_file, &resume.stats_file}) make_absolute(*path);
  for (fs::path& output : resume.outputs) make_absolute(output);
  return resume;
}

Result<void> enter(const fs::path& folder, const ResumeOptions& typed) {
  std::error_code code;
  fs::current_path(folder, code);
  if (!code) return {};
  if (!typed.folder.empty())
    return Error{ErrorKind::input_output,
                 fmt::format("--folder: '{}' cannot be entered: {}", typed.folder.string(), code.message())};
  return Error{ErrorKind::input_output,
               fmt::format("{}: was started in folder '{}', which cannot be entered: {}; name the folder of its files "
                           "with --folder",
                           typed.file.string(), folder.string(), code.message())};
}

Result<CommandLine> parse(const std::vector<std::string>& arguments) {
  std::vector<const char*> words;
  for (const std::string& argument : arguments) words.push_back(argument.c_str());
  return parse_command_line(words);
}

} // namespace

Result<CommandLine> resume_command_line(const ResumeOptions& typed) {
  const Result<AccumulationIdentity> found = read_checkpoint_identity(typed.file);
  if (!found.ok()) return found.error();
  const AccumulationIdentity& identity = found.value();
  if (identity.program != program_identity())
    return Error{ErrorKind::usage,
                 fmt::format("{}: was written by {}, this is {}; resume it with the program that wrote it",
                             typed.file.string(), printable(identity.program), program_identity())};
  if (identity.arguments.empty())
    return usage_error(fmt::format("{}: was written by a program that links Kindling; resume it with that program",
                                   typed.file.string()));
  const ResumeOptions resume = with_absolute_names(typed);
  std::error_code ignored;
  const fs::path here = fs::current_path(ignored);
  const fs::path folder = resume.folder.empty() ? identity.folder : resume.folder;
  if (folder != here)
    if (Result<void> entered = enter(folder, typed); !entered.ok()) return entered.error();

  std::vector<std::string> arguments = resumed_arguments(identity, resume);
  Result<CommandLine> line = parse(arguments);
  RenderOptions* options = line.ok() ? std::get_if<RenderOptions>(&line.value().command) : nullptr;
  if (options == nullptr)
    return Error{ErrorKind::usage, fmt::format("{}: holds no command that can be resumed{}", typed.file.string(),
                                               line.ok() ? "" : ": " + line.error().message)};
  if (!resume.scene_file.empty())
    std::replace(options->arguments.begin(), options->arguments.end(), options->scene_file.string(),
                 resume.scene_file.string());
  if (folder != here) { // printed names must be valid from any folder
    if (options->outputs.empty()) options->outputs.push_back(default_output(*options));
    for (fs::path& output : options->outputs) make_absolute(output);
  }
  override_render(resume, *options);
  if (Result<void> checked = check_device_memory(options->device, resume.device_memory_bytes); !checked.ok())
    return checked.error();
  options->checkpoint.file = folder == here ? typed.file : resume.file;
  options->checkpoint.must_exist = true;
  options->frames.force = true; // existing images may lack samples
  return line;
}

std::vector<std::string> resumed_arguments(const AccumulationIdentity& identity, const ResumeOptions& resume) {
  std::vector<std::string> arguments = identity.arguments;
  if (!resume.spp || *resume.spp == identity.samples_per_pixel) return arguments;
  const auto add = [&](const char* flag, uint32_t value) {
    arguments.emplace_back(flag);
    arguments.push_back(fmt::format("{}", value));
  };
  add("--spp", *resume.spp);
  add("--planned-spp", identity.planned_samples);
  return arguments;
}

void override_render(const ResumeOptions& resume, RenderOptions& o) {
  if (!resume.scene_file.empty()) o.scene_file = resume.scene_file;
  if (!resume.outputs.empty()) o.outputs = resume.outputs;
  if (!resume.stats_file.empty()) o.stats_file = resume.stats_file;
  if (resume.denoising) o.resumed_denoising = resume.denoising;
  if (resume.device) o.device = *resume.device;
  if (resume.device_memory_bytes) o.device_memory_bytes = resume.device_memory_bytes;
  if (resume.threads) o.threads = *resume.threads;
  if (resume.time_limit_s) {
    if (!o.time_limit_s) o.spp = o.samples_per_pixel(); // with a limit the default would be another
    o.time_limit_s = resume.time_limit_s;
    o.time_limit_total_s.reset();
  }
  o.tev.reset(); // it may be gone by now
  if (resume.checkpoint_every_s) o.checkpoint.every_s = *resume.checkpoint_every_s;
  if (resume.progress) o.progress = *resume.progress;
  o.quiet = resume.quiet || (o.quiet && !resume.verbose);
  o.verbose = resume.verbose || (o.verbose && !resume.quiet);
}

} // namespace kindling::app
