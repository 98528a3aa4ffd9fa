// Options of the actions of `kindling farm`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/distributed/farm_plan.h"

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

namespace kindling::app {

struct FarmSubmitOptions {
  std::filesystem::path scene_file;
  std::filesystem::path folder;
  std::vector<std::filesystem::path> outputs; // #### is the frame number
  int parts = 0;
  std::vector<int> frames; // empty: one image
  int retries = 2;
  std::string engine = "slurm";
  FarmResources resources;
  bool check_scene = true;
  std::vector<std::string> render_flags;
};

enum class FarmAction { status, work, merge, retry };
// An action on the folder of a farm.
struct FarmFolderOptions {
  FarmAction action = FarmAction::status;
  std::filesystem::path folder;
  int task = 0;      // for FarmAction::work
  bool json = false; // for FarmAction::status
};

using FarmOptions = std::variant<FarmSubmitOptions, FarmFolderOptions>;

} // namespace kindling::app
