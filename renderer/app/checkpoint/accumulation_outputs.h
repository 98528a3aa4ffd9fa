// The accumulation files among the outputs of a render: all sums, for `kindling merge`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/checkpoint_options.h"
#include "renderer/app/output/outputs.h"
#include "renderer/base/result.h"
#include "renderer/session/accumulation_file.h"
#include "renderer/session/render_session.h"

#include <filesystem>
#include <optional>
#include <vector>

namespace kindling::app {

class AccumulationOutputs {
 public:
  AccumulationOutputs(const std::vector<std::filesystem::path>& outputs, const CheckpointOptions& checkpoint);

  [[nodiscard]] bool empty() const { return files_.empty(); }
  // The outputs that are none.
  [[nodiscard]] const std::vector<std::filesystem::path>& images() const { return images_; }

  // Without a checkpoint: the state is written at the end of the render. With one it has been written to that and is copied by finish().
  void join(const AccumulationIdentity& identity, RenderContinuity& continuity);
  // Puts the names that were written before those of images, and the first error.
  void finish(WrittenImages& written);

 private:
  void save(const AccumulationIdentity& identity, const RenderState& state);

  std::vector<std::filesystem::path> files_;
  std::vector<std::filesystem::path> images_;
  std::filesystem::path checkpoint_; // empty: none
  std::vector<std::string> written_;
  std::optional<Error> first_error_;
};

} // namespace kindling::app
