// The `kindling` program: runs one command and turns errors into one line and an exit code.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/checkpoint/resume.h"
#include "renderer/app/denoise/command_denoise.h"
#include "renderer/app/flags/parse_command_line.h"
#include "renderer/app/info/command_info.h"
#include "renderer/app/merge/command_farm.h"
#include "renderer/app/merge/command_merge.h"
#include "renderer/app/options/farm_options.h"
#include "renderer/app/options/options.h"
#include "renderer/app/options/resume_options.h"
#include "renderer/app/relight/command_relight.h"
#include "renderer/app/render/command_render.h"
#include "renderer/app/scaling/command_scaling.h"
#include "renderer/app/shootout/command_shootout.h"
#include "renderer/app/shootout/plugins/plugin_host.h"
#include "renderer/app/terminal/console.h"
#include "renderer/app/terminal/exit_code.h"
#include "renderer/app/terminal/signals.h"
#include "renderer/app/terminal/thread_stack.h"
#include "renderer/app/view/command_view.h"

#include <fmt/format.h>

#include <exception>
#include <new>
#include <optional>
#include <span>

namespace kindling::app {

namespace {

ConsoleSettings console_settings(const CommandLine& line) {
  if (const auto* render = std::get_if<RenderOptions>(&line.command))
    return {render->quiet, render->verbose, render->progress == ProgressMode::json};
  if (const auto* shootout = std::get_if<ShootoutOptions>(&line.command))
    return {shootout->view.quiet, shootout->view.verbose, false};
  if (const auto* merge = std::get_if<MergeOptions>(&line.command))
    return {merge->image.quiet, merge->image.verbose, false};
  if (const auto* denoise = std::get_if<DenoiseOptions>(&line.command))
    return {denoise->image.quiet, denoise->image.verbose, false};
  if (const auto* relight = std::get_if<RelightOptions>(&line.command))
    return {relight->image.quiet, relight->image.verbose, false};
  if (const auto* scaling = std::get_if<ScalingOptions>(&line.command))
    return {scaling->image.quiet, scaling->image.verbose, false};
  if (const auto* live = std::get_if<LiveOptions>(&line.command))
    return {live->image.quiet, live->image.verbose, false};
  return {};
}

Result<int> run_command(const CommandLine& line, Console& console) {
  if (const auto* render = std::get_if<RenderOptions>(&line.command)) return run_render(*render, line.text, console);
  if (const auto* info = std::get_if<InfoOptions>(&line.command)) return run_info(*info, console);
  if (const auto* shootout = std::get_if<ShootoutOptions>(&line.command))
    return run_shootout(*shootout, line.text, console);
  if (const auto* farm = std::get_if<FarmOptions>(&line.command)) return run_farm(*farm, console);
  if (const auto* merge = std::get_if<MergeOptions>(&line.command)) return run_merge(*merge, line.text, console);
  if (const auto* denoise = std::get_if<DenoiseOptions>(&line.command))
    return run_denoise(*denoise, line.text, console);
  if (const auto* relight = std::get_if<RelightOptions>(&line.command))
    return run_relight(*relight, line.text, console);
  if (const auto* scaling = std::get_if<ScalingOptions>(&line.command))
    return run_scaling(*scaling, line.text, console);
  if (const auto* live = std::get_if<LiveOptions>(&line.command)) return run_view(*live, console);
  const Result<void> printed = print(std::get<PrintText>(line.command).text);
  return printed.ok() ? Result<int>(kExitOk) : printed.error();
}

int run(std::span<const char* const> arguments) {
  std::optional<Console> console(std::in_place);
  try {
    if (is_plugin_host(arguments)) {
      const Result<int> code = run_plugin_host(arguments);
      if (code.ok()) return code.value();
      console->error(code.error().message);
      return exit_code_of(code.error().kind);
    }
    ignore_signals_of_writing();
    Result<CommandLine> line = parse_command_line(arguments);
    if (const auto* resume = line.ok() ? std::get_if<ResumeOptions>(&line.value().command) : nullptr)
      line = resume_command_line(ResumeOptions(*resume)); // a render from here on
    if (line.ok()) console.emplace(console_settings(line.value()));
    const Result<int> code = line.ok() ? run_command(line.value(), *console) : Result<int>(line.error());
    if (code.ok()) return code.value();
    const Error& error = code.error();
    console->error(error.kind == ErrorKind::usage ? error.message + help_hint(arguments) : error.message);
    return exit_code_of(error.kind);
  } catch (const std::bad_alloc&) {
    console->error("out of memory");
  } catch (const std::exception& exception) {
    console->error(fmt::format("unexpected: {}", exception.what()));
  }
  return kExitRenderFailed;
}

int run_with_stack(std::span<const char* const> arguments) {
  const Result<int> code = call_with_enough_stack([&] { return run(arguments); });
  if (code.ok()) return code.value();
  Console().error(code.error().message);
  return exit_code_of(code.error().kind);
}

} // namespace

} // namespace kindling::app

int main(int argc, char** argv) {
  return kindling::app::run_with_stack({argv + 1, argc > 0 ? static_cast<size_t>(argc - 1) : 0});
}
