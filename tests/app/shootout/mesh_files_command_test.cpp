// The commands that load scenes take .ply, .obj and .stl files.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

namespace kindling::test {
namespace {

class MeshFiles : public SceneFolder {
 protected:
  void SetUp() override {
    SceneFolder::SetUp();
    write_file("house.obj",
               "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\nf 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n");
  }
};

TEST_F(MeshFiles, AreRenderedDescribedAndRaced) {
  const ProgramResult info = run_program({"info", "house.obj"}, folder_);
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_NE(info.out.find("6 in the file"), std::string::npos) << info.out;
  const ProgramResult render = run_program(
      {"render", "house.obj", "-o", "a.png", "--size", "16x16", "--spp", "1", "--progress", "none"}, folder_);
  EXPECT_EQ(render.exit_code, 0) << render.err;
  EXPECT_TRUE(exists("a.png"));
  const ProgramResult shootout = run_program({"shootout", "house.obj", "--accel", "kdtree,embree", "--rays-per-kind",
                                              "200", "--repeat", "1", "--build-repeat", "1", "--size", "32x32"},
                                             folder_);
  EXPECT_EQ(shootout.exit_code, 0) << shootout.err;
  EXPECT_NE(shootout.out.find("6 triangles"), std::string::npos) << shootout.out;
}

TEST_F(MeshFiles, FaultsAndConflictsAreReported) {
  write_file("broken.obj", "v 0 0 0\nf 1 2 3\n");
  const ProgramResult broken = run_program({"render", "broken.obj"}, folder_);
  EXPECT_EQ(broken.exit_code, 3);
  EXPECT_EQ(broken.err, "kindling: error: broken.obj: line 2: index 2; there are 1 vertices so far\n");
  const ProgramResult conflict = run_program({"shootout", "house.obj", "--json", "house.obj"}, folder_);
  EXPECT_EQ(conflict.exit_code, 2) << conflict.err;
  const ProgramResult missing = run_program({"info", "none.stl"}, folder_);
  EXPECT_EQ(missing.exit_code, 4) << missing.err;
}

} // namespace
} // namespace kindling::test
