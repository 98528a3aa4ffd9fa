// --exposure auto, and the note about dark images.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

namespace kindling::test {
namespace {

class ExposureCommand : public SceneFolder {
 protected:
  // Renders in the light of a constant environment. Returns what the program reports.
  std::string render(const std::string& radiance, const std::string& output,
                     std::vector<std::string> flags = {}) const {
    flags.insert(flags.begin(), {"render", write_scene("scene", {.light = false}), "-o", output, "--size", "24x16",
                                 "--spp", "4", "--env-color", radiance, "--view", "Standard"});
    const ProgramResult result = run_program(flags, folder_);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.err;
  }
  [[nodiscard]] std::vector<std::byte> pixels(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    const Result<Image> image = decode_image(std::as_bytes(std::span(bytes)), name);
    EXPECT_TRUE(image.ok());
    return image.ok() ? image.value().pixels : std::vector<std::byte>();
  }
};

// Returns the stops that the program reports after `words`.
std::string stops(const std::string& report, std::string_view words) {
  const size_t at = report.find(words);
  if (at == std::string::npos) return "none in: " + report;
  const size_t begin = at + words.size();
  return report.substr(begin, report.find(" stops", begin) - begin);
}

constexpr std::string_view kChosen = "kindling: exposure ";
constexpr std::string_view kSuggested = "--exposure auto would use ";

TEST_F(ExposureCommand, AutoIsTheExposureThatItReports) {
  const std::string report = render(".001,.001,.001", "auto.png", {"--exposure", "auto"});
  const std::string chosen = stops(report, kChosen);
  EXPECT_GT(std::stod(chosen), 4.0);
  render(".001,.001,.001", "given.png", {"--exposure", chosen});
  EXPECT_EQ(pixels("auto.png"), pixels("given.png"));
}

TEST_F(ExposureCommand, FactorsOnAllLightLeaveNoTrace) {
  const double bright = std::stod(stops(render("8,8,8", "bright.png", {"--exposure", "auto"}), kChosen));
  const double dim = std::stod(stops(render(".0078125,.0078125,.0078125", "dim.png", {"--exposure", "auto"}), kChosen));
  EXPECT_EQ(dim - bright, 10.0);
  EXPECT_EQ(pixels("bright.png"), pixels("dim.png"));
}

TEST_F(ExposureCommand, NotesImagesThatAreDarkOrBright) {
  const std::string dark = render(".0001,.0001,.0001", "a.png");
  EXPECT_NE(dark.find("the image is dark: mean luminance"), std::string::npos) << dark;
  const std::string chosen = stops(render(".0001,.0001,.0001", "b.png", {"--exposure", "auto"}), kChosen);
  EXPECT_EQ(stops(dark, kSuggested), chosen);
  EXPECT_NE(render("100,100,100", "a.png").find("the image is bright: mean luminance"), std::string::npos);
  EXPECT_EQ(render(".5,.5,.5", "a.png").find("the image is"), std::string::npos);
  EXPECT_EQ(render("0,0,0", "a.png").find("the image is dark"), std::string::npos); // nothing to see at any exposure
  EXPECT_EQ(render(".0001,.0001,.0001", "a.exr").find("the image is"), std::string::npos);
}

// Frames rendered together, by themselves and in parts.
TEST_F(ExposureCommand, FramesOfAnAnimationShareOne) {
  const std::string scene = KINDLING_SCENES "/tiny/animation.gltf";
  const auto run = [&](std::vector<std::string> arguments) {
    const ProgramResult result = run_program(arguments, folder_);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.err;
  };
  const std::vector<std::string> settings = {"--size",     "24x16", "--spp",  "4",
                                             "--exposure", "auto",  "--view", "Standard"};
  const auto render_with = [&](std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"render", scene});
    flags.insert(flags.end(), settings.begin(), settings.end());
    return run(flags);
  };
  const std::string both = render_with({"--frames", "1,12", "-o", "f_##.png"});
  const std::string first = stops(both, kChosen);
  EXPECT_EQ(first.rfind("none", 0), std::string::npos) << both;
  EXPECT_NE(both.find("stops (of all frames)"), std::string::npos) << both;
  const std::string alone = render_with({"--frames", "12", "-o", "g_##.png"});
  EXPECT_EQ(stops(alone, kChosen), first);
  EXPECT_EQ(pixels("f_12.png"), pixels("g_12.png"));
  for (const char* part : {"1/2", "2/2"})
    render_with({"--frames", "12", "--part", part, "-o", std::string("p_##_") + part[0] + ".kacc"});
  const std::string merged =
      run({"merge", "p_12_1.kacc", "p_12_2.kacc", "-o", "m.png", "--exposure", "auto", "--view", "Standard"});
  EXPECT_EQ(stops(merged, kChosen), first);
  EXPECT_EQ(pixels("m.png"), pixels("f_12.png"));
}

} // namespace
} // namespace kindling::test
