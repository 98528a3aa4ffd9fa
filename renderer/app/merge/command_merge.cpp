// The steps of a merge: plan, add up, write, report.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/merge/command_merge.h"

#include "renderer/app/merge/merge_report.h"
#include "renderer/app/output/choose_view.h"
#include "renderer/app/output/file_conflicts.h"
#include "renderer/app/output/outputs.h"
#include "renderer/app/output/render_metadata.h"
#include "renderer/app/terminal/exit_code.h"
#include "renderer/app/terminal/process_info.h"
#include "renderer/app/terminal/progress_display.h"
#include "renderer/app/terminal/signals.h"
#include "renderer/app/terminal/stopwatch.h"

#include <fmt/format.h>

#include <utility>

namespace kindling::app {

namespace {

namespace fs = std::filesystem;

class MergeCommand {
 public:
  MergeCommand(const MergeOptions& options, const std::string& command_line, Console& console)
      : options_(options), console_(console), signals_(cancel_),
        display_(console, options.image.progress, {std::nullopt, &signals_}) {
    report_.command_line = command_line;
  }

  Result<int> run() {
    Result<std::vector<fs::path>> outputs = choose_outputs(options_.image);
    if (!outputs.ok()) return outputs.error();
    const Result<DisplayTransform> view = choose_view(options_.image);
    if (!view.ok()) return view.error();
    if (Result<void> remain = check_parts_remain(outputs.value(), view.value()); !remain.ok()) return remain.error();

    const Clock::time_point check_start = Clock::now();
    Result<MergePlan> plan = plan_merge(options_.parts, outputs.value());
    if (!plan.ok()) return plan.error();
    report_.plan = std::move(plan).value();
    report_.check_s = seconds_since(check_start);
    report_plan(report_.plan, options_.allow_missing, console_);
    if (!report_.plan.gaps.none() && !options_.allow_missing) return refuse_gaps();

    Result<Accumulation> merged = merge();
    if (signals_.received() != 0) return interrupted();
    if (!merged.ok()) return merged.error();
    const Result<void> written = write(outputs.value(), merged.value(), view.value());
    const Result<void> reported = report();
    if (!written.ok()) return written.error();
    if (!reported.ok()) return reported.error();
    return interrupted_ ? exit_code_of_signal(signals_.received()) : kExitOk;
  }

 private:
  // An accumulation may replace one of its parts, as a wildcard finds it the second time.
  Result<void> check_parts_remain(const std::vector<fs::path>& outputs, const DisplayTransform& view) {
    const std::vector<NamedFile> written = files_written(options_.image, outputs);
    if (Result<void> remain = check_inputs_remain(written, with_role(kViewFile, view.files())); !remain.ok())
      return remain;
    std::vector<NamedFile> others;
    for (const NamedFile& file : written)
      if (file.file == options_.image.stats_file || !is_accumulation(file.file)) others.push_back(file);
    return check_inputs_remain(others, with_role("a part", options_.parts));
  }

  Result<int> refuse_gaps() {
    console_.error(fmt::format("{:.3g}% of the samples are missing: nothing was written; add the parts that have them, "
                               "or use --allow-missing",
                               100.0 * report_.missing_share()));
    if (const Result<void> stats = write_stats(); !stats.ok()) return stats.error();
    return kExitIncomplete;
  }

  Result<int> interrupted() {
    console_.note("interrupted: nothing was written");
    return exit_code_of_signal(signals_.received());
  }

  Result<Accumulation> merge() {
    const Clock::time_point start = Clock::now();
    const auto files = static_cast<double>(report_.plan.parts.size() + report_.plan.duplicates.size());
    display_.start_phase(Phase::load);
    Result<Accumulation> merged = merge_accumulations(report_.plan, &cancel_, [&](size_t done) {
      display_.on_progress({.phase = Phase::load, .done = static_cast<double>(done), .total = files});
    });
    display_.end_phase();
    report_.merge_s = seconds_since(start);
    if (!merged.ok()) return merged;
    const RenderState& state = merged.value().state;
    report_.work = state.work;
    report_.film_bytes = state.film.memory_bytes();
    report_.mean_spp =
        static_cast<double>(state.film.total_samples()) / static_cast<double>(state.film.crop().pixel_count());
    return merged;
  }

  // Writes each file, also after a failure. Returns the first error and prints the others.
  Result<void> write(const std::vector<fs::path>& outputs, const Accumulation& merged, const DisplayTransform& view) {
    const Clock::time_point start = Clock::now();
    const ImageMetadata metadata = metadata_of(merged);
    std::optional<Error> first_error;
    std::vector<fs::path> images;
    for (const fs::path& output : outputs) {
      if (!is_accumulation(output)) {
        images.push_back(output);
        continue;
      }
      const Result<void> written = write_accumulation(output, merged.identity, merged.state, false);
      if (written.ok())
        report_.outputs.push_back(output.string());
      else if (!first_error)
        first_error = written.error();
      else
        console_.error(written.error().message);
    }
    const PixelRect& crop = merged.identity.crop;
    const Film& film = merged.state.film;
    const bool is_whole = film.crop().min == crop.min && film.crop().max == crop.max;
    const ImageWriting writing{view, metadata, options_.image, display_, console_, &cancel_};
    WrittenImages written =
        is_whole ? write_images(images, film, writing) : write_images(images, film.cut(crop), writing);
    interrupted_ = written.denoising_cancelled;
    report_.outputs.insert(report_.outputs.end(), written.files.begin(), written.files.end());
    if (written.first_error && !first_error)
      first_error = written.first_error;
    else if (written.first_error)
      console_.error(written.first_error->message);
    report_.write_s = seconds_since(start);
    return first_error ? Result<void>(*first_error) : Result<void>();
  }

  Result<void> report() {
    std::string names;
    for (const std::string& output : report_.outputs) names += output + "\n";
    const Result<void> printed = print(names);
    report_.total_s = seconds_since_process_start();
    report_.peak_resident_bytes = peak_resident_bytes();
    const Result<void> stats = write_stats();
    console_.line(format_merge_summary(report_));
    if (!printed.ok()) return printed;
    return stats;
  }

  Result<void> write_stats() {
    if (options_.image.stats_file.empty()) return {};
    return write_text_file(options_.image.stats_file, format_merge_json(report_) + "\n");
  }

  const MergeOptions& options_;
  Console& console_;
  CancelToken cancel_;
  SignalGuard signals_;
  ProgressDisplay display_;
  MergeReport report_;
  bool interrupted_ = false; // in denoising: the images are noisy
};

} // namespace

Result<int> run_merge(const MergeOptions& options, const std::string& command_line, Console& console) {
  return MergeCommand(options, command_line, console).run();
}

} // namespace kindling::app
