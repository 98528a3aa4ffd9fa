// `--light-groups` of render, and `kindling relight`.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/read_exr.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

using Words = std::vector<std::string>;

class RelightCommand : public SceneFolder {
 protected:
  void SetUp() override {
    SceneFolder::SetUp();
    write_scene();
    render({"-o", "all.exr", "-o", "sums.kacc", "--exr-float", "--light-groups", "kind", "--aov", "direct,normal"});
  }
  [[nodiscard]] ProgramResult run(const Words& words) const { return run_program(words, folder_); }
  void expect_done(const Words& words) const {
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  void render(const Words& more) const {
    Words words{"render", "scene.gltf", "--size", "24x20", "--spp", "8", "--env-color", "0.2,0.4,0.8"};
    words.insert(words.end(), more.begin(), more.end());
    expect_done(words);
  }
  void expect_refused(const Words& words, const std::string& message, int code = 2) const {
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_NE(result.err.find(message), std::string::npos) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  }
  [[nodiscard]] ExrImage image(const std::string& name) const {
    Result<ExrImage> read = read_exr(folder_ / name);
    EXPECT_TRUE(read.ok()) << (read.ok() ? "" : read.error().message);
    return read.ok() ? std::move(read).value() : ExrImage{};
  }
};

const std::vector<float>& channel(const ExrImage& image, const std::string& name) {
  static const std::vector<float> none;
  for (const ExrLayer& layer : image.layers)
    if (layer.channel_names.front() == name) return layer.values;
  ADD_FAILURE() << "no channel " << name;
  return none;
}

std::set<std::string> channels(const ExrImage& image) {
  std::set<std::string> names;
  for (const ExrLayer& layer : image.layers) names.insert(layer.channel_names.front());
  return names;
}

void expect_near(const std::vector<float>& found, const std::vector<float>& expected, float relative = 1e-5f) {
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i)
    EXPECT_NEAR(found[i], expected[i], relative * (std::abs(expected[i]) + 1e-3f)) << i;
}

TEST_F(RelightCommand, GroupsAreLayersThatSumToTheImage) {
  const ExrImage all = image("all.exr");
  for (const char* name : {"Combined_environment.R", "Combined_lights.G"}) EXPECT_TRUE(channels(all).contains(name));
  std::vector<float> sum = channel(all, "Combined_environment.G");
  const std::vector<float>& lights = channel(all, "Combined_lights.G");
  for (size_t i = 0; i < sum.size(); ++i) sum[i] += lights[i];
  expect_near(sum, channel(all, "G"), 1e-6f);
  render({"-o", "plain.exr", "--exr-float"});
  EXPECT_EQ(channel(image("plain.exr"), "G"), channel(all, "G"));
  EXPECT_FALSE(channels(image("plain.exr")).contains("Combined_lights.G"));
}

TEST_F(RelightCommand, FactorsMultiplyLight) {
  const ExrImage all = image("all.exr");
  for (const std::string file : {"all.exr", "sums.kacc"}) {
    expect_done({"relight", file, "--group", "lights=0.5,environment=2,1,0", "-o", "new.exr", "--exr-float"});
    const ExrImage relit = image("new.exr");
    for (const auto& [component, factor] : {std::pair{"R", 2.0f}, {"G", 1.0f}, {"B", 0.0f}}) {
      std::vector<float> expected = channel(all, std::string("Combined_environment.") + component);
      const std::vector<float>& lights = channel(all, std::string("Combined_lights.") + component);
      for (size_t i = 0; i < expected.size(); ++i) expected[i] = expected[i] * factor + 0.5f * lights[i];
      expect_near(channel(relit, component), expected);
    }
    EXPECT_EQ(channel(relit, "A"), channel(all, "A"));
    EXPECT_TRUE(channels(relit).contains("normal.X"));
    EXPECT_FALSE(channels(relit).contains("direct.R")); // is that of other lights
    EXPECT_NE(relit.text.at("kindling:relitBy").find("relight"), std::string::npos);
  }
}

// Twice the same change is a change by the product.
TEST_F(RelightCommand, RelitImagesAreRelitAgain) {
  expect_done({"relight", "all.exr", "--group", "lights=0.5", "-o", "a.exr", "--exr-float"});
  expect_done({"relight", "a.exr", "--group", "lights=4", "-o", "b.exr", "--exr-float"});
  expect_done({"relight", "sums.kacc", "--group", "lights=2", "-o", "c.exr", "--exr-float"});
  expect_near(channel(image("b.exr"), "R"), channel(image("c.exr"), "R"));
}

TEST_F(RelightCommand, OneForAllIsTheImageItself) {
  expect_done({"relight", "all.exr", "-o", "same.exr", "--exr-float"});
  for (const char* component : {"R", "G", "B", "direct.G"})
    EXPECT_EQ(channel(image("same.exr"), component), channel(image("all.exr"), component)) << component;
}

TEST_F(RelightCommand, OthersAreAllThatAreNotNamed) {
  expect_done({"relight", "sums.kacc", "--group", "lights=1", "--others", "0", "-o", "lights.exr", "--exr-float"});
  expect_near(channel(image("lights.exr"), "B"), channel(image("all.exr"), "Combined_lights.B"));
}

// The image of changed lights, which the environment's factor stands for.
TEST_F(RelightCommand, EqualsTheRenderOfChangedLight) {
  expect_done({"relight", "sums.kacc", "--group", "environment=3", "-o", "relit.exr", "--exr-float"});
  render({"--env-intensity", "3", "-o", "rendered.exr", "--exr-float"});
  const std::vector<float> relit = channel(image("relit.exr"), "G"), rendered = channel(image("rendered.exr"), "G");
  double difference = 0.0, sum = 0.0;
  for (size_t i = 0; i < relit.size(); ++i) {
    difference += static_cast<double>(relit[i] - rendered[i]);
    sum += static_cast<double>(rendered[i]);
  }
  EXPECT_LT(std::abs(difference / sum), 0.02);
}

TEST_F(RelightCommand, WritesDisplayImagesByDefault) {
  const ProgramResult result = run({"relight", "all.exr", "--group", "lights=2"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "all-relit.png\n");
  EXPECT_TRUE(exists("all-relit.png"));
  EXPECT_NE(result.err.find("relit: environment 1, lights 2"), std::string::npos) << result.err;
  expect_done({"relight", "all.exr", "--group", "lights=2", "--exposure", "auto", "--view", "AgX", "-o", "a.jpg"});
}

TEST_F(RelightCommand, PartsAndResumedRendersHaveGroups) {
  for (const std::string part : {"1/2", "2/2"})
    render({"--light-groups", "kind", "--part", part, "-o", "part" + part.substr(0, 1) + ".kacc"});
  expect_done({"merge", "part1.kacc", "part2.kacc", "-o", "merged.exr", "--exr-float"});
  render({"--light-groups", "kind", "--spp", "4", "--planned-spp", "8", "--checkpoint", "c.kacc", "-o", "half.exr",
          "--exr-float"});
  expect_done({"resume", "c.kacc", "--spp", "8", "-o", "resumed.exr"});
  for (const char* name : {"Combined_environment.R", "Combined_lights.B", "R"}) {
    EXPECT_EQ(channel(image("merged.exr"), name), channel(image("all.exr"), name)) << name;
    EXPECT_EQ(channel(image("resumed.exr"), name), channel(image("all.exr"), name)) << name;
  }
  render({"--light-groups", "name", "--part", "1/2", "-o", "other.kacc"});
  EXPECT_EQ(run({"merge", "part2.kacc", "other.kacc", "-o", "bad.exr"}).exit_code, 2);
}

TEST_F(RelightCommand, WrongInputIsNamed) {
  expect_refused({"relight", "all.exr", "--group", "sky=2"}, "--group: unknown light group 'sky'");
  expect_refused({"relight", "all.exr", "--group", "lights"}, "'lights' has no factor; use GROUP=FACTOR");
  expect_refused({"relight", "all.exr", "--group", "=2"}, "names no group");
  expect_refused({"relight", "all.exr", "--group", "lights=bright"}, "'lights=bright': the factor must be a number");
  expect_refused({"relight", "all.exr", "--group", "lights=1,2"}, "'lights=1,2': the factor must be a number");
  expect_refused({"relight", "all.exr", "--group", "lights=-1"}, "'lights=-1': the factor must be");
  expect_refused({"relight", "all.exr", "--group", "lights=1e30"}, "from 0 to 1e+06");
  expect_refused({"relight", "all.exr", "--others", "x"}, "the factor must be");
  expect_refused({"relight"}, "no image; use 'kindling relight");
  expect_refused({"relight", "all.png"}, "all.png: has no light groups; use an .exr or a .kacc file");
  expect_refused({"relight", "missing.exr"}, "missing.exr", 4);
  expect_refused({"relight", "missing.kacc"}, "missing.kacc", 4);
  expect_refused({"relight", "all.exr", "-o", "new.kacc"}, "sums are never relit");
  expect_refused({"relight", "all.exr", "-o", "all.exr"}, "all.exr");
  render({"-o", "plain.exr"});
  expect_refused({"relight", "plain.exr"}, "plain.exr: it has no light groups; render it with --light-groups");
  write_file("broken.exr", "not an image");
  expect_refused({"relight", "broken.exr"}, "broken.exr", 4);
}

TEST_F(RelightCommand, RendersWithoutSplitLightAreRefused) {
  expect_refused({"render", "scene.gltf", "--light-groups", "kind", "--integrator", "whitted", "-o", "a.exr"},
                 "--light-groups: ");
  expect_refused({"render", "scene.gltf", "--light-groups", "kind", "-o", "a.png"},
                 "--light-groups: only .exr and .kacc files hold light groups; add -o FILE.exr");
  expect_refused({"render", "scene.gltf", "--light-groups", "hue", "-o", "a.exr"},
                 "unknown way of grouping lights 'hue'; use off, kind, name or extras");
}

} // namespace
} // namespace kindling::test
