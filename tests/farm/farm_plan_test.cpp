// Tests of farm plans: task numbers, file names, and the plan's own file.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/farm_plan.h"

#include "renderer/distributed/farm_worker.h"
#include "renderer/distributed/json_file.h"
#include "tests/farm/test_farm.h"

#include <fstream>
#include <limits>

#include <sys/stat.h>
#include <unistd.h>

namespace kindling::test {
namespace {

class Plan : public FarmFolder {};

TEST_F(Plan, TasksAreOrderedByFrame) {
  const FarmPlan plan = make_plan("", 3, {10, 12});
  ASSERT_EQ(plan.task_count(), 6);
  EXPECT_EQ(plan.task(2).part, 3);
  EXPECT_EQ(plan.task(2).frame, 10);
  EXPECT_EQ(plan.task(3).part, 1);
  EXPECT_EQ(plan.task(3).frame, 12);
  EXPECT_EQ(plan.part_file(plan.task(5)).filename(), "frame-0012-part-003.kacc");
  EXPECT_EQ(plan.outputs_of(1)[0].filename(), "image.0012.exr");
}

TEST_F(Plan, HasOneImageWithoutFrames) {
  const FarmPlan plan = make_plan("", 4);
  EXPECT_EQ(plan.task_count(), 4);
  EXPECT_FALSE(plan.task(3).frame);
  EXPECT_EQ(plan.part_file(plan.task(3)).filename(), "part-004.kacc");
  EXPECT_EQ(plan.outputs_of(0)[0], folder_ / "image.exr");
}

TEST_F(Plan, SurvivesWritingAndReading) {
  FarmPlan plan = make_plan("", 4, {1, 2});
  std::filesystem::remove(plan.folder / "plan.json");
  plan.flags = {"--spp", "16", "--view", "Raw \"quoted\""};
  plan.resources = {"fast", 8, "4G", "1:00"};
  plan.retries = 7;
  ASSERT_TRUE(write_new_plan(plan).ok());
  const Result<FarmPlan> read = read_plan(plan.folder);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value().flags, plan.flags);
  EXPECT_EQ(read.value().frames, plan.frames);
  EXPECT_EQ(read.value().outputs, plan.outputs);
  EXPECT_EQ(read.value().folder, plan.folder);
  EXPECT_EQ(read.value().retries, 7);
  EXPECT_EQ(read.value().resources.partition, "fast");
  EXPECT_EQ(read.value().resources.threads_per_part, 8);
}

// Names of files are bytes; JSON strings are UTF-8.
TEST_F(Plan, KeepsNamesThatAreNotUtf8) {
  FarmPlan plan = make_plan("", 2);
  std::filesystem::remove(plan.folder / "plan.json");
  plan.binary = "/opt/\xff/kindling";
  plan.scene = "/shots/caf\xe9.glb";
  plan.working_folder = "/shots\x80";
  plan.flags = {"--env", "\xfe\xff.hdr"};
  plan.outputs = {"/out/caf\xe9.exr", "/out/caf\xc3\xa9.exr"};
  ASSERT_TRUE(write_new_plan(plan).ok());
  const Result<FarmPlan> read = read_plan(plan.folder);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value().binary, plan.binary);
  EXPECT_EQ(read.value().scene, plan.scene);
  EXPECT_EQ(read.value().working_folder, plan.working_folder);
  EXPECT_EQ(read.value().flags, plan.flags);
  EXPECT_EQ(read.value().outputs, plan.outputs);
}

// A pipe in place of a record or a temporary file blocks nothing, and is no record.
TEST_F(Plan, PipesBlockNeitherReadingNorWriting) {
  const std::filesystem::path file = folder_ / "record.json";
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  const std::string temporary = file.string() + "." + host + "-" + std::to_string(getpid()) + ".tmp";
  ASSERT_EQ(mkfifo(temporary.c_str(), 0600), 0);
  ASSERT_TRUE(write_json_file(file, {{"a", 1}}).ok());
  EXPECT_EQ(read_json_file(file).value()["a"], 1);
  std::filesystem::remove(file);
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  EXPECT_EQ(read_json_file(file).error().message, file.string() + ": is not a regular file");
}

TEST_F(Plan, RefusesFolderOfAnotherFarm) {
  const FarmPlan plan = make_plan("");
  const Result<void> again = write_new_plan(plan);
  ASSERT_FALSE(again.ok());
  EXPECT_EQ(again.error().kind, ErrorKind::usage);
}

TEST_F(Plan, ReportsBrokenFiles) {
  EXPECT_FALSE(read_plan(folder_ / "nothing").ok());
  for (const char* text :
       {"", "[]", "{}", "{\"version\": 99}", "{\"version\": \"1\"}", "{\"version\": 1, \"parts\": 0}"}) {
    std::ofstream(folder_ / "plan.json") << text;
    const Result<FarmPlan> plan = read_plan(folder_);
    ASSERT_FALSE(plan.ok()) << text;
    EXPECT_NE(plan.error().message.find("plan.json"), std::string::npos) << plan.error().message;
  }
}

TEST(FrameNumber, ReplacesRunOfCrosses) {
  EXPECT_EQ(with_frame_number("a.####.exr", 7), "a.0007.exr");
  EXPECT_EQ(with_frame_number("a.##", 123), "a.123");
  EXPECT_EQ(with_frame_number("a.####.exr", -7), "a.-0007.exr");
  EXPECT_EQ(with_frame_number("a.exr", 7), "a.exr");
  EXPECT_EQ(with_frame_number("a.##", std::numeric_limits<int>::min()), "a.-2147483648");
}

TEST_F(Plan, RefusesNumbersThatAnIntCannotHold) {
  const std::filesystem::path folder = make_plan("true", 2, {1, 2}).folder;
  const std::string good = read_text(folder / "plan.json");
  ASSERT_TRUE(read_plan(folder).ok());
  const auto message = [&](const std::string& key, const std::string& value) {
    nlohmann::ordered_json json = nlohmann::ordered_json::parse(good);
    json[nlohmann::ordered_json::json_pointer(key)] = nlohmann::ordered_json::parse(value);
    std::ofstream(folder / "plan.json") << json.dump();
    const Result<FarmPlan> plan = read_plan(folder);
    return plan.ok() ? std::string() : plan.error().message.substr((folder / "plan.json").string().size());
  };
  for (const char* key : {"/version", "/parts", "/retries", "/frames/1", "/resources/threads_per_part"})
    for (const char* value :
         {"1e300", "2147483648", "-2147483649", "18446744073709551615", "1.5", "true", "[1]", "\"1\""})
      EXPECT_NE(message(key, value).find("; use a whole number from -2147483648 to 2147483647"), std::string::npos)
          << key << " " << value << ": " << message(key, value);
  EXPECT_EQ(message("/parts", "1e300"),
            ": not a plan of a farm: 'parts' is 1e+300; use a whole number from -2147483648 to 2147483647");
  EXPECT_EQ(message("/frames", "3"), ": not a plan of a farm: 'frames' is number; use a list");
  EXPECT_EQ(message("/frames/0", "-2147483648"), "");
}

TEST_F(Plan, CommandsHaveTheirFlags) {
  FarmPlan plan = make_plan("", 2, {5});
  plan.flags = {"--spp", "8", "--view", "Raw", "--exposure=1", "--exr-float"};
  const auto joined = [](const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) text += word + " ";
    return text;
  };
  const std::string render = joined(render_command(plan, plan.task(1), 4));
  for (const char* wanted :
       {" render /scene.glb --spp 8 --view Raw ", "--frames 5 ", "/parts/frame-####-part-002.unfinished.kacc ",
        "/frame-####-part-002.checkpoint.kacc ", "--part 2/2 ", "--threads 4 "})
    EXPECT_NE(render.find(wanted), std::string::npos) << render;
  const std::string merge = joined(merge_command(plan, 0));
  for (const char* wanted : {"part-001.kacc", "part-002.kacc", "image.0005.exr --view Raw --exposure=1 --exr-float "})
    EXPECT_NE(merge.find(wanted), std::string::npos) << merge;
  EXPECT_EQ(merge.find("--spp"), std::string::npos) << merge;
}

} // namespace
} // namespace kindling::test
