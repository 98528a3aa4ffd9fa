// Statistics of measurements, the warning of a busy machine, axes of plots, small PNG files.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/measure/indexed_png.h"
#include "renderer/app/measure/machine_load.h"
#include "renderer/app/measure/measurement.h"
#include "renderer/app/measure/svg.h"
#include "renderer/image/decode_image.h"
#include "tests/app/test_scene.h"

namespace kindling::test {
namespace {

using namespace kindling::app;

TEST(Measurement, ComputesMedianAndSpread) {
  EXPECT_EQ(median({}), 0.0);
  EXPECT_EQ(median(std::vector<double>{3}), 3.0);
  EXPECT_EQ(median(std::vector<double>{9, 1, 4}), 4.0);
  EXPECT_EQ(median(std::vector<double>{9, 1, 4, 2}), 3.0);
  EXPECT_EQ(percentile(std::vector<double>{0, 10, 20, 30, 40}, 0.0), 0.0);
  EXPECT_EQ(percentile(std::vector<double>{0, 10, 20, 30, 40}, 1.0), 40.0);
  EXPECT_DOUBLE_EQ(percentile(std::vector<double>{40, 10, 20, 30, 0}, 0.9), 36.0);
  const Summary summary = summarize(std::vector<double>{2, 5, 4});
  EXPECT_EQ(summary.median, 4.0);
  EXPECT_EQ(summary.min, 2.0);
  EXPECT_EQ(summary.max, 5.0);
  EXPECT_EQ(summary.spread_percent(), 75.0);
  EXPECT_EQ(summarize({}).spread_percent(), 0.0);
}

TEST(Measurement, TakesRatiosWithinRepetitions) {
  // The machine was half as fast in the second repetition: the ratio does not see it.
  EXPECT_DOUBLE_EQ(speed_ratio(std::vector<double>{1, 2, 1}, std::vector<double>{0.5, 1, 0.5}), 2.0);
  EXPECT_DOUBLE_EQ(speed_ratio(std::vector<double>{1, 1, 1}, std::vector<double>{2, 4, 8}), 0.25);
  EXPECT_DOUBLE_EQ(speed_ratio(std::vector<double>{0, 3}, std::vector<double>{1, 1}), 3.0);
  EXPECT_EQ(speed_ratio({}, {}), 0.0);
  EXPECT_DOUBLE_EQ(geometric_mean(std::vector<double>{2, 8, 0}), 4.0);
  EXPECT_EQ(geometric_mean({}), 0.0);
}

TEST(MachineLoad, WaitingIsNeitherWorkNorIdleTime) {
  EXPECT_EQ(waiting_share({}), 0.0);
  EXPECT_DOUBLE_EQ(waiting_share({4.0, 3.0}), 0.25);
  EXPECT_NEAR(waiting_share({2.5, 8.7}, 4, 1.0), 0.03, 1e-12); // 10 s of threads: 8.7 on a processor, 1 without work
  EXPECT_EQ(waiting_share({1.0, 1.1}), 0.0);                   // clocks differ a little
}

TEST(MachineLoad, WarnsAboveTheShareOfAQuietMachine) {
  EXPECT_EQ(disturbance_warning(0.0), "");
  EXPECT_EQ(disturbance_warning(0.0199), "");
  EXPECT_EQ(
      disturbance_warning(0.25),
      "The machine was not quiet: threads with work waited for a processor up to 25.0 % of the time; do not quote "
      "these figures.");
}

TEST(Plots, AxisStepsAreRound) {
  EXPECT_EQ(axis_step(0.0), 1.0);
  EXPECT_DOUBLE_EQ(axis_step(10.0), 2.0);
  EXPECT_DOUBLE_EQ(axis_step(4.0), 1.0);
  EXPECT_DOUBLE_EQ(axis_step(0.3), 0.05);
  EXPECT_DOUBLE_EQ(axis_step(799.0), 100.0);
  for (double largest = 1e-3; largest < 1e5; largest *= 1.37) {
    const double steps = largest / axis_step(largest);
    EXPECT_GE(steps, 4.0 - 1e-9) << largest;
    EXPECT_LE(steps, 10.0 + 1e-9) << largest;
  }
}

class IndexedPng : public SceneFolder {};

TEST_F(IndexedPng, DecodesToThePalette) {
  // Larger than one stored block of 65535 bytes.
  const int width = 301, height = 257;
  std::vector<uint8_t> pixels;
  for (int i = 0; i < width * height; ++i) pixels.push_back(static_cast<uint8_t>(i * 7 + i / width));
  Palette palette;
  for (size_t i = 0; i < 256; ++i)
    palette[i] = {static_cast<uint8_t>(i), static_cast<uint8_t>(255 - i), static_cast<uint8_t>(i / 2)};
  write_file("a.png", encode_indexed_png(pixels, width, height, palette));
  const Result<Image> image = read_image_file(folder_ / "a.png");
  ASSERT_TRUE(image.ok()) << image.error().message;
  ASSERT_EQ(image.value().width, width);
  ASSERT_EQ(image.value().height, height);
  ASSERT_EQ(image.value().channels, 3);
  ASSERT_EQ(image.value().type, PixelType::u8);
  for (size_t i = 0; i < pixels.size(); ++i)
    for (size_t k = 0; k < 3; ++k)
      ASSERT_EQ(static_cast<uint8_t>(image.value().pixels[3 * i + k]), palette[pixels[i]][k]) << i;
}

TEST(Base64, MatchesRfc4648) {
  EXPECT_EQ(encode_base64(""), "");
  EXPECT_EQ(encode_base64("f"), "Zg==");
  EXPECT_EQ(encode_base64("fo"), "Zm8=");
  EXPECT_EQ(encode_base64("foo"), "Zm9v");
  EXPECT_EQ(encode_base64("foobar"), "Zm9vYmFy"); // RFC 4648, section 10
  EXPECT_EQ(encode_base64("\xff\xfe\xfd"), "//79");
}

} // namespace
} // namespace kindling::test
