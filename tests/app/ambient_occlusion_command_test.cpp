// The default of --ao-distance, which the help states in words.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/math.h"
#include "renderer/image/decode_image.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace kindling::test {
namespace {

class AmbientOcclusionCommand : public SceneFolder {
 protected:
  [[nodiscard]] std::vector<std::byte> render(const std::vector<std::string>& flags) const {
    std::vector<std::string> words{"render",
                                   KINDLING_SCENES "/cornell_box.glb",
                                   "--size",
                                   "24x24",
                                   "--spp",
                                   "4",
                                   "-o",
                                   "a.exr",
                                   "--exr-float",
                                   "--integrator",
                                   "ambient-occlusion"};
    words.insert(words.end(), flags.begin(), flags.end());
    const ProgramResult result = run_program(words, folder_);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    Result<Image> image = read_image_file(folder_ / "a.exr");
    return image.ok() ? image.value().pixels : std::vector<std::byte>();
  }
};

TEST_F(AmbientOcclusionCommand, DefaultDistanceIsATenthOfTheDiagonal) {
  const ProgramResult info = run_program({"info", KINDLING_SCENES "/cornell_box.glb", "--json"}, folder_);
  const nlohmann::json bounds = nlohmann::json::parse(info.out)["bounds"];
  V3f size;
  for (size_t i = 0; i < 3; ++i)
    size[static_cast<int>(i)] = bounds["max"][i].get<float>() - bounds["min"][i].get<float>();
  const float tenth = size.length() * 0.1f;
  const std::vector<std::byte> image = render({});
  EXPECT_FALSE(image.empty());
  EXPECT_TRUE(image == render({"--ao-distance", fmt::format("{}", tenth)}));
  EXPECT_FALSE(image == render({"--ao-distance", fmt::format("{}", 2.0f * tenth)}));
  const std::string help = run_program({"render", "--help"}, folder_).out;
  EXPECT_NE(help.find("[a tenth of the scene's diagonal]"), std::string::npos);
}

} // namespace
} // namespace kindling::test
