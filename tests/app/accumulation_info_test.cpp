// `kindling info FILE.kacc` with good and with damaged files.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <filesystem>

namespace kindling::test {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

class AccumulationInfoCommand : public SceneFolder {
 protected:
  void SetUp() override {
    SceneFolder::SetUp();
    write_scene();
  }
  [[nodiscard]] ProgramResult run(const Words& arguments) const { return run_program(arguments, folder_); }
  // Renders a 40 x 36 image with these flags and expects success.
  void render(Words flags) const {
    flags.insert(flags.begin(), {"render", "scene.gltf", "--size", "40x36", "--quiet"});
    const ProgramResult result = run(flags);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  [[nodiscard]] json info(const std::string& file, int code = 0) const {
    const ProgramResult result = run({"info", file, "--json"});
    EXPECT_EQ(result.exit_code, code) << result.err;
    return json::parse(result.out, nullptr, false);
  }
  void flip(const std::string& file, size_t at) const {
    std::string bytes = read_file(file);
    bytes[at] = static_cast<char>(bytes[at] ^ 1);
    write_file(file, bytes);
  }
  // Expects one line of error and no other output.
  void expect_error(const std::string& file, const std::string& words, const Words& flags = {}, int code = 4) const {
    Words arguments{"info", file};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_EQ(result.out, "");
    ASSERT_EQ(result.err_lines().size(), 1U) << result.err;
    EXPECT_NE(result.err.find("kindling: error: " + words), std::string::npos) << result.err;
  }
};

TEST_F(AccumulationInfoCommand, PrintsCheckpointAndPreviousGeneration) {
  render({"--spp", "4", "--seed", "3", "-o", "a.exr", "--checkpoint", "a.kacc"});
  json first = info("a.kacc");
  EXPECT_EQ(first["previous"], nullptr);
  EXPECT_EQ(first["scene"], "scene.gltf");
  EXPECT_EQ(first["folder"], std::filesystem::canonical(folder_).string());
  EXPECT_EQ(first["arguments"][0], "render");
  EXPECT_EQ(first["width"], 40);
  EXPECT_EQ(first["height"], 36);
  EXPECT_EQ(first["crop"], (json{0, 0, 40, 36}));
  EXPECT_EQ(first["area"], (json{0, 0, 40, 36}));
  EXPECT_EQ(first["part"], nullptr);
  EXPECT_EQ(first["samples"], (json{0, 4}));
  EXPECT_EQ(first["spp_wanted"], 4);
  EXPECT_EQ(first["spp_mean"], 4.0);
  EXPECT_EQ(first["done_share"], 1.0);
  EXPECT_EQ(first["coverage"], json::parse(R"([{"samples":[[0,4]],"suffice":false,"pixels":1440}])"));
  EXPECT_EQ(first["settings"]["--seed"], 3);
  EXPECT_EQ(first["work"]["runs"], 1);
  EXPECT_EQ(first["file_bytes"], std::filesystem::file_size(folder_ / "a.kacc"));
  EXPECT_GE(first["memory_bytes"], 1440 * 72); // beauty and alpha
  EXPECT_EQ(first["scene_hash"].get<std::string>().size(), 16U);
  EXPECT_TRUE(first["same_program"]);
  EXPECT_TRUE(first["sound"]);

  ASSERT_EQ(run({"resume", "a.kacc", "--spp", "10", "-q"}).exit_code, 0);
  const json second = info("a.kacc");
  EXPECT_EQ(second["spp_wanted"], 10);
  EXPECT_EQ(second["spp_planned"], 4);
  EXPECT_EQ(second["spp_mean"], 10.0);
  EXPECT_EQ(second["work"]["runs"], 2);
  EXPECT_EQ(second["previous"]["spp_mean"], 4.0);
  EXPECT_TRUE(second["previous"]["sound"]);
  EXPECT_EQ(info("a.kacc.previous")["spp_mean"], 4.0);

  const ProgramResult table = run({"info", "a.kacc"});
  EXPECT_EQ(table.exit_code, 0);
  EXPECT_EQ(table.err, "");
  for (const char* text : {"a.kacc\n  scene       scene.gltf\n", "\n  size        40x36 pixels\n",
                           "\n  samples     10 of 10 per pixel, 100.0 %; planned for 4\n", "by 2 processes, ",
                           "a.kacc.previous: 4 samples per pixel, saved 20", "\n  checksums   correct\n",
                           "\n  command     kindling render scene.gltf --size 40x36 ", "0 to 10", "--seed"})
    EXPECT_NE(table.out.find(text), std::string::npos) << text << " in\n" << table.out;
  EXPECT_EQ(table.out.find("part  "), std::string::npos) << table.out;
}

TEST_F(AccumulationInfoCommand, PrintsPartsAndMerges) {
  render({"--spp", "6", "--part", "2/3", "--tile-part", "1/2", "--crop", "0,0,32,32", "-o", "a.kacc"});
  const json part = info("a.kacc");
  EXPECT_EQ(part["part"], "2/3");
  EXPECT_EQ(part["tile_part"], "1/2");
  EXPECT_EQ(part["samples"], (json{2, 4}));
  EXPECT_EQ(part["spp_mean"], 2.0);
  EXPECT_EQ(part["done_share"], 1.0);
  EXPECT_EQ(part["crop"], (json{0, 0, 32, 32}));
  const json area = part["area"];
  EXPECT_EQ((area[2].get<int>() - area[0].get<int>()) * (area[3].get<int>() - area[1].get<int>()), 512);
  EXPECT_EQ(part["coverage"], json::parse(R"([{"samples":[[2,4]],"suffice":false,"pixels":512}])"));
  const std::string table = run({"info", "a.kacc"}).out;
  for (const char* text : {"2/3 of the samples, 1/2 of the pixels\n", "40x36 pixels, crop 0,0,32,32, in this file 0,0,",
                           "2 of 2 per pixel, 100.0 %; 2 to 4 of 6\n", "  2 to 4   "})
    EXPECT_NE(table.find(text), std::string::npos) << text << " in\n" << table;

  render({"--spp", "6", "--part", "1/3", "-o", "p1.kacc"});
  render({"--spp", "6", "--part", "3/3", "-o", "p3.kacc"});
  ASSERT_EQ(run({"merge", "p1.kacc", "p3.kacc", "-o", "m.kacc", "--allow-missing", "-q"}).exit_code, 0);
  const json merged = info("m.kacc");
  EXPECT_EQ(merged["part"], nullptr);
  EXPECT_EQ(merged["samples"], (json{0, 6}));
  EXPECT_EQ(merged["spp_mean"], 4.0);
  EXPECT_NEAR(merged["done_share"].get<double>(), 2.0 / 3.0, 1e-12);
  EXPECT_EQ(merged["coverage"], json::parse(R"([{"samples":[[0,2],[4,6]],"suffice":false,"pixels":1440}])"));
}

TEST_F(AccumulationInfoCommand, PrintsHeadersOfDamagedFiles) {
  render({"--spp", "4", "-o", "a.kacc"});
  const std::string good = read_file("a.kacc");
  // Damages the last block.
  flip("a.kacc", good.size() - 100);
  const ProgramResult damaged = run({"info", "a.kacc"});
  EXPECT_EQ(damaged.exit_code, 4);
  EXPECT_NE(damaged.out.find("\n  samples     4 of 4 per pixel"), std::string::npos) << damaged.out;
  EXPECT_NE(damaged.out.find("\n  checksums   wrong: a.kacc: block "), std::string::npos) << damaged.out;
  ASSERT_EQ(damaged.err_lines().size(), 1U) << damaged.err;
  EXPECT_NE(damaged.err.find("is damaged: the checksum is wrong"), std::string::npos) << damaged.err;
  const json report = info("a.kacc", 4);
  EXPECT_FALSE(report["sound"]);
  EXPECT_NE(report["damage"].get<std::string>().find("is damaged: the checksum is wrong"), std::string::npos);
  EXPECT_EQ(report["spp_mean"], 4.0);

  write_file("a.kacc", good);
  flip("a.kacc", 30);
  expect_error("a.kacc", "a.kacc: its header (bytes 0 to ");
  expect_error("a.kacc", "a.kacc: its header (bytes 0 to ", {"--json"});
  std::string other = good;
  other[8] = 2;
  write_file("a.kacc", other);
  expect_error("a.kacc", "a.kacc: is an accumulation file of version 2; this program reads version 1");
  for (const size_t size : {size_t{0}, size_t{12}, good.size() / 2, good.size() - 1}) {
    write_file("a.kacc", good.substr(0, size));
    expect_error("a.kacc", size < 20 ? "a.kacc: is not an accumulation file: it is too short" : "a.kacc: is cut off");
  }
  write_file("a.kacc", good + "more");
  expect_error("a.kacc", "a.kacc: is damaged: it has 4 bytes after its end");
  write_file("a.kacc.previous", good);
  write_file("a.kacc", good.substr(0, good.size() / 2));
  expect_error("a.kacc", "a.kacc: is cut off");
  EXPECT_NE(run({"info", "a.kacc"}).err.find("; a.kacc.previous can be read: it has 4.0 samples per pixel"),
            std::string::npos);
  flip("a.kacc.previous", good.size() - 100);
  EXPECT_EQ(run({"info", "a.kacc"}).err.find("can be read"), std::string::npos);
  write_file("a.kacc", good);
  const json sound = info("a.kacc");
  EXPECT_FALSE(sound["previous"]["sound"]);
  EXPECT_EQ(sound["previous"]["spp_mean"], nullptr);
}

TEST_F(AccumulationInfoCommand, RefusesOtherFiles) {
  expect_error("none.kacc", "none.kacc: cannot read: No such file or directory");
  std::filesystem::create_directory(folder_ / "folder.kacc");
  expect_error("folder.kacc", "folder.kacc: is not a regular file");
  write_file("text.kacc", "a text that is long enough to be a header");
  expect_error("text.kacc", "text.kacc: is not an accumulation file: it does not begin with KNDLACCU");
  render({"--spp", "1", "-o", "a.kacc"});
  for (const Words& flags :
       {Words{"--list-cameras"}, Words{"--scene", "0"}, Words{"--size", "8x8"}, Words{"--aov", "albedo"}})
    expect_error("a.kacc", flags[0] + ": has no meaning with a.kacc, which is not a scene", flags, 2);
  EXPECT_EQ(run({"info", "a.kacc", "--threads", "1"}).exit_code, 0);
}

// Control characters in the names and settings of a file are not printed.
TEST_F(AccumulationInfoCommand, ReplacesControlCharactersOfNames) {
  std::filesystem::rename(folder_ / "scene.gltf", folder_ / "a\x1b[31m\nb.gltf");
  ASSERT_EQ(run({"render", "a\x1b[31m\nb.gltf", "--size", "8x8", "--spp", "1", "-q", "-o", "a.kacc"}).exit_code, 0);
  const ProgramResult table = run({"info", "a.kacc"});
  EXPECT_EQ(table.exit_code, 0);
  EXPECT_EQ(table.out.find('\x1b'), std::string::npos);
  EXPECT_NE(table.out.find("scene       a?[31m b.gltf\n"), std::string::npos) << table.out;
}

} // namespace
} // namespace kindling::test
