// Runs the actions of `kindling farm`: submit, status, retry, work, merge.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/merge/command_farm.h"

#include "renderer/app/flags/parse_command_line.h"
#include "renderer/app/merge/farm_report.h"
#include "renderer/app/options/farm_options.h"
#include "renderer/app/options/options.h"
#include "renderer/app/output/file_conflicts.h"
#include "renderer/app/output/outputs.h"
#include "renderer/app/terminal/console.h"
#include "renderer/app/terminal/exit_code.h"
#include "renderer/app/text/text_format.h"
#include "renderer/distributed/farm_status.h"
#include "renderer/distributed/farm_worker.h"
#include "renderer/import/load_scene.h"
#include "renderer/session/check_settings.h"
#include "renderer/session/program_identity.h"

#include <fmt/format.h>

#include <climits>
#include <numeric>

namespace kindling::app {

namespace {

Result<int> print_answer(const std::string& text, int exit_code) {
  if (Result<void> printed = print(text); !printed.ok()) return printed.error();
  return exit_code;
}

// Checks a command that the farm will run with this program's own parser.
Result<CommandLine> check_command(const std::vector<std::string>& command) {
  std::vector<const char*> words;
  for (size_t i = 1; i < command.size(); ++i) words.push_back(command[i].c_str());
  return parse_command_line(words);
}

Result<FarmPlan> make_plan(const FarmSubmitOptions& options) {
  std::error_code error;
  FarmPlan plan;
  plan.program = fmt::format("kindling {}", version());
  plan.binary = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return Error{ErrorKind::input_output, "/proc/self/exe: " + error.message()};
  plan.working_folder = std::filesystem::current_path(error);
  if (error) return Error{ErrorKind::input_output, "the current folder: " + error.message()};
  plan.folder = std::filesystem::weakly_canonical(plan.working_folder / options.folder, error);
  if (error) return Error{ErrorKind::input_output, fmt::format("{}: {}", options.folder.string(), error.message())};
  plan.scene = plan.working_folder / options.scene_file;
  for (const std::filesystem::path& output : options.outputs) plan.outputs.push_back(plan.working_folder / output);
  plan.flags = options.render_flags;
  plan.frames = options.frames;
  plan.parts = options.parts;
  plan.retries = options.retries;
  plan.engine = options.engine;
  plan.resources = options.resources;
  return plan;
}

bool is_inside(const std::filesystem::path& path, const std::filesystem::path& folder) {
  const std::filesystem::path relative = path.lexically_normal().lexically_relative(folder);
  return !relative.empty() && *relative.begin() != "..";
}

// Checks that the images can be written. The folders of the farm itself do not exist yet.
Result<void> check_outputs(const FarmPlan& plan) {
  for (const std::filesystem::path& output : plan.outputs) {
    for (const char* name : {"parts", "state", "logs"})
      if (is_inside(output, plan.folder / name))
        return usage_error(fmt::format("-o: {}: is among the farm's own files; use another folder", output.string()));
    if (output.parent_path().lexically_normal() == plan.folder) continue;
    if (Result<void> writable = check_writable(output); !writable.ok())
      return Error{writable.error().kind, "-o: " + writable.error().message};
  }
  return {};
}

// Checks that names of the farm's own files fit into its folder.
Result<void> check_folder(const FarmPlan& plan) {
  constexpr size_t kOwnNameBytes = 160; // "/parts/frame-0012-part-003.checkpoint.kacc", with a temporary name
  const size_t bytes = plan.folder.native().size();
  if (bytes + kOwnNameBytes < PATH_MAX) return {};
  return Error{ErrorKind::input_output, fmt::format("--folder: {}: the path has {} bytes; use at most {}",
                                                    plan.folder.string(), bytes, PATH_MAX - kOwnNameBytes)};
}

// Checks that the images of all frames are different files, and none of what the renders read.
Result<void> check_files(const FarmPlan& plan, const CommandLine& render,
                         std::span<const std::filesystem::path> scene) {
  std::vector<NamedFile> written;
  for (int frame = 0; frame < plan.frame_count(); ++frame)
    for (const std::filesystem::path& output : plan.outputs_of(frame)) written.push_back({"-o", output});
  if (Result<void> differ = check_outputs_differ(written); !differ.ok()) return differ;
  std::vector<NamedFile> read = with_role(kSceneFile, scene);
  if (const auto* options = std::get_if<RenderOptions>(&render.command))
    for (const NamedFile& file : files_read(*options)) read.push_back(file);
  return check_inputs_remain(written, read);
}

// Checks that the settings of a render can be combined, which each part would refuse otherwise. The
// image has any size.
Result<void> check_render_settings(const CommandLine& render) {
  const auto* options = std::get_if<RenderOptions>(&render.command);
  if (options == nullptr) return {};
  const V2i size(kMaxImageSide);
  RenderSettings settings = to_render_settings(*options, size);
  settings.device = options->device;
  return check_combination(settings, Camera(SceneCamera{}, M44f(), size));
}

// Finds errors before any machine starts.
Result<void> check_plan(const FarmPlan& plan, const FarmEngine& engine, bool check_scene) {
  if (Result<void> checked = engine.check(plan.resources); !checked.ok()) return checked;
  if (Result<void> checked = check_folder(plan); !checked.ok()) return checked;
  // The last part fails if there are more parts than samples.
  const Result<CommandLine> render = check_command(render_command(plan, plan.task(plan.parts - 1), 0));
  if (!render.ok()) return render.error();
  if (Result<void> checked = check_render_settings(render.value()); !checked.ok()) return checked;
  if (const Result<CommandLine> merge = check_command(merge_command(plan, 0)); !merge.ok()) return merge.error();
  if (Result<void> checked = check_files(plan, render.value(), {}); !checked.ok() || !check_scene) return checked;
  if (Result<void> checked = check_outputs(plan); !checked.ok()) return checked;
  std::vector<std::filesystem::path> files;
  ImportOptions import_options;
  import_options.decode_textures = false;
  import_options.files = &files;
  if (const auto* options = std::get_if<RenderOptions>(&render.value().command))
    import_options.limits.follow_links = options->follow_links;
  if (Result<Scene> scene = load_scene(plan.scene, import_options, nullptr); !scene.ok()) return scene.error();
  return check_files(plan, render.value(), files);
}

Result<int> hand_over(const FarmPlan& plan, const std::vector<int>& tasks, FarmEngine& engine) {
  Result<FarmJobs> jobs = engine.submit(plan, tasks);
  if (!jobs.ok()) return jobs.error();
  if (Result<void> written = write_jobs(plan.folder, jobs.value()); !written.ok()) return written.error();
  std::string ids;
  for (const FarmArray& array : jobs.value().arrays) ids += (ids.empty() ? "" : ", ") + array.id;
  return print_answer(fmt::format("{}\ntasks\t{}\njobs\t{}\nmerge\t{}\n", plan.folder.string(), tasks.size(), ids,
                                  jobs.value().merge_id),
                      kExitOk);
}

Result<int> submit(const FarmSubmitOptions& options) {
  Result<FarmPlan> plan = make_plan(options);
  if (!plan.ok()) return plan.error();
  Result<std::unique_ptr<FarmEngine>> engine = make_farm_engine(options.engine);
  if (!engine.ok()) return engine.error();
  if (Result<void> checked = check_plan(plan.value(), *engine.value(), options.check_scene); !checked.ok())
    return checked.error();
  if (Result<void> written = write_new_plan(plan.value()); !written.ok()) return written.error();
  std::vector<int> tasks(static_cast<size_t>(plan.value().task_count()));
  std::iota(tasks.begin(), tasks.end(), 0);
  Result<int> code = hand_over(plan.value(), tasks, *engine.value());
  if (!code.ok()) { // the same command can then be given again
    std::error_code error;
    std::filesystem::remove(plan.value().folder / "plan.json", error);
  }
  return code;
}

// The state with the engine's queue, or without it if the engine cannot be asked.
Result<FarmStatus> status_of(const FarmPlan& plan, FarmEngine& engine) {
  Result<FarmJobs> jobs = read_jobs(plan.folder);
  if (!jobs.ok()) return jobs.error();
  std::optional<FarmQueue> queue;
  Result<FarmQueue> asked = engine.queue(jobs.value());
  if (asked.ok()) queue = asked.value();
  Result<FarmStatus> status = farm_status(plan, queue);
  if (status.ok() && !asked.ok()) status.value().queue_error = asked.error().message;
  return status;
}

Result<int> show_status(const FarmPlan& plan, FarmEngine& engine, bool json, Console& console) {
  Result<FarmStatus> status = status_of(plan, engine);
  if (!status.ok()) return status.error();
  if (!status.value().queue_error.empty())
    console.warning(status.value().queue_error + "; the state is that of the records only");
  return print_answer(json ? format_farm_json(plan, status.value()) : format_farm_status(plan, status.value()),
                      farm_exit_code(status.value()));
}

Result<int> retry(const FarmPlan& plan, FarmEngine& engine) {
  Result<FarmStatus> status = status_of(plan, engine);
  if (!status.ok()) return status.error();
  if (!status.value().queue_error.empty()) return Error{ErrorKind::input_output, status.value().queue_error};
  if (status.value().in_progress())
    return Error{ErrorKind::usage, plan.folder.string() + ": is still in progress; wait until it has ended"};
  std::vector<int> tasks;
  for (const FrameStatus& frame : status.value().frames)
    for (const TaskStatus& task : frame.tasks) {
      if (task.state == TaskState::done) continue;
      tasks.push_back(task.task.number);
      if (Result<void> written = write_task_record(plan.task_record_file(task.task), {}); !written.ok())
        return written.error();
    }
  std::error_code error;
  std::filesystem::remove(plan.refusal_file(), error);
  return hand_over(plan, tasks, engine);
}

Result<int> merge(const FarmPlan& plan, Console& console) {
  Result<MergeReport> report = merge_frames(plan, [&](std::string_view line) { console.line(printable(line)); });
  if (!report.ok()) return report.error();
  for (const std::string& line : report.value().bad) console.warning(line);
  const Result<std::optional<FarmRefusal>> refusal = read_refusal(plan.refusal_file());
  if (refusal.ok() && refusal.value()) console.error(refusal.value()->message);
  console.note(
      fmt::format("{} of {} frames merged", report.value().merged + report.value().already, plan.frame_count()));
  if (report.value().exit_code != 0) return report.value().exit_code;
  if (report.value().bad.empty()) return kExitOk;
  return refusal.ok() && refusal.value() ? refusal.value()->exit_code : kExitIncomplete;
}

} // namespace

Result<int> run_farm(const FarmOptions& options, Console& console) {
  if (const auto* wanted = std::get_if<FarmSubmitOptions>(&options)) return submit(*wanted);
  const auto& wanted = std::get<FarmFolderOptions>(options);
  Result<FarmPlan> plan = read_plan(wanted.folder);
  if (!plan.ok()) return plan.error();
  Result<std::unique_ptr<FarmEngine>> engine = make_farm_engine(plan.value().engine);
  if (!engine.ok()) return engine.error();
  switch (wanted.action) {
  case FarmAction::status: return show_status(plan.value(), *engine.value(), wanted.json, console);
  case FarmAction::merge: return merge(plan.value(), console);
  case FarmAction::retry: return retry(plan.value(), *engine.value());
  case FarmAction::work: break;
  }
  if (wanted.task >= plan.value().task_count())
    return Error{ErrorKind::usage,
                 fmt::format("task {}: the farm has {}, numbered from 0", wanted.task, plan.value().task_count())};
  return work_on_task(plan.value(), wanted.task, *engine.value(),
                      [&](std::string_view line) { console.line(printable(line)); });
}

} // namespace kindling::app
