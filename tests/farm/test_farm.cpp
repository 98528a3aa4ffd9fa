// Temporary folders and scripts for the tests of farms.
// SPDX-License-Identifier: Apache-2.0
#include "tests/farm/test_farm.h"

#include <unistd.h>

#include <fstream>
#include <sstream>

namespace kindling::test {

FarmFolder::FarmFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "kindling-farm-XXXXXX").string();
  folder_ = mkdtemp(name.data());
}

FarmFolder::~FarmFolder() {
  std::error_code error;
  std::filesystem::remove_all(folder_, error);
}

FarmPlan FarmFolder::make_plan(const std::string& body, int parts, std::vector<int> frames) const {
  write_script("renderer", R"(while [ $# -gt 0 ]; do
  case $1 in -o) out=$2;; --checkpoint) checkpoint=$2;; --part) part=$2;; esac
  shift
done
)" + body);
  FarmPlan plan;
  plan.program = "test";
  plan.binary = folder_ / "renderer";
  plan.folder = folder_ / "farm";
  plan.scene = "/scene.glb";
  plan.working_folder = folder_;
  plan.frames = std::move(frames);
  plan.parts = parts;
  plan.outputs = {folder_ / (plan.frames.empty() ? "image.exr" : "image.####.exr")};
  const Result<void> written = write_new_plan(plan);
  EXPECT_TRUE(written.ok()) << (written.ok() ? "" : written.error().message);
  return plan;
}

void FarmFolder::write_script(const std::string& name, const std::string& body) const {
  std::filesystem::create_directories((folder_ / name).parent_path());
  std::ofstream(folder_ / name) << "#!/bin/sh\n" << body;
  std::filesystem::permissions(folder_ / name, std::filesystem::perms::owner_all);
}

std::string FarmFolder::read_text(const std::filesystem::path& path) const {
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

} // namespace kindling::test
