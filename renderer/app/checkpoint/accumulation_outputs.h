// Writes the .kacc files among the outputs of a render.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/output/outputs.h"
#include "renderer/base/result.h"
#include "renderer/session/accumulation_file.h"
#include "renderer/session/checkpoint.h"
#include "renderer/session/render_session.h"

#include <filesystem>
#include <optional>
#include <vector>

namespace kindling::app {

class AccumulationOutputs {
 public:
  AccumulationOutputs(const std::vector<std::filesystem::path>& outputs, const CheckpointOptions& checkpoint);

  [[nodiscard]] bool empty() const { return files_.empty(); }
  // Returns the outputs that are images.
  [[nodiscard]] const std::vector<std::filesystem::path>& images() const { return images_; }

  // Without a checkpoint, sets the function that writes the files at the end of the render. With
  // one, finish() copies the checkpoint.
  void join(const AccumulationIdentity& identity, RenderContinuity& continuity);
  // Adds the names of the written files before those of images, and the first error.
  void finish(WrittenImages& written);

 private:
  void save(const AccumulationIdentity& identity, const RenderState& state);

  std::vector<std::filesystem::path> files_;
  std::vector<std::filesystem::path> images_;
  std::filesystem::path checkpoint_; // empty: no checkpoint
  std::vector<std::string> written_;
  std::optional<Error> first_error_;
};

} // namespace kindling::app
