// `kindling farm` with scripts in place of Slurm: refusals, and tasks that are run by hand.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>

namespace kindling::test {
namespace {

class FarmCommand : public SceneFolder {
 protected:
  void SetUp() override {
    SceneFolder::SetUp();
    write_script("scontrol", "echo 'MaxArraySize = 1001'");
    write_script("sbatch", "echo x >> jobs; wc -l < jobs");
    write_script("squeue", "cat queue 2>/dev/null");
  }
  void write_script(const std::string& name, const std::string& body) const {
    const std::filesystem::path path = folder_ / "bin" / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << "#!/bin/sh\ncd '" << folder_.string() << "'\n" << body << "\n";
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  }
  [[nodiscard]] ProgramResult run(const std::vector<std::string>& arguments) const {
    Program program(arguments, folder_, Output::pipe, "export PATH=" + (folder_ / "bin").string() + ":$PATH");
    return program.finish();
  }
  [[nodiscard]] ProgramResult submit(const std::string& scene, const std::vector<std::string>& farm,
                                     const std::vector<std::string>& render) const {
    std::vector<std::string> arguments{"farm", "submit", scene, "--folder", "farm"};
    arguments.insert(arguments.end(), farm.begin(), farm.end());
    arguments.emplace_back("--");
    arguments.insert(arguments.end(), render.begin(), render.end());
    return run(arguments);
  }
  void expect_refused(const ProgramResult& result, const std::string& message, int code = 2) const {
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_NE(result.err.find(message), std::string::npos) << result.err;
    EXPECT_FALSE(exists("farm/plan.json"));
    EXPECT_FALSE(exists("jobs"));
  }
  [[nodiscard]] std::string pixels(const std::string& name) const {
    const Result<Image> image = read_image_file(folder_ / name);
    EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
    if (!image.ok()) return {};
    return {reinterpret_cast<const char*>(image.value().pixels.data()), image.value().byte_count()};
  }
};

TEST_F(FarmCommand, ReportsErrorsBeforeSubmission) {
  const std::string scene = write_scene();
  expect_refused(submit(scene, {"-o", "a.exr"}, {}), "--parts");
  expect_refused(submit(scene, {"--parts", "2"}, {}), "-o");
  expect_refused(run({"farm", "submit", scene, "--parts", "2", "-o", "a.exr"}), "--folder");
  expect_refused(submit(scene, {"--parts", "2", "-o", "a.exr"}, {"--checkpoint", "x.kacc"}), "--checkpoint");
  expect_refused(submit(scene, {"--parts", "2", "-o", "a.exr"}, {"--time-limit", "5"}), "--time-limit");
  expect_refused(submit(scene, {"--parts", "2", "-o", "a.exr"}, {"--sp", "5"}), "did you mean --spp?");
  expect_refused(submit(scene, {"--parts", "9", "-o", "a.exr"}, {"--spp", "8"}), "--part");
  // What each part would refuse.
  expect_refused(submit(scene, {"--parts", "2", "-o", "a.exr"}, {"--light-paths", "0.25", "--outliers", "trim"}),
                 "--light-paths: not with --outliers trim");
  expect_refused(submit(scene, {"--parts", "2", "-o", "a.exr"}, {"--shadow-catcher", "square", "--device", "host"}),
                 "--shadow-catcher: not on the device 'host'");
  expect_refused(submit(scene, {"--parts", "2", "-o", "a.exr"}, {"--device-memory", "1G"}), "--device-memory");
  expect_refused(submit(scene, {"--parts", "2", "-o", "a.txt"}, {}), "a.txt");
  expect_refused(submit(scene, {"--parts", "2", "-o", "a.exr", "--frames", "1-2"}, {}), "####");
  expect_refused(submit(scene, {"--parts", "2", "-o", "a.exr", "--memory", "1 G"}, {}), "--memory");
  for (const char* value : {"--memory=4GB", "--time=soon", "--time=1:2:3:4", "--partition=-x", "--partition=a,"})
    expect_refused(submit(scene, {"--parts", "2", "-o", "a.exr", value}, {}), "is no value for Slurm; use ");
  EXPECT_FALSE(exists("farm"));
  expect_refused(submit(scene, {"--parts", "2", "-o", "a.exr", "-o", "./a.exr"}, {}), "-o: ");
  expect_refused(submit(scene, {"--parts", "2", "-o", "farm/parts/a.kacc"}, {}), "is among the farm's own files");
  expect_refused(submit(scene, {"--parts", "2", "-o", "none/a.exr"}, {}), "none' does not exist", 4);
  expect_refused(submit(scene, {"--parts", "2", "-o", "scene.bin/a.exr"}, {}), "is not a folder", 4);
  expect_refused(submit("nothing.glb", {"--parts", "2", "-o", "a.exr"}, {}), "nothing.glb", 4);
  TestSceneOptions broken;
  broken.accessor_count_delta = 3;
  expect_refused(submit(write_scene("broken", broken), {"--parts", "2", "-o", "a.exr"}, {}), "broken.gltf", 3);
  EXPECT_EQ(run({"farm"}).exit_code, 2);
  EXPECT_EQ(run({"farm", "dance"}).exit_code, 2);
  EXPECT_EQ(run({"farm", "status", "nothing"}).exit_code, 4);
  EXPECT_EQ(run({"farm", "submit", "--help"}).exit_code, 0);
}

// In every spelling that the parser of the render accepts.
TEST_F(FarmCommand, RefusesOwnFlagsOfTheRender) {
  const std::string scene = write_scene();
  const std::vector<std::string> farm{"--parts", "2", "-o", "a.exr"};
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{"-ob.exr"}, "--output: cannot be given"},   {{"-o", "b.exr"}, "--output: cannot be given"},
      {{"--output=b.exr"}, "--output: cannot"},     {{"--help"}, "--help: cannot be given after --"},
      {{"-h"}, "--help: cannot be given after --"}, {{"-q"}, "--quiet: cannot be given"},
      {{"-vq"}, "--quiet: cannot be given"},        {{"--part=1/2"}, "--part: cannot be given"},
      {{"--", "other.glb"}, "unknown flag '--'"},   {{"other.glb"}, "other.glb"},
      {{"--env"}, "--env: needs a value"}};
  for (const auto& [flags, message] : cases) {
    SCOPED_TRACE(flags.front());
    expect_refused(submit(scene, farm, flags), message);
  }
}

TEST_F(FarmCommand, ImagesAreNoInputs) {
  const std::string scene = write_scene();
  ASSERT_EQ(run({"render", scene, "--size", "8x8", "--spp", "1", "-o", "env.0002.exr"}).exit_code, 0);
  std::filesystem::create_symlink("env.0002.exr", folder_ / "sky.exr");
  expect_refused(submit(scene, {"--parts", "2", "-o", "env.####.exr", "--frames", "1-3"}, {"--env", "sky.exr"}),
                 "is the file of --env as well");
  std::filesystem::create_symlink(scene, folder_ / "scene.exr");
  expect_refused(submit(scene, {"--parts", "2", "-o", "scene.exr"}, {}), "is the scene as well");
}

TEST_F(FarmCommand, AcceptsNamesThatAreNotUtf8) {
  const std::string scene = "caf\xe9.gltf";
  std::filesystem::copy_file(folder_ / write_scene(), folder_ / scene);
  const std::string image = "\xff\xfe.exr";
  ASSERT_EQ(run({"farm", "submit", scene, "--parts", "1", "--folder", "f\x80rm", "-o", image, "--", "--spp", "1",
                 "--size", "8x8"})
                .exit_code,
            0);
  const ProgramResult worked = run({"farm", "work", "f\x80rm", "0"});
  ASSERT_EQ(worked.exit_code, 0) << worked.err;
  const ProgramResult merged = run({"farm", "merge", "f\x80rm"});
  EXPECT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_TRUE(exists(image));
}

// The disk for temporary files of one machine is missing: its attempts fail, the farm continues.
TEST_F(FarmCommand, SickMachineDoesNotRefuseTheFarm) {
  ASSERT_EQ(run({"farm", "submit", KINDLING_SCENES "/interior.glb", "--parts", "2", "--folder", "farm", "-o", "a.exr",
                 "--retries", "0", "--", "--spp", "2", "--size", "8x8", "--texture-memory", "64K"})
                .exit_code,
            0);
  Program sick({"farm", "work", "farm", "0"}, folder_, Output::pipe,
               "export TMPDIR=/no/such/folder PATH=" + (folder_ / "bin").string() + ":$PATH");
  EXPECT_EQ(sick.finish().exit_code, 4);
  EXPECT_FALSE(exists("farm/state/refused.json"));
  const ProgramResult well = run({"farm", "work", "farm", "1"});
  EXPECT_EQ(well.exit_code, 0) << well.err;
}

TEST_F(FarmCommand, TasksByHandMakeTheImageOfOneProcess) {
  const std::string scene = write_scene();
  const std::vector<std::string> flags{"--spp", "7", "--size", "24x16", "--exr-float"};
  const ProgramResult submitted = submit(scene, {"--parts", "2", "-o", "a.exr"}, flags);
  ASSERT_EQ(submitted.exit_code, 0) << submitted.err;
  EXPECT_NE(submitted.out.find("tasks\t2\njobs\t1\nmerge\t2\n"), std::string::npos) << submitted.out;

  std::ofstream(folder_ / "queue") << "1|0|RUNNING|node1|None\n1|1|PENDING||Resources\n2|N/A|PENDING||Dependency\n";
  EXPECT_EQ(run({"farm", "status", "farm"}).exit_code, 6);
  EXPECT_EQ(run({"farm", "merge", "farm"}).exit_code, 5); // no part is rendered yet
  ASSERT_EQ(run({"farm", "work", "farm", "1"}).exit_code, 0);
  std::ofstream(folder_ / "queue") << "";
  const ProgramResult half = run({"farm", "status", "farm", "--json"});
  EXPECT_EQ(half.exit_code, 5) << half.err; // Slurm has forgotten the other task
  const nlohmann::json status = nlohmann::json::parse(half.out);
  EXPECT_EQ(status["done"], 1);
  EXPECT_EQ(status["missing"], 1);
  EXPECT_EQ(status["frames"][0]["tasks"][1]["attempts"].size(), 1u);

  ASSERT_EQ(run({"farm", "work", "farm", "0"}).exit_code, 0);
  const ProgramResult merged = run({"farm", "merge", "farm"});
  EXPECT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_EQ(run({"farm", "status", "farm"}).exit_code, 0);
  std::vector<std::string> whole{"render", scene, "-o", "whole.exr"};
  whole.insert(whole.end(), flags.begin(), flags.end());
  ASSERT_EQ(run(whole).exit_code, 0);
  EXPECT_EQ(pixels("a.exr"), pixels("whole.exr"));
  EXPECT_EQ(run({"farm", "work", "farm", "2"}).exit_code, 2); // the farm has two tasks
}

// Names of any kind, from any folder, through links; their control characters are not printed.
TEST_F(FarmCommand, AcceptsAnyNames) {
  const std::string scene = write_scene();
  for (const std::string name : {"a farm", "it's", "line\nline", "a#b", "a%A", "red\x1b[31m"}) {
    SCOPED_TRACE(name);
    ASSERT_EQ(run({"farm", "submit", scene, "--parts", "1", "--folder", name, "-o", name + "/image.exr", "--", "--spp",
                   "2", "--size", "8x8"})
                  .exit_code,
              0);
    std::filesystem::remove(folder_ / "link");
    std::filesystem::create_symlink(name, folder_ / "link");
    std::filesystem::create_directory(folder_ / name / "below");
    Program worked({"farm", "work", "../../link", "0"}, folder_ / name / "below", Output::pipe,
                   "export PATH=" + (folder_ / "bin").string() + ":$PATH");
    ASSERT_EQ(worked.finish().exit_code, 0);
    const ProgramResult merged = run({"farm", "merge", name});
    EXPECT_EQ(merged.exit_code, 0) << merged.err;
    EXPECT_TRUE(exists(name + "/image.exr"));
    const ProgramResult status = run({"farm", "status", name});
    EXPECT_EQ(status.exit_code, 0);
    EXPECT_EQ((status.out + status.err + merged.err).find('\x1b'), std::string::npos);
  }
}

TEST_F(FarmCommand, RefusesMalformedPlans) {
  ASSERT_EQ(submit(write_scene(), {"--parts", "2", "-o", "a.exr"}, {}).exit_code, 0);
  const nlohmann::json good = nlohmann::json::parse(read_file("farm/plan.json"));
  const auto expect_error = [&](const std::string& plan, const std::string& words) {
    write_file("farm/plan.json", plan);
    for (const std::vector<std::string>& action :
         {std::vector<std::string>{"status", "farm"}, {"merge", "farm"}, {"retry", "farm"}, {"work", "farm", "0"}}) {
      std::vector<std::string> words_of{"farm"};
      words_of.insert(words_of.end(), action.begin(), action.end());
      const ProgramResult result = run(words_of);
      EXPECT_EQ(result.exit_code, 4) << result.err;
      EXPECT_EQ(result.err_lines().size(), 1u) << result.err;
      EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    }
  };
  const auto with = [&](const char* key, const nlohmann::json& value) {
    nlohmann::json plan = good;
    plan[key] = value;
    return plan.dump();
  };
  expect_error("", "plan.json: is not a JSON object");
  expect_error("[]", "plan.json: is not a JSON object");
  expect_error(with("version", 2), "a plan of version 2; this program supports 1");
  expect_error(with("parts", 0), "a plan without parts");
  expect_error(with("parts", 2000000000), "a plan of 1 frames in 2000000000 parts: more than 1000000 tasks");
  expect_error(with("frames", std::vector<int>(600000)), "a plan of 600000 frames in 2 parts");
  expect_error(with("flags", "--spp"), "not a plan of a farm");
  std::filesystem::remove(folder_ / "farm/plan.json");
  std::filesystem::create_directory(folder_ / "farm/plan.json");
  EXPECT_EQ(run({"farm", "status", "farm"}).exit_code, 4);
}

TEST_F(FarmCommand, RendersFramesInParts) {
  const std::string scene = write_scene();
  const std::vector<std::string> flags{"--spp", "4", "--size", "16x16", "--exr-float"};
  ASSERT_EQ(submit(scene, {"--parts", "2", "--frames", "3-5x2", "-o", "a.###.exr"}, flags).exit_code, 0);
  for (const char* task : {"3", "0", "2", "1"}) {
    const ProgramResult worked = run({"farm", "work", "farm", task});
    ASSERT_EQ(worked.exit_code, 0) << worked.err;
  }
  const ProgramResult merged = run({"farm", "merge", "farm"});
  ASSERT_EQ(merged.exit_code, 0) << merged.err;
  std::vector<std::string> whole{"render", scene, "-o", "whole.###.exr", "--frames", "3-5x2"};
  whole.insert(whole.end(), flags.begin(), flags.end());
  ASSERT_EQ(run(whole).exit_code, 0);
  for (const char* frame : {"003", "005"})
    EXPECT_EQ(pixels("a." + std::string(frame) + ".exr"), pixels("whole." + std::string(frame) + ".exr")) << frame;
}

// The stops that a merge or render reports, one for each of its images.
std::vector<std::string> exposures(const std::string& report) {
  const std::string before = "exposure ", after = " stops";
  std::vector<std::string> found;
  for (size_t at = report.find(before); at != std::string::npos; at = report.find(before, at + 1))
    found.push_back(report.substr(at + before.size(), report.find(after, at) - at - before.size()));
  return found;
}

// A machine that renders a part sees a share of the samples: the exposure is that of the whole
// image.
TEST_F(FarmCommand, PartsOfAnImageShareItsExposure) {
  const std::string scene = write_scene();
  const std::vector<std::string> flags{"--spp", "7", "--size", "24x16", "--exposure", "auto", "--view", "Standard"};
  ASSERT_EQ(submit(scene, {"--parts", "3", "-o", "a.png"}, flags).exit_code, 0);
  for (const char* task : {"2", "0", "1"}) ASSERT_EQ(run({"farm", "work", "farm", task}).exit_code, 0);
  const ProgramResult merged = run({"farm", "merge", "farm"});
  ASSERT_EQ(merged.exit_code, 0) << merged.err;
  std::vector<std::string> whole{"render", scene, "-o", "whole.png"};
  whole.insert(whole.end(), flags.begin(), flags.end());
  const ProgramResult alone = run(whole);
  ASSERT_EQ(alone.exit_code, 0) << alone.err;
  ASSERT_EQ(exposures(alone.err).size(), 1u) << alone.err;
  EXPECT_EQ(exposures(merged.err), exposures(alone.err));
  EXPECT_EQ(pixels("a.png"), pixels("whole.png"));
}

// The light moves away from one frame to the next. By itself the second would be exposed for seven
// stops more.
TEST_F(FarmCommand, FramesInPartsShareOneExposure) {
  nlohmann::json scene = nlohmann::json::parse(read_file(write_scene()));
  // Times 0 and 1 s, and the light at distances of 2 and 20 m.
  scene["buffers"].push_back(
      {{"uri", "data:application/octet-stream;base64,AAAAAAAAgD8AAIA/AACAPwAAAEAAAIA/AACAPwAAoEE="},
       {"byteLength", 32}});
  scene["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 8}});
  scene["bufferViews"].push_back({{"buffer", 1}, {"byteOffset", 8}, {"byteLength", 24}});
  scene["accessors"].push_back(
      {{"bufferView", 2}, {"componentType", 5126}, {"type", "SCALAR"}, {"count", 2}, {"min", {0}}, {"max", {1}}});
  scene["accessors"].push_back({{"bufferView", 3}, {"componentType", 5126}, {"type", "VEC3"}, {"count", 2}});
  scene["animations"] = nlohmann::json::parse(R"([{"samplers": [{"input": 2, "output": 3}],
    "channels": [{"sampler": 0, "target": {"node": 2, "path": "translation"}}]}])");
  write_file("moving.gltf", scene.dump());
  scene.erase("animations");
  scene["nodes"][2]["translation"] = {1, 1, 20};
  write_file("far.gltf", scene.dump());

  const std::vector<std::string> flags{"--spp", "4", "--size", "24x16", "--exposure", "auto", "--view", "Standard"};
  const auto render = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "render");
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return exposures(result.err);
  };
  const std::vector<std::string> both = render({"moving.gltf", "-o", "whole.##.png", "--frames", "0,24"});
  ASSERT_FALSE(both.empty());
  const std::vector<std::string> far = render({"far.gltf", "-o", "far.png"});
  ASSERT_EQ(far.size(), 1u);
  EXPECT_GT(std::stod(far[0]) - std::stod(both[0]), 4.0);

  ASSERT_EQ(submit("moving.gltf", {"--parts", "2", "--frames", "0,24", "-o", "a.##.png"}, flags).exit_code, 0);
  for (const char* task : {"3", "0", "2", "1"}) ASSERT_EQ(run({"farm", "work", "farm", task}).exit_code, 0);
  const ProgramResult merged = run({"farm", "merge", "farm"});
  ASSERT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_EQ(exposures(merged.err), std::vector<std::string>(2, both[0])) << merged.err;
  for (const char* frame : {"00", "24"})
    EXPECT_EQ(pixels("a." + std::string(frame) + ".png"), pixels("whole." + std::string(frame) + ".png")) << frame;
}

TEST_F(FarmCommand, FailedSubmissionLeavesNoPlan) {
  write_script("sbatch", "echo 'sbatch: error: no' >&2; exit 1");
  const ProgramResult result = submit(write_scene(), {"--parts", "2", "-o", "a.exr"}, {});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_NE(result.err.find("sbatch: exit code 1: sbatch: error: no"), std::string::npos) << result.err;
  EXPECT_FALSE(exists("farm/plan.json"));
}

} // namespace
} // namespace kindling::test
