// Keeps a render safe in a file, and finds there what it can go on from.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/checkpoint/file_lock.h"
#include "renderer/app/options/checkpoint_options.h"
#include "renderer/app/output/checkpoint_report.h"
#include "renderer/app/terminal/console.h"
#include "renderer/base/result.h"
#include "renderer/session/accumulation_file.h"
#include "renderer/session/render_session.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace kindling::app {

// One process at a time has it.
class Checkpoint {
 public:
  // Locks the file and reads it, or its previous generation if it is damaged or gone: then the damaged one is put aside as
  // "FILE.damaged", with a warning. `replace`: what cannot be read is put aside and no error. Fails (input_output) if another process is
  // rendering to it, if its folder cannot be written to, or if it is there and cannot be read.
  [[nodiscard]] static Result<std::unique_ptr<Checkpoint>> open(const CheckpointOptions& options, bool replace,
                                                                Console& console);

  // Which image it is for from now on. What was read must be of the same one and have no samples beyond those wanted; else fails
  // (usage), or with `replace` is dropped with a warning.
  [[nodiscard]] Result<void> begin(const AccumulationIdentity& identity);
  // AccumulationIdentity::metadata, which is known later than the rest.
  void set_metadata(std::string metadata) { identity_.metadata = std::move(metadata); }
  // Of the samples that `identity` wants, the share that is there, in [0, 1].
  [[nodiscard]] double done_share() const;

  // What render() goes on from and saves with; once. A save that fails is a warning, and tried again at the next interval.
  [[nodiscard]] RenderContinuity continuity();

  // The last save, if there was one: fails (input_output) if it did.
  [[nodiscard]] const Result<void>& last_save() const { return last_save_; }
  [[nodiscard]] const CheckpointReport& report() const { return report_; }

 private:
  Checkpoint(const CheckpointOptions& options, bool replace, Console& console, FileLock lock);
  [[nodiscard]] Result<void> read();
  void save(const RenderState& state);
  void put_back();

  CheckpointOptions options_;
  bool replace_;
  Console& console_;
  FileLock lock_;
  std::optional<Accumulation> found_;
  bool from_previous_ = false;
  AccumulationIdentity identity_;
  Result<void> last_save_;
  CheckpointReport report_;
};

// The identity of what is in a checkpoint, or in its previous generation if it cannot be read. Fails (input_output).
[[nodiscard]] Result<AccumulationIdentity> read_checkpoint_identity(const std::filesystem::path& file);

} // namespace kindling::app
