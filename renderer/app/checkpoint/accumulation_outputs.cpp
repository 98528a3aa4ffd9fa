// Saves the sums of a render, or copies its checkpoint.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/checkpoint/accumulation_outputs.h"

#include "renderer/image/output_file.h"

namespace kindling::app {

namespace fs = std::filesystem;

namespace {

// Reads and rewrites the file, so that the copy is checked and complete.
Result<void> copy_accumulation(const fs::path& from, const fs::path& to) {
  Result<Accumulation> read = read_accumulation(from);
  if (!read.ok()) return read.error();
  return write_accumulation(to, read.value().identity, read.value().state, false);
}

} // namespace

AccumulationOutputs::AccumulationOutputs(const std::vector<fs::path>& outputs, const CheckpointOptions& checkpoint)
    : checkpoint_(checkpoint.file) {
  for (const fs::path& output : outputs) (is_accumulation(output) ? files_ : images_).push_back(output);
}

void AccumulationOutputs::join(const AccumulationIdentity& identity, RenderContinuity& continuity) {
  if (empty() || !checkpoint_.empty()) return;
  continuity.save = [this, identity](const RenderState& state) { save(identity, state); };
}

void AccumulationOutputs::save(const AccumulationIdentity& identity, const RenderState& state) {
  for (const fs::path& file : files_) {
    const Result<void> done = write_accumulation(file, identity, state, false);
    if (done.ok())
      written_.push_back(file.string());
    else if (!first_error_)
      first_error_ = done.error();
  }
}

void AccumulationOutputs::finish(WrittenImages& written) {
  if (!checkpoint_.empty())
    for (const fs::path& file : files_) {
      const bool same = FileIdentity(file) == FileIdentity(checkpoint_);
      const Result<void> done = same ? Result<void>() : copy_accumulation(checkpoint_, file);
      if (done.ok())
        written_.push_back(file.string());
      else if (!first_error_)
        first_error_ = done.error();
    }
  written.files.insert(written.files.begin(), written_.begin(), written_.end());
  written_.clear();
  if (first_error_) written.first_error = first_error_;
}

} // namespace kindling::app
