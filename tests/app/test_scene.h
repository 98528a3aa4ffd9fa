// A test fixture with a folder of its own, and small glTF scenes in it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace kindling::test {

struct TestSceneOptions {
  bool camera = true;
  bool light = true;
  int grid = 1;                 // grid x grid quads
  std::string extra;            // further top-level members, each with a leading comma
  int accessor_count_delta = 0; // other than 0: the file is broken
};

class SceneFolder : public testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  // A unit square in the plane z = 0 that faces a camera at z = 2 (image aspect 1); a point light
  // beside the camera. Writes NAME.gltf and NAME.bin; returns the name of the first.
  std::string write_scene(const std::string& name = "scene", const TestSceneOptions& options = {}) const;
  void write_file(const std::string& name, const std::string& contents) const;
  [[nodiscard]] std::string read_file(const std::string& name) const;
  [[nodiscard]] bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  std::filesystem::path folder_;
};

} // namespace kindling::test
