// `render --checkpoint` and `resume` without faults of the machine, and refusals.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <sstream>

namespace kindling::test {
namespace {

class ResumeCommand : public SceneFolder {
 protected:
  [[nodiscard]] ProgramResult run(const std::vector<std::string>& arguments, const std::string& folder = ".") const {
    return run_program(arguments, folder_ / folder);
  }
  [[nodiscard]] std::vector<std::byte> pixels(const std::string& name) const {
    Result<Image> image = read_image_file(folder_ / name);
    EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
    return image.ok() ? image.value().pixels : std::vector<std::byte>();
  }
  // Renders a 40 x 36 image with these flags.
  [[nodiscard]] ProgramResult render(std::vector<std::string> flags) const {
    flags.insert(flags.begin(), {"render", "scene.gltf", "--size", "40x36", "--exr-float"});
    return run(flags);
  }
  void expect_refusal(const ProgramResult& result, int code, const std::string& words) const {
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
  }
};

TEST_F(ResumeCommand, AddedSamplesEqualOneRender) {
  write_scene();
  ASSERT_EQ(render({"--spp", "8", "-o", "a.exr", "--checkpoint", "a.kacc"}).exit_code, 0);
  ASSERT_EQ(render({"--spp", "20", "--planned-spp", "8", "-o", "whole.exr"}).exit_code, 0);
  ASSERT_EQ(render({"--spp", "8", "-o", "plain.exr"}).exit_code, 0);
  EXPECT_EQ(pixels("a.exr"), pixels("plain.exr"));
  const ProgramResult more = run({"resume", "a.kacc", "--spp", "20", "--stats", "s.json"});
  ASSERT_EQ(more.exit_code, 0) << more.err;
  EXPECT_NE(more.err.find("resuming from a.kacc, which has 8.0 of 20 samples per pixel"), std::string::npos)
      << more.err;
  EXPECT_EQ(pixels("a.exr"), pixels("whole.exr"));
  const nlohmann::json stats = nlohmann::json::parse(read_file("s.json"));
  EXPECT_EQ(stats["checkpoint"]["runs"], 2);
  EXPECT_EQ(stats["checkpoint"]["spp_before"], 8.0);
  EXPECT_EQ(stats["checkpoint"]["saves"], 1);
  EXPECT_EQ(stats["spp"], 20);
  // A second time there is nothing to add, and the images are written again.
  std::filesystem::remove(folder_ / "a.exr");
  EXPECT_EQ(run({"resume", "a.kacc"}).exit_code, 0);
  EXPECT_EQ(pixels("a.exr"), pixels("whole.exr"));
  expect_refusal(run({"resume", "a.kacc", "--spp", "19"}), 2, "--spp: 19 is below the 20 samples that a.kacc has");
}

TEST_F(ResumeCommand, ProgressContinuesFromTheCheckpoint) {
  write_scene();
  const auto render_events = [](const ProgramResult& result) {
    std::vector<nlohmann::json> events;
    std::istringstream lines(result.err);
    for (std::string line; std::getline(lines, line);) {
      nlohmann::json event = nlohmann::json::parse(line);
      if (event["event"] == "progress" && event["phase"] == "render") events.push_back(std::move(event));
    }
    EXPECT_FALSE(events.empty()) << result.err;
    return events;
  };
  ASSERT_EQ(render({"--spp", "8", "-o", "a.exr", "--checkpoint", "a.kacc", "--guiding", "on"}).exit_code, 0);
  for (const nlohmann::json& event : render_events(run({"resume", "a.kacc", "--spp", "12", "--progress", "json"}))) {
    EXPECT_GE(event["spp"].get<double>(), 8.0 - 1e-9) << event;
    EXPECT_GE(event["fraction"].get<double>(), 8.0 / 12.0 - 1e-9) << event;
    EXPECT_EQ(event["spp_wanted"], 12) << event;
  }
  for (const nlohmann::json& event : render_events(render({"--spp", "8", "--part", "2/4", "--progress", "json"})))
    EXPECT_EQ(event["spp_wanted"], 2) << event;
}

TEST_F(ResumeCommand, SameRenderResumesAndAnotherIsRefused) {
  write_scene();
  const std::vector<std::string> flags{"--spp", "4", "-o", "a.exr", "--checkpoint", "a.kacc"};
  ASSERT_EQ(render(flags).exit_code, 0);
  const ProgramResult again = render(flags);
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.err.find("resuming from a.kacc"), std::string::npos) << again.err;
  std::vector<std::string> other = flags;
  other.insert(other.end(), {"--seed", "5"});
  expect_refusal(render(other), 2, "a.kacc: belongs to another render (--seed: 0 in the file, 5 here)");
}

TEST_F(ResumeCommand, NamesMissingFoldersAsGiven) {
  write_scene();
  ASSERT_EQ(render({"--spp", "1", "-o", "a.exr", "--checkpoint", "a.kacc"}).exit_code, 0);
  expect_refusal(run({"resume", "a.kacc", "--folder", "none"}), 4, "--folder: '");
  std::filesystem::create_directory(folder_ / "moved");
  std::filesystem::rename(folder_ / "a.kacc", folder_ / "moved" / "a.kacc");
  const std::filesystem::path before = folder_;
  std::filesystem::rename(before, before.string() + "_gone");
  const ProgramResult gone = run_program({"resume", "a.kacc"}, before.string() + "_gone/moved");
  std::filesystem::rename(before.string() + "_gone", before);
  expect_refusal(gone, 4, "was started in folder '");
  EXPECT_NE(gone.err.find("name the folder of its files with --folder"), std::string::npos) << gone.err;
}

TEST_F(ResumeCommand, WorksFromAnyFolder) {
  write_scene();
  std::filesystem::create_directory(folder_ / "sub");
  ASSERT_EQ(render({"--spp", "4", "-o", "a.exr", "--checkpoint", "a.kacc"}).exit_code, 0);
  const std::vector<std::byte> whole = pixels("a.exr");
  std::filesystem::remove(folder_ / "a.exr");
  const ProgramResult result = run({"resume", "../a.kacc", "-o", "b.exr"}, "sub");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(pixels("sub/b.exr"), whole);
  EXPECT_EQ(run({"resume", "../a.kacc"}, "sub").exit_code, 0);
  EXPECT_EQ(pixels("a.exr"), whole);
}

TEST_F(ResumeCommand, DefaultNamesAreTheSameFromAnyFolder) {
  write_scene();
  std::filesystem::create_directory(folder_ / "sub");
  const std::vector<std::pair<std::vector<std::string>, std::string>> kinds{
      {{}, "scene.png"}, {{"--part", "1/2"}, "scene-part-1-of-2.kacc"}, {{"--frames", "7"}, "scene-0007.png"}};
  for (const auto& [flags, name] : kinds) {
    std::vector<std::string> all{"--spp", "4", "--checkpoint", "a_#.kacc"};
    all.insert(all.end(), flags.begin(), flags.end());
    ASSERT_EQ(render(all).exit_code, 0);
    ASSERT_TRUE(std::filesystem::remove(folder_ / name)) << name;
    const std::string checkpoint = flags == std::vector<std::string>{"--frames", "7"} ? "a_7.kacc" : "a_#.kacc";
    const ProgramResult resumed = run({"resume", "../" + checkpoint}, "sub");
    EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
    EXPECT_TRUE(std::filesystem::exists(folder_ / name)) << name << ": " << resumed.out;
    std::filesystem::remove(folder_ / checkpoint);
  }
}

TEST_F(ResumeCommand, DetectsChangedEnvironmentsAndScenes) {
  write_scene();
  ASSERT_EQ(render({"--spp", "2", "-o", "a.exr", "--checkpoint", "a.kacc"}).exit_code, 0);
  write_file("scene.gltf", read_file("scene.gltf") + "\n");
  expect_refusal(run({"resume", "a.kacc"}), 2, "the scene has changed since the render was started");
  write_scene();
  ASSERT_EQ(render({"--spp", "2", "-o", "sky.exr"}).exit_code, 0);
  std::filesystem::copy_file(folder_ / "a.exr", folder_ / "env.exr");
  ASSERT_EQ(render({"--spp", "2", "-o", "b.exr", "--env", "env.exr", "--checkpoint", "b.kacc"}).exit_code, 0);
  ASSERT_EQ(render({"--spp", "3", "-o", "env.exr"}).exit_code, 0);
  expect_refusal(run({"resume", "b.kacc"}), 2, "b.kacc: belongs to another render (--env: ");
}

// The complete one too, with which nothing is rendered and saved.
TEST_F(ResumeCommand, PreviousGenerationReplacesADamagedFile) {
  write_scene();
  const std::vector<std::string> flags{"--spp", "4", "--checkpoint", "a.kacc"};
  std::vector<std::string> again = flags;
  again.insert(again.end(), {"-o", "b.exr", "-o", "b.kacc"});
  ASSERT_EQ(render({"--spp", "4", "-o", "plain.exr", "--checkpoint", "a.kacc"}).exit_code, 0);
  ASSERT_EQ(run({"resume", "a.kacc", "--spp", "8", "-o", "more.exr"}).exit_code, 0);
  for (const bool is_there : {true, false}) {
    if (is_there)
      std::filesystem::resize_file(folder_ / "a.kacc", 300);
    else
      std::filesystem::remove(folder_ / "a.kacc");
    const ProgramResult result = render(again);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.err.find("resuming from a.kacc.previous, which is older"), std::string::npos) << result.err;
    EXPECT_EQ(pixels("b.exr"), pixels("plain.exr"));
    EXPECT_EQ(read_file("b.kacc"), read_file("a.kacc"));
    EXPECT_EQ(run({"merge", "b.kacc", "-o", "c.exr", "--exr-float"}).exit_code, 0);
    EXPECT_EQ(pixels("c.exr"), pixels("plain.exr"));
  }
}

TEST_F(ResumeCommand, RefusesWrongRequests) {
  write_scene();
  expect_refusal(run({"resume"}), 2, "no checkpoint; use 'kindling resume FILE.kacc'");
  expect_refusal(run({"resume", "a.exr"}), 2, "must end in .kacc");
  expect_refusal(run({"resume", "a.kacc"}), 4, "a.kacc: ");
  expect_refusal(render({"--checkpoint", "a.exr"}), 2, "--checkpoint: a.exr: the name must end in .kacc");
  expect_refusal(render({"--checkpoint", "missing/a.kacc"}), 4, "folder 'missing' does not exist");
  expect_refusal(render({"--checkpoint-every", "5"}), 2, "--checkpoint-every: has no meaning without --checkpoint");
  expect_refusal(render({"--checkpoint", "a.kacc", "--pixel", "1,1"}), 2, "--checkpoint and --pixel: give one of them");
}

} // namespace
} // namespace kindling::test
