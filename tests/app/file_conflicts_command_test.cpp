// Files that a command must not overwrite, wait for, or read: refused before the work.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <cstdlib>
#include <filesystem>
#include <map>

#include <sys/stat.h>

namespace kindling::test {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

constexpr const char* kLamp = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n100 100\n";

class FileConflicts : public SceneFolder {
 protected:
  void SetUp() override {
    SceneFolder::SetUp();
    TestSceneOptions options;
    options.light = false;
    options.extra = R"(,"images":[{"uri":"texture.png"}],"extensionsUsed":["EXT_lights_ies"],)"
                    R"("extensions":{"EXT_lights_ies":{"lights":[{"uri":"lamp.ies"}]}})";
    scene_ = write_scene("scene", options);
    for (const char* name : {"texture.png", "kept.png"}) write_file(name, "precious"); // no material uses the texture
    write_file("lamp.ies", kLamp);
  }
  [[nodiscard]] ProgramResult render(const Words& flags) const {
    Words words{"render", scene_, "--size", "8x8", "--spp", "1", "-q"};
    words.insert(words.end(), flags.begin(), flags.end());
    Program program(words, folder_);
    return program.finish(std::chrono::seconds(30)); // -9 if it blocks
  }
  // The contents of all files.
  [[nodiscard]] std::map<std::string, std::string> contents() const {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::directory_iterator(folder_))
      if (entry.is_regular_file()) all[entry.path().filename().string()] = read_file(entry.path().filename().string());
    return all;
  }
  void expect_refused(const ProgramResult& result, int code, const std::string& message) const {
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_NE(result.err.find(message), std::string::npos) << result.err;
    EXPECT_EQ(result.err_lines().size(), 1U) << result.err;
  }

  std::string scene_;
};

TEST_F(FileConflicts, OutputsAreNoInputs) {
  ASSERT_EQ(render({"-o", "env.exr"}).exit_code, 0);
  fs::create_hard_link(folder_ / "env.exr", folder_ / "hard.exr");
  fs::create_symlink("env.exr", folder_ / "soft.exr");
  fs::create_symlink("scene.gltf", folder_ / "scene.json");
  fs::create_hard_link(folder_ / "texture.png", folder_ / "hard.png");
  fs::create_symlink("scene.bin", folder_ / "buffer.json");
  fs::create_directory(folder_ / "sub");
  const auto before = contents();
  const std::string overwritten = "it would be overwritten: use another name";
  for (const char* name : {"env.exr", "./env.exr", "sub/../env.exr", "hard.exr", "soft.exr"})
    expect_refused(render({"--env", "env.exr", "-o", name}), 2,
                   "--output: " + std::string(name) + ": is the file of --env as well");
  expect_refused(render({"-o", "a.png", "--stats", "scene.json"}), 2, "--stats: scene.json: is the scene as well");
  expect_refused(render({"-o", "texture.png"}), 2, "--output: texture.png: is a file of the scene as well");
  expect_refused(render({"-o", "hard.png"}), 2, "by the name 'texture.png'; " + overwritten);
  expect_refused(render({"-o", "a.png", "--stats", "buffer.json"}), 2, "by the name 'scene.bin'");
  expect_refused(render({"-o", "a.png", "--stats", "lamp.ies"}), 2, "is a file of the scene as well");
  expect_refused(render({"-o", "a_#.png", "--stats", "lamp.ies", "--frames", "1-2"}), 2, "is a file of the scene");
  EXPECT_TRUE(contents() == before) << "a file has changed";
}

// All scenes are asked for their files before the first is loaded: nothing is measured or printed.
TEST_F(FileConflicts, ReportsOfMeasurementsAreNoInputs) {
  fs::create_symlink("scene.bin", folder_ / "buffer.json");
  const std::string first = write_scene("first");
  const auto before = contents();
  const auto measure = [&](const Words& command, const Words& flags) {
    Words words = command;
    words.insert(words.end(), {first, scene_, "--size", "8x8"});
    words.insert(words.end(), flags.begin(), flags.end());
    Program program(words, folder_);
    return program.finish(std::chrono::seconds(60));
  };
  const auto refused = [&](const ProgramResult& result, const std::string& message) {
    expect_refused(result, 2, message);
    EXPECT_EQ(result.out, "");
  };
  const Words scaling{"scaling", "--spp", "1", "--threads", "1"};
  refused(measure(scaling, {"--json", "scene.gltf"}), "--json: scene.gltf: is the scene as well");
  refused(measure(scaling, {"--json", "buffer.json"}), "--json: buffer.json: is a file of the scene as well");
  refused(measure(scaling, {"--csv", "lamp.ies"}), "--csv: lamp.ies: is a file of the scene as well");
  refused(measure(scaling, {"--svg", "texture.png"}), "--svg: texture.png: is a file of the scene as well");
  const Words shootout{"shootout", "--rays-per-kind", "64", "--repeat", "1", "--build-repeat", "1"};
  refused(measure(shootout, {"--json", "first.bin"}), "--json: first.bin: is a file of the scene as well");
  refused(measure(shootout, {"--html", "buffer.json"}), "--html: buffer.json: is a file of the scene as well");
  refused(measure(shootout, {"--csv", "lamp.ies"}), "--csv: lamp.ies: is a file of the scene as well");
  expect_refused(measure(shootout, {"no.gltf"}), 4, "no.gltf");
  EXPECT_TRUE(contents() == before) << "a file has changed";
}

TEST_F(FileConflicts, ViewsOfAConfigurationKeepTheirFiles) {
  write_file("lut.spi1d", "Version 1\nFrom 0 1\nLength 2\nComponents 1\n{\n0\n1\n}\n");
  write_file("config.ocio", R"(ocio_profile_version: 1
search_path: .
roles:
  scene_linear: linear
  default: linear
displays:
  screen:
    - !<View> {name: plain, colorspace: curve}
colorspaces:
  - !<ColorSpace>
    name: linear
  - !<ColorSpace>
    name: curve
    from_reference: !<FileTransform> {src: lut.spi1d}
)");
  fs::create_symlink("lut.spi1d", folder_ / "lut.json");
  const auto before = contents();
  expect_refused(render({"--ocio", "config.ocio", "-o", "a.png", "--stats", "config.ocio"}), 2,
                 "is the file of --ocio as well");
  expect_refused(render({"--ocio", "config.ocio", "-o", "a.png", "--stats", "lut.json"}), 2,
                 "is a file of the OpenColorIO configuration as well");
  EXPECT_TRUE(contents() == before) << "a file has changed";
  EXPECT_EQ(render({"--ocio", "config.ocio", "-o", "a.png"}).exit_code, 0);
}

TEST_F(FileConflicts, OutputsDiffer) {
  fs::create_hard_link(folder_ / "kept.png", folder_ / "hard.png");
  fs::create_symlink("new.exr", folder_ / "soft.exr");
  const auto before = contents();
  expect_refused(render({"-o", "kept.png", "-o", "hard.png"}), 2, "by the name 'kept.png'; use another name");
  expect_refused(render({"-o", "new.exr", "-o", "soft.exr"}), 2, "by the name 'new.exr'");
  expect_refused(render({"-o", "a.exr", "-o", "./a.exr"}), 2, "--output: ./a.exr: given twice");
  expect_refused(render({"-o", "a.exr", "--stats", "a.exr"}), 2, "--stats: a.exr: is a file of --output as well");
  expect_refused(render({"-o", "a.exr", "--stats", "c.kacc.previous", "--checkpoint", "c.kacc"}), 2,
                 "is a file of --stats as well");
  EXPECT_TRUE(contents() == before) << "a file has changed";
  EXPECT_EQ(render({"-o", "c.kacc", "--checkpoint", "c.kacc"}).exit_code, 0); // one file with the same sums
}

TEST_F(FileConflicts, MergesKeepTheirParts) {
  for (const char* part : {"1/2", "2/2"}) {
    Words words{"--spp", "2", "--part", part, "-o", std::string("part") + part[0] + ".kacc"};
    ASSERT_EQ(render(words).exit_code, 0);
  }
  fs::create_symlink("part1.kacc", folder_ / "image.exr");
  const auto before = contents();
  expect_refused(run_program({"merge", "part1.kacc", "part2.kacc", "-o", "image.exr"}, folder_), 2,
                 "is a part as well, by the name 'part1.kacc'");
  expect_refused(run_program({"merge", "part1.kacc", "part2.kacc", "-o", "a.exr", "--stats", "part2.kacc"}, folder_), 2,
                 "is a part as well");
  EXPECT_TRUE(contents() == before) << "a file has changed";
}

// A pipe without a reader would block the program.
TEST_F(FileConflicts, PipesAndDevicesAreRefused) {
  for (const char* name : {"p.png", "p.kacc", "p.json", "c.kacc.lock", "d.kacc.previous", "e.kacc.damaged"})
    ASSERT_EQ(mkfifo((folder_ / name).c_str(), 0600), 0);
  expect_refused(render({"-o", "p.png"}), 4, "p.png: is a pipe; use the name of a file");
  expect_refused(render({"-o", "p.kacc"}), 4, "p.kacc: is a pipe");
  expect_refused(render({"-o", "a.png", "--stats", "p.json"}), 4, "--stats: p.json: is a pipe");
  expect_refused(render({"-o", "a.png", "--stats", "/dev/null"}), 4, "--stats: /dev/null: is a device");
  expect_refused(render({"-o", "a.png", "--stats", "/dev/stdout"}), 4, "or - for standard output");
  expect_refused(render({"-o", "a.png", "--checkpoint", "p.kacc"}), 4, "--checkpoint: p.kacc: is a pipe");
  expect_refused(render({"-o", "a.png", "--checkpoint", "c.kacc"}), 4, "'c.kacc.lock' beside it is a pipe");
  expect_refused(render({"-o", "a.png", "--checkpoint", "d.kacc"}), 4, "'d.kacc.previous' beside it is a pipe");
  expect_refused(render({"-o", "a.png", "--checkpoint", "e.kacc"}), 4, "'e.kacc.damaged' beside it is a pipe");
  EXPECT_FALSE(exists("a.png"));
}

TEST_F(FileConflicts, LocksAreNoLinks) {
  write_file("victim", "precious");
  fs::create_symlink("victim", folder_ / "c.kacc.lock");
  expect_refused(render({"-o", "a.png", "--checkpoint", "c.kacc"}), 4, "'c.kacc.lock' beside it is a symbolic link");
  EXPECT_EQ(read_file("victim"), "precious");
}

TEST_F(FileConflicts, LongNamesAndVanishedFoldersAreRefused) {
  expect_refused(render({"-o", std::string(260, 'a') + ".png"}), 4, "the name has 264 bytes; use at most 255");
  expect_refused(render({"-o", "a.png", "--checkpoint", std::string(248, 'c') + ".kacc"}), 4,
                 "the name has 253 bytes; use at most 246");
  Program program({"render", (folder_ / scene_).string(), "-o", "a.png"}, folder_, Output::pipe,
                  "mkdir gone && cd gone && rmdir ../gone");
  expect_refused(program.finish(), 4, "a.png: folder '.' was deleted; use another one");
}

// A file outside of the scene's folder is not read, and nothing of it is printed.
TEST_F(FileConflicts, LinksOutOfTheSceneAreRefused) {
  fs::create_directories(folder_ / "shot/inside");
  write_file("secret", "root:x:0:0 hunter2");
  for (const char* kind : {"buffers", "images", "lights"}) {
    SCOPED_TRACE(kind);
    std::string text = read_file("scene.gltf");
    const auto move = [&](const std::string& name, bool out) {
      fs::remove(folder_ / "shot" / name);
      if (out)
        fs::create_symlink("../secret", folder_ / "shot" / name);
      else
        fs::copy_file(folder_ / name, folder_ / "shot" / name);
    };
    move("scene.bin", kind == std::string("buffers"));
    move("texture.png", kind == std::string("images"));
    move("lamp.ies", kind == std::string("lights"));
    write_file("shot/scene.gltf", text);
    for (const Words& command : {Words{"render", "shot/scene.gltf", "-q"}, Words{"info", "shot/scene.gltf"}}) {
      const ProgramResult result = run_program(command, folder_);
      expect_refused(result, 3,
                     "is a symbolic link that leads out of the folder of the scene; copy the file there, or "
                     "accept such links with --follow-links");
      EXPECT_NE(result.err.find(kind), std::string::npos) << result.err;
      EXPECT_EQ((result.out + result.err).find("hunter2"), std::string::npos);
    }
  }
}

TEST_F(FileConflicts, LinksAreFollowedInsideAndOnRequest) {
  fs::create_directories(folder_ / "shot/inside");
  for (const char* name : {"scene.gltf", "lamp.ies", "texture.png"})
    fs::copy_file(folder_ / name, folder_ / "shot" / name);
  fs::copy_file(folder_ / "scene.bin", folder_ / "shot/inside/data");
  fs::create_symlink("inside/data", folder_ / "shot/scene.bin");
  const Words command{"render", "shot/scene.gltf", "--size", "8x8", "--spp", "1", "-o", "a.png"};
  EXPECT_EQ(run_program(command, folder_).exit_code, 0);
  fs::remove(folder_ / "shot/scene.bin");
  fs::create_symlink("../scene.bin", folder_ / "shot/scene.bin");
  EXPECT_EQ(run_program(command, folder_).exit_code, 3);
  Words followed = command;
  followed.emplace_back("--follow-links");
  EXPECT_EQ(run_program(followed, folder_).exit_code, 0);
  fs::create_symlink("shot/scene.gltf", folder_ / "entry.gltf"); // the scene itself may be a link
  EXPECT_EQ(run_program({"info", "entry.gltf"}, folder_).exit_code, 0);
}

} // namespace
} // namespace kindling::test
