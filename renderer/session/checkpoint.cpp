// Reads, checks and writes checkpoints, and falls back to the previous generation of a damaged one.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/checkpoint.h"

#include "renderer/base/stopwatch.h"
#include "renderer/image/output_file.h"
#include "renderer/session/render_identity.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace kindling {

namespace fs = std::filesystem;

namespace {

// Endings of the files beside a checkpoint.
constexpr std::array kCompanions{".previous", ".damaged", ".lock"};

bool file_exists(const fs::path& file) {
  std::error_code ignored;
  return fs::exists(file, ignored);
}

struct FinishedSamples {
  double total = 0.0;   // over all pixels
  uint32_t max_end = 0; // of any pixel: the largest sample number + 1
};

FinishedSamples count_finished(const Coverage& coverage) {
  FinishedSamples finished;
  for (size_t i = 0; i < coverage.block_count(); ++i)
    for (const SampleRange& span : coverage[i].spans) {
      finished.total += static_cast<double>(span.count()) * static_cast<double>(coverage.block(i).pixel_count());
      finished.max_end = std::max(finished.max_end, span.end);
    }
  return finished;
}

} // namespace

Checkpoint::Checkpoint(const CheckpointOptions& options, CheckpointMessages messages, FileLock lock)
    : options_(options), messages_(std::move(messages)), lock_(std::move(lock)) {
  report_.file = options.file.string();
}

std::vector<fs::path> files_of_checkpoint(const fs::path& file) {
  const fs::path end = end_of_links(file);
  std::vector<fs::path> files{file};
  for (const char* companion : kCompanions) files.push_back(fs::path(end) += companion);
  return files;
}

Result<void> check_checkpoint_file(const fs::path& file) {
  Result<void> writable = check_writable(file, kCompanions);
  if (writable.ok()) return {};
  return Error{writable.error().kind, "--checkpoint: " + writable.error().message};
}

Result<std::unique_ptr<Checkpoint>> Checkpoint::open(const CheckpointOptions& options, CheckpointMessages messages) {
  if (Result<void> writable = check_checkpoint_file(options.file); !writable.ok()) return writable.error();
  Result<FileLock> lock = FileLock::acquire(options.file);
  if (!lock.ok()) return lock.error();
  std::unique_ptr<Checkpoint> checkpoint(new Checkpoint(options, std::move(messages), std::move(lock).value()));
  if (Result<void> read = checkpoint->read(); !read.ok()) return read.error();
  return checkpoint;
}

Result<void> Checkpoint::read() {
  const fs::path &file = options_.file, previous = previous_accumulation(file);
  std::optional<Error> wrong;
  if (file_exists(file)) {
    Result<Accumulation> current = read_accumulation(file);
    if (current.ok()) {
      found_ = std::move(current).value();
      return {};
    }
    wrong = current.error();
  }
  if (file_exists(previous)) {
    Result<Accumulation> older = read_accumulation(previous);
    if (older.ok()) {
      warn(fmt::format("{}; resuming from {}, which is older",
                       wrong ? wrong->message : file.string() + ": does not exist", previous.string()));
      found_ = std::move(older).value();
      from_previous_ = true;
    } else if (!wrong) {
      wrong = older.error();
    }
  }
  if (!found_ && !wrong && options_.must_exist)
    return Error{ErrorKind::input_output, file.string() + ": cannot be read: no such file"};
  if (!wrong) return {};
  if (!found_ && !options_.replace)
    return Error{wrong->kind, fmt::format("{}; remove it to start over, or use another file name", wrong->message)};
  if (!found_) warn(fmt::format("{}; starting over", wrong->message));
  // The next save would rename the damaged file over the good previous one.
  std::error_code code;
  // At the end of links: there the next save puts the file.
  if (const fs::path damaged = end_of_links(file); file_exists(file))
    fs::rename(damaged, fs::path(damaged) += ".damaged", code);
  if (code)
    return Error{ErrorKind::input_output,
                 fmt::format("{}: cannot be renamed to .damaged: {}", file.string(), code.message())};
  return {};
}

Result<void> Checkpoint::begin(const AccumulationIdentity& identity) {
  identity_ = identity;
  if (!found_) return {};
  Result<void> same = check_same_render(found_->identity, options_.file, identity);
  const FinishedSamples finished = count_finished(found_->state.coverage);
  if (same.ok() && finished.max_end > identity.part.end)
    return usage_error(fmt::format("--spp: {} is below the {} samples that {} has; use {} or more",
                                   identity.samples_per_pixel, finished.max_end, options_.file.string(),
                                   finished.max_end));
  if (!same.ok() && !options_.replace) return same;
  if (!same.ok()) {
    warn(same.error().message + ": starting over");
    found_.reset();
    return {};
  }
  report_.spp_before =
      finished.total / static_cast<double>(std::max<int64_t>(1, found_->state.coverage.area().pixel_count()));
  report_.work = found_->state.work;
  if (from_previous_) restore_previous();
  if (messages_.note)
    messages_.note(fmt::format("resuming from {}, which has {:.1f} of {} samples per pixel", options_.file.string(),
                               report_.spp_before, identity.part.count()));
  return {};
}

// Gives the previous generation the name of the checkpoint: if it is complete already, no save will
// follow.
void Checkpoint::restore_previous() {
  const Result<void> written = write_accumulation(options_.file, found_->identity, found_->state, false);
  if (!written.ok()) warn(written.error().message);
}

void Checkpoint::warn(const std::string& message) const {
  if (messages_.warning) messages_.warning(message);
}

double Checkpoint::done_share() const {
  return std::clamp(report_.spp_before / std::max(1U, identity_.part.count()), 0.0, 1.0);
}

RenderContinuity Checkpoint::continuity() {
  RenderContinuity continuity;
  if (found_) continuity.resume_from = std::move(found_->state);
  found_.reset();
  continuity.save_every_s = options_.every_s;
  continuity.save = [this](const RenderState& state) { save(state); };
  return continuity;
}

void Checkpoint::save(const RenderState& state) {
  const Stopwatch clock;
  last_save_ = write_accumulation(options_.file, identity_, state, true);
  report_.save_s += clock.elapsed().wall_s;
  report_.work = state.work;
  if (last_save_.ok()) {
    ++report_.saves;
    return;
  }
  ++report_.failed_saves;
  warn(fmt::format("{}; the render continues, and the previous checkpoint is kept", last_save_.error().message));
}

Result<AccumulationIdentity> read_checkpoint_identity(const fs::path& file) {
  const fs::path previous = previous_accumulation(file);
  Result<AccumulationSummary> summary = read_accumulation_summary(file);
  if (summary.ok()) return std::move(summary.value().identity);
  const Error wrong = summary.error();
  if (file_exists(previous)) summary = read_accumulation_summary(previous);
  if (summary.ok()) return std::move(summary.value().identity);
  return wrong;
}

} // namespace kindling
