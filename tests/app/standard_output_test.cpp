// Images to standard output, and JPEG files.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

namespace kindling::test {
namespace {

class StandardOutput : public SceneFolder {
 protected:
  // Renders to this output; standard output of the program.
  std::string render(const std::string& output) const {
    const ProgramResult result =
        run_program({"render", write_scene(), "-o", output, "--size", "24x16", "--spp", "2", "--quiet"}, folder_);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
  }
  [[nodiscard]] std::string contents(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

Result<Image> decode(const std::string& bytes) {
  return decode_image(std::as_bytes(std::span(bytes)), "standard output");
}

TEST_F(StandardOutput, TakesEachFormatAndNothingElse) {
  for (const auto& [output, channels] :
       {std::pair("-", 4), std::pair("png:-", 4), std::pair("jpg:-", 3), std::pair("exr:-", 4)}) {
    const Result<Image> image = decode(render(output));
    ASSERT_TRUE(image.ok()) << output << ": " << image.error().message;
    EXPECT_EQ(image.value().width, 24) << output;
    EXPECT_EQ(image.value().height, 16) << output;
    EXPECT_EQ(image.value().channels, channels) << output;
  }
}

TEST_F(StandardOutput, PixelsAreThoseOfAFile) {
  const Result<Image> piped = decode(render("-"));
  EXPECT_EQ(render("a.png"), "a.png\n");
  const std::string file = contents("a.png");
  const Result<Image> stored = decode(file);
  ASSERT_TRUE(piped.ok() && stored.ok());
  EXPECT_TRUE(piped.value().pixels == stored.value().pixels);
}

TEST_F(StandardOutput, AClosedPipeIsAnError) {
  const ProgramResult result = run_program(
      {"render", write_scene(), "-o", "-", "--size", "24x16", "--spp", "2", "--quiet"}, folder_, Output::full_device);
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_EQ(result.err, "kindling: error: standard output: cannot write: No space left on device\n");
}

TEST_F(StandardOutput, JpegFileHasTheMetadata) {
  render("a.jpg");
  const std::string file = contents("a.jpg");
  EXPECT_TRUE(decode(file).ok());
  EXPECT_NE(file.find("kindling:samplesPerPixel: 2"), std::string::npos);
  EXPECT_NE(file.find("kindling:commandLine: kindling render"), std::string::npos);
}

} // namespace
} // namespace kindling::test
