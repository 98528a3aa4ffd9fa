// Checkpoints of a render.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/checkpoint/checkpoint.h"

#include "renderer/app/checkpoint/accumulation_identity.h"
#include "renderer/app/output/outputs.h"
#include "renderer/app/terminal/stopwatch.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace kindling::app {

namespace fs = std::filesystem;

namespace {

fs::path with_suffix(const fs::path& file, const char* suffix) {
  fs::path path = file;
  path += suffix;
  return path;
}

bool is_there(const fs::path& file) {
  std::error_code ignored;
  return fs::exists(file, ignored);
}

// Samples of all pixels that are done, and the most of a pixel.
struct Done {
  double samples = 0.0;
  uint32_t most = 0;
};

Done count_done(const Coverage& coverage) {
  Done done;
  for (size_t i = 0; i < coverage.block_count(); ++i)
    for (const SampleRange& span : coverage[i].spans) {
      done.samples += static_cast<double>(span.count()) * static_cast<double>(coverage.block(i).pixel_count());
      done.most = std::max(done.most, span.end);
    }
  return done;
}

} // namespace

Checkpoint::Checkpoint(const CheckpointOptions& options, bool replace, Console& console, FileLock lock)
    : options_(options), replace_(replace), console_(console), lock_(std::move(lock)) {
  report_.file = options.file.string();
}

Result<std::unique_ptr<Checkpoint>> Checkpoint::open(const CheckpointOptions& options, bool replace, Console& console) {
  if (Result<void> writable = check_writable(options.file); !writable.ok())
    return Error{writable.error().kind, "--checkpoint: " + writable.error().message};
  Result<FileLock> lock = FileLock::acquire(options.file);
  if (!lock.ok()) return lock.error();
  std::unique_ptr<Checkpoint> checkpoint(new Checkpoint(options, replace, console, std::move(lock).value()));
  if (Result<void> read = checkpoint->read(); !read.ok()) return read.error();
  return checkpoint;
}

Result<void> Checkpoint::read() {
  const fs::path &file = options_.file, previous = previous_accumulation(file);
  std::optional<Error> wrong;
  if (is_there(file)) {
    Result<Accumulation> current = read_accumulation(file);
    if (current.ok()) {
      found_ = std::move(current).value();
      return {};
    }
    wrong = current.error();
  }
  if (is_there(previous)) {
    Result<Accumulation> older = read_accumulation(previous);
    if (older.ok()) {
      console_.warning(fmt::format("{}; going on from {}, which is older",
                                   wrong ? wrong->message : file.string() + ": is not there", previous.string()));
      found_ = std::move(older).value();
      from_previous_ = true;
    } else if (!wrong) {
      wrong = older.error();
    }
  }
  if (!found_ && !wrong && options_.must_exist)
    return Error{ErrorKind::input_output, file.string() + ": cannot be read: no such file"};
  if (!wrong) return {};
  if (!found_ && !replace_)
    return Error{wrong->kind, fmt::format("{}; remove it to begin anew, or use another name", wrong->message)};
  if (!found_) console_.warning(fmt::format("{}; beginning anew", wrong->message));
  // Or it would take the place of the good previous one.
  std::error_code code;
  if (is_there(file)) fs::rename(file, with_suffix(file, ".damaged"), code);
  if (code)
    return Error{ErrorKind::input_output, fmt::format("{}: cannot be put aside: {}", file.string(), code.message())};
  return {};
}

Result<void> Checkpoint::begin(const AccumulationIdentity& identity) {
  identity_ = identity;
  if (!found_) return {};
  Result<void> same = check_same_render(found_->identity, options_.file, identity);
  const Done done = count_done(found_->state.coverage);
  if (same.ok() && done.most > identity.part.end)
    return Error{ErrorKind::usage,
                 fmt::format("--spp: {} is below the {} samples that {} has; use {} or more",
                             identity.samples_per_pixel, done.most, options_.file.string(), done.most)};
  if (!same.ok() && !replace_) return same;
  if (!same.ok()) {
    console_.warning(same.error().message + ": beginning anew");
    found_.reset();
    return {};
  }
  report_.spp_before =
      done.samples / static_cast<double>(std::max<int64_t>(1, found_->state.coverage.area().pixel_count()));
  report_.work = found_->state.work;
  if (from_previous_) put_back();
  console_.note(fmt::format("going on from {}, which has {:.1f} of {} samples per pixel", options_.file.string(),
                            report_.spp_before, identity.part.count()));
  return {};
}

// The previous generation has the name again: where it is complete already, no save will follow.
void Checkpoint::put_back() {
  const Result<void> written = write_accumulation(options_.file, found_->identity, found_->state, false);
  if (!written.ok()) console_.warning(written.error().message);
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
  const Clock::time_point start = Clock::now();
  last_save_ = write_accumulation(options_.file, identity_, state, true);
  report_.save_s += seconds_since(start);
  report_.work = state.work;
  if (last_save_.ok()) {
    ++report_.saves;
    return;
  }
  ++report_.failed_saves;
  console_.warning(fmt::format("{}; the render goes on, and what was saved before stays", last_save_.error().message));
}

Result<AccumulationIdentity> read_checkpoint_identity(const fs::path& file) {
  const fs::path previous = previous_accumulation(file);
  Result<AccumulationSummary> summary = read_accumulation_summary(file);
  if (summary.ok()) return std::move(summary.value().identity);
  const Error wrong = summary.error();
  if (is_there(previous)) summary = read_accumulation_summary(previous);
  if (summary.ok()) return std::move(summary.value().identity);
  return wrong;
}

} // namespace kindling::app
