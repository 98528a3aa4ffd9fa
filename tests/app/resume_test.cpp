// Resumed renders: arguments, compatible checkpoints, and the lock on the file.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/checkpoint/resume.h"
#include "renderer/app/flags/parse_command_line.h"
#include "renderer/app/flags/resume_flags.h"
#include "renderer/app/options/options.h"
#include "renderer/app/options/resume_options.h"
#include "renderer/session/file_lock.h"
#include "renderer/session/render_identity.h"
#include "tests/app/test_scene.h"

#include <gtest/gtest.h>

#include <fstream>

namespace kindling::app {
namespace {

using Words = std::vector<std::string>;

Result<CommandLine> parse(const Words& words) {
  std::vector<const char*> arguments;
  for (const std::string& word : words) arguments.push_back(word.c_str());
  return parse_command_line(arguments);
}

ResumeOptions resume_options(const Words& flags) {
  Words words{"resume", "a.kacc"};
  words.insert(words.end(), flags.begin(), flags.end());
  const Result<CommandLine> line = parse(words);
  EXPECT_TRUE(line.ok()) << (line.ok() ? "" : line.error().message);
  return line.ok() ? std::get<ResumeOptions>(line.value().command) : ResumeOptions{};
}

AccumulationIdentity identity_of(const Words& arguments) {
  const Result<CommandLine> line = parse(arguments);
  EXPECT_TRUE(line.ok()) << (line.ok() ? "" : line.error().message);
  const RenderOptions& options = std::get<RenderOptions>(line.value().command);
  AccumulationIdentity identity = make_identity(options, options, {.size_px = V2i(64, 32)}, 5);
  identity.arguments = options.arguments;
  if (options.part.samples) identity.part = part_samples(options.samples_per_pixel(), *options.part.samples).value();
  return identity;
}

TEST(Resume, ParsesFlags) {
  const ResumeOptions options = resume_options(
      {"--spp",        "128",   "-o",        "x.png",  "-o",           "y.exr", "--folder",           "f",
       "--scene-file", "s.glb", "--threads", "3",      "--time-limit", "1h",    "--checkpoint-every", "90",
       "--progress",   "json",  "--stats",   "s.json", "--quiet"});
  EXPECT_EQ(options.file, "a.kacc");
  EXPECT_EQ(options.spp, 128U);
  EXPECT_EQ(options.outputs.size(), 2U);
  EXPECT_EQ(options.folder, "f");
  EXPECT_EQ(options.scene_file, "s.glb");
  EXPECT_EQ(options.threads, 3);
  EXPECT_EQ(options.time_limit_s, 3600.0);
  EXPECT_EQ(options.checkpoint_every_s, 90.0);
  EXPECT_EQ(options.progress, ProgressMode::json);
  EXPECT_TRUE(options.quiet);
}

TEST(Resume, IdentityStoresTheRequest) {
  const Words words{"render", "s.glb", "--spp", "32", "--planned-spp", "16", "--crop", "0,0,8,8"};
  const AccumulationIdentity identity = identity_of(words);
  EXPECT_EQ(identity.arguments, words);
  EXPECT_EQ(identity.folder, std::filesystem::current_path());
  EXPECT_EQ(identity.samples_per_pixel, 32U);
  EXPECT_EQ(identity.planned_samples, 16U);
  EXPECT_EQ(identity.part, (SampleRange{0, 32}));
  EXPECT_EQ(identity.crop.max, V2i(8, 8));
  EXPECT_EQ(identity.scene_hash, 5U);
}

TEST(Resume, PartStoresItsSamples) {
  EXPECT_EQ(identity_of({"render", "s.glb", "--spp", "32", "--part", "2/3"}).part, (SampleRange{10, 21}));
}

// Added samples continue the pattern, and stay requested when their run is interrupted.
TEST(Resume, AddedSamplesKeepThePlan) {
  const AccumulationIdentity identity = identity_of({"render", "s.glb", "--spp", "32"});
  EXPECT_EQ(resumed_arguments(identity, {}), identity.arguments);
  ResumeOptions more;
  more.spp = 48;
  const AccumulationIdentity longer = identity_of(resumed_arguments(identity, more));
  EXPECT_EQ(longer.samples_per_pixel, 48U);
  EXPECT_EQ(longer.planned_samples, 32U);
  EXPECT_EQ(longer.image, identity.image);
  EXPECT_TRUE(check_same_render(identity, "a.kacc", longer).ok());
  more.spp = 64;
  EXPECT_EQ(identity_of(resumed_arguments(longer, more)).planned_samples, 32U);
}

TEST(Resume, FlagsOfThisRunOverrideTheRender) {
  RenderOptions options;
  options.outputs = {"a.png"};
  options.threads = 1;
  options.quiet = true;
  options.checkpoint.every_s = 7.0;
  override_render({}, options);
  EXPECT_EQ(options.outputs.front(), "a.png");
  EXPECT_EQ(options.threads, 1);
  EXPECT_TRUE(options.quiet);
  EXPECT_EQ(options.checkpoint.every_s, 7.0);
  override_render(resume_options({"-o", "b.exr", "--threads", "0", "--verbose", "--checkpoint-every", "3"}), options);
  EXPECT_EQ(options.outputs, std::vector<std::filesystem::path>{"b.exr"});
  EXPECT_EQ(options.threads, 0);
  EXPECT_FALSE(options.quiet);
  EXPECT_EQ(options.checkpoint.every_s, 3.0);
  // A time limit does not request more samples than the render did.
  override_render(resume_options({"--time-limit", "5"}), options);
  EXPECT_EQ(options.samples_per_pixel(), kDefaultSamplesPerPixel);
}

TEST(Resume, RefusesDifferentRenders) {
  const AccumulationIdentity now = identity_of({"render", "s.glb", "--seed", "2"});
  const auto refusal = [&](AccumulationIdentity file) {
    const Result<void> same = check_same_render(file, "a.kacc", now);
    if (same.ok()) return std::string("accepted");
    EXPECT_EQ(same.error().kind, ErrorKind::usage);
    return same.error().message;
  };
  EXPECT_EQ(refusal(now), "accepted");
  EXPECT_EQ(
      refusal(identity_of({"render", "s.glb", "--seed", "1"})),
      "a.kacc: belongs to another render (--seed: 1 in the file, 2 here); use the same settings, or another file name");
  EXPECT_NE(refusal(identity_of({"render", "s.glb", "--seed", "2", "--spp", "8"}))
                .find("(to add samples: kindling resume a.kacc --spp N)"),
            std::string::npos);
  AccumulationIdentity other = now;
  other.scene_hash = 6;
  EXPECT_NE(refusal(other).find("the scene has changed since the render was started (hash 0000000000000006 then"),
            std::string::npos)
      << refusal(other);
  other = now;
  other.program = "Kindling 9.9";
  EXPECT_NE(refusal(other).find("was written by Kindling 9.9, this is Kindling "), std::string::npos) << refusal(other);
  other = now;
  other.part = {0, 21};
  EXPECT_EQ(refusal(other),
            "a.kacc: holds samples 0 to 20 of each pixel, but 0 to 63 are requested; use another file name");
}

class LockedFile : public test::SceneFolder {};

TEST_F(LockedFile, IsExclusive) {
  const std::filesystem::path file = folder_ / "a.kacc";
  {
    const Result<FileLock> first = FileLock::acquire(file);
    ASSERT_TRUE(first.ok()) << first.error().message;
    const Result<FileLock> second = FileLock::acquire(file);
    ASSERT_FALSE(second.ok());
    EXPECT_EQ(second.error().kind, ErrorKind::input_output);
    EXPECT_NE(second.error().message.find("is rendering to it"), std::string::npos) << second.error().message;
    EXPECT_NE(second.error().message.find("process "), std::string::npos) << second.error().message;
    EXPECT_TRUE(FileLock::acquire(folder_ / "b.kacc").ok());
  }
  EXPECT_FALSE(exists("a.kacc.lock"));
  std::ofstream(folder_ / "a.kacc.lock") << "process 1 on a machine that was switched off";
  EXPECT_TRUE(FileLock::acquire(file).ok());
  EXPECT_FALSE(FileLock::acquire(folder_ / "missing" / "a.kacc").ok());
}

} // namespace
} // namespace kindling::app
