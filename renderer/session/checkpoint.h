// The checkpoint of a render: saved at intervals, resumed from, locked by one process.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/session/accumulation_file.h"
#include "renderer/session/file_lock.h"
#include "renderer/session/render_session.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kindling {

struct CheckpointOptions {
  static constexpr double kDefaultEverySeconds = 300.0;
  std::filesystem::path file; // .kacc; empty: no checkpoint
  double every_s = kDefaultEverySeconds;
  bool must_exist = false; // fail if there is no checkpoint to resume from
  bool replace = false;    // start over where the file belongs to another render or is damaged
  [[nodiscard]] bool enabled() const { return !file.empty(); }
};

// Statistics of a render's checkpoint, for reports.
struct CheckpointReport {
  std::string file;
  uint32_t saves = 0; // of this run
  uint32_t failed_saves = 0;
  double save_s = 0.0;     // wall seconds of all saves, part of the render phase
  double spp_before = 0.0; // mean samples per pixel at the start
  RenderWork work;         // of all runs
};

// Receives messages of one sentence. Either function may be empty.
struct CheckpointMessages {
  std::function<void(const std::string&)> warning;
  std::function<void(const std::string&)> note; // where a render resumes
};

// The files that belong to a checkpoint: its own, its previous generation, a damaged one, its lock.
[[nodiscard]] std::vector<std::filesystem::path> files_of_checkpoint(const std::filesystem::path& file);
// check_writable() for all of them.
[[nodiscard]] Result<void> check_checkpoint_file(const std::filesystem::path& file);

class Checkpoint {
 public:
  // Locks the file and reads it. If it is damaged or missing, reads its previous generation
  // instead, with a warning, and renames the damaged one to "FILE.damaged". Fails (input_output) if
  // another process renders to it, if its folder is not writable, if it does not exist but must, or
  // if it exists and neither generation can be read; with CheckpointOptions::replace the last is a
  // warning.
  [[nodiscard]] static Result<std::unique_ptr<Checkpoint>> open(const CheckpointOptions& options,
                                                                CheckpointMessages messages);

  // Sets the render that is saved from now on. The file must belong to the same render
  // (check_same_render()) and hold no samples beyond those wanted. Else fails (usage), or drops its
  // contents with a warning if CheckpointOptions::replace.
  [[nodiscard]] Result<void> begin(const AccumulationIdentity& identity);
  // Sets AccumulationIdentity::metadata, which is known later than the rest.
  void set_metadata(std::string metadata) { identity_.metadata = std::move(metadata); }
  // Returns the share of the wanted samples that the file has, in [0, 1].
  [[nodiscard]] double done_share() const;

  // Returns the state to resume from and the function that saves. May be called once, and this
  // object must outlive the render. A failed save is a warning, and is tried again at the next
  // interval.
  [[nodiscard]] RenderContinuity continuity();

  // Returns the error (input_output) of the last save if it failed; success before the first save.
  [[nodiscard]] const Result<void>& last_save() const { return last_save_; }
  [[nodiscard]] const CheckpointReport& report() const { return report_; }

 private:
  Checkpoint(const CheckpointOptions& options, CheckpointMessages messages, FileLock lock);
  [[nodiscard]] Result<void> read();
  void save(const RenderState& state);
  void restore_previous();
  void warn(const std::string& message) const;

  CheckpointOptions options_;
  CheckpointMessages messages_;
  FileLock lock_;
  std::optional<Accumulation> found_;
  bool from_previous_ = false;
  AccumulationIdentity identity_;
  Result<void> last_save_;
  CheckpointReport report_;
};

// Returns the identity stored in a checkpoint, or in its previous generation if the file cannot be
// read. Fails (input_output) if neither can be read.
[[nodiscard]] Result<AccumulationIdentity> read_checkpoint_identity(const std::filesystem::path& file);

} // namespace kindling
