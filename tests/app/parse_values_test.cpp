// Parsing of flag values: accepted values, their meaning, and refusals.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/text/parse_values.h"

#include <gtest/gtest.h>

namespace kindling::app {
namespace {

TEST(ParseValues, Integers) {
  EXPECT_EQ(parse_integer("64", 1, 100).value(), 64);
  EXPECT_EQ(parse_integer("+7", 1, 100).value(), 7);
  EXPECT_EQ(parse_integer("-3", -5, 5).value(), -3);
  for (const char* text : {"", "abc", "1.5", "12x", " 1", "1 ", "99999999999999999999", "+-1"})
    EXPECT_FALSE(parse_integer(text, 1, 100).ok()) << text;
  EXPECT_EQ(parse_integer("0", 1, 100).error().message, "'0' is out of range; use 1 to 100");
  EXPECT_EQ(parse_integer("0", 1, 100).error().kind, ErrorKind::usage);
}

TEST(ParseValues, Numbers) {
  EXPECT_DOUBLE_EQ(parse_number("-1.5e2").value(), -150.0);
  EXPECT_DOUBLE_EQ(parse_number(".5").value(), 0.5);
  for (const char* text : {"", "nan", "inf", "-inf", "1,5", "1e999", "0x10"})
    EXPECT_FALSE(parse_number(text).ok()) << text;
  EXPECT_EQ(parse_number("-1", 0.0).error().message, "'-1' is out of range; use a number of 0 or more");
}

TEST(ParseValues, Sizes) {
  EXPECT_EQ(parse_size("1280x720").value(), V2i(1280, 720));
  EXPECT_EQ(parse_size("1x65536").value(), V2i(1, 65536));
  for (const char* text :
       {"1280", "x", "1280x", "x720", "1280x720x1", "0x10", "-1x10", "10x65537", "1280*720", "12.5x10"})
    EXPECT_FALSE(parse_size(text).ok()) << text;
}

TEST(ParseValues, Scales) {
  EXPECT_DOUBLE_EQ(parse_scale("0.5").value(), 0.5);
  EXPECT_DOUBLE_EQ(parse_scale("50%").value(), 0.5);
  EXPECT_DOUBLE_EQ(parse_scale("2").value(), 2.0);
  for (const char* text : {"0", "-1", "65", "%", "half", "nan"}) EXPECT_FALSE(parse_scale(text).ok()) << text;
}

TEST(ParseValues, Durations) {
  EXPECT_DOUBLE_EQ(parse_duration("90").value(), 90.0);
  EXPECT_DOUBLE_EQ(parse_duration("90s").value(), 90.0);
  EXPECT_DOUBLE_EQ(parse_duration("0.5").value(), 0.5);
  EXPECT_DOUBLE_EQ(parse_duration("5m").value(), 300.0);
  EXPECT_DOUBLE_EQ(parse_duration("1.5h").value(), 5400.0);
  EXPECT_DOUBLE_EQ(parse_duration("1h30m").value(), 5400.0);
  EXPECT_DOUBLE_EQ(parse_duration("1h2m3s").value(), 3723.0);
  for (const char* text : {"", "0", "-5", "m", "5x", "5m1h", "5m5m", "1h30", "5 m", "..5", "inf"})
    EXPECT_FALSE(parse_duration(text).ok()) << text;
}

TEST(ParseValues, Bytes) {
  EXPECT_EQ(parse_bytes("4096").value(), 4096U);
  EXPECT_EQ(parse_bytes("512K").value(), 512U << 10);
  EXPECT_EQ(parse_bytes("1.5m").value(), 3U << 19);
  EXPECT_EQ(parse_bytes("2G").value(), uint64_t{2} << 30);
  EXPECT_EQ(parse_bytes("1T").value(), uint64_t{1} << 40);
  for (const char* text : {"", "G", "0", "-1M", "1X", "1 G", "1e30T", "nan", "0.5"})
    EXPECT_FALSE(parse_bytes(text).ok()) << text;
}

TEST(ParseValues, Crops) {
  const PixelRect crop = parse_crop("10,20,110,70").value();
  EXPECT_EQ(crop.min, V2i(10, 20));
  EXPECT_EQ(crop.width(), 100);
  EXPECT_EQ(crop.height(), 50);
  for (const char* text : {"", "1,2,3", "1,2,3,4,5", "5,5,5,6", "5,5,4,6", "-1,0,5,5", "0,0,1e2,5", "0,0,70000,1"})
    EXPECT_FALSE(parse_crop(text).ok()) << text;
}

TEST(ParseValues, PixelsAndVectors) {
  EXPECT_EQ(parse_pixel("412,90").value(), V2i(412, 90));
  EXPECT_FALSE(parse_pixel("412").ok());
  EXPECT_FALSE(parse_pixel("-1,2").ok());
  EXPECT_EQ(parse_vector("0,1.5,-2").value(), V3f(0.0f, 1.5f, -2.0f));
  EXPECT_FALSE(parse_vector("0,1.5").ok());
  EXPECT_FALSE(parse_vector("0,1.5,").ok());
  EXPECT_FALSE(parse_vector("0,0,1e39").ok()); // beyond single precision
}

TEST(ParseValues, Colors) {
  EXPECT_EQ(parse_color("0.5,0,2").value(), Rgb(0.5f, 0.0f, 2.0f));
  EXPECT_EQ(parse_color("0.5").value(), Rgb(0.5f));
  for (const char* text : {"", "red", "1,2", "-1,0,0", "nan", "1,2,3,4", "-0.1"})
    EXPECT_FALSE(parse_color(text).ok()) << text;
}

TEST(ParseValues, Lists) {
  EXPECT_EQ(parse_list("a,b").value(), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(parse_list("a").value(), (std::vector<std::string>{"a"}));
  EXPECT_FALSE(parse_list("a,,b").ok());
  EXPECT_FALSE(parse_list("").ok());
  EXPECT_FALSE(parse_list("a,").ok());
}

TEST(ParseValues, Choices) {
  EXPECT_EQ(join_choices({"a"}), "a");
  EXPECT_EQ(join_choices({"a", "b"}), "a or b");
  EXPECT_EQ(join_choices({"a", "b", "c"}), "a, b or c");
  const std::vector<std::string> flags{"--spp", "--scale", "--size"};
  EXPECT_EQ(nearest_name("--sppp", flags), "--spp");
  EXPECT_EQ(nearest_name("--sise", flags), "--size");
  EXPECT_EQ(nearest_name("--banana", flags), "");
}

TEST(ParseValues, SuggestsFlagsByNamesOfOtherRenderers) {
  const std::vector<std::string> flags{"--spp",      "--size",  "--output", "--max-bounces", "--env",  "--sampler",
                                       "--exposure", "--scene", "--camera", "--threads",     "--accel"};
  for (const auto& [word, flag] : std::vector<std::pair<std::string, std::string>>{{"--samples", "--spp"},
                                                                                   {"--samples-per-pixel", "--spp"},
                                                                                   {"--resolution", "--size"},
                                                                                   {"--width", "--size"},
                                                                                   {"--height", "--size"},
                                                                                   {"--out", "--output"},
                                                                                   {"--bounces", "--max-bounces"},
                                                                                   {"--max-depth", "--max-bounces"},
                                                                                   {"--environment", "--env"},
                                                                                   {"--hdri", "--env"},
                                                                                   {"--envmap", "--env"},
                                                                                   {"--nthreads", "--threads"},
                                                                                   {"--sampels", "--spp"}})
    EXPECT_EQ(nearest_name(word, flags), flag) << word;
  EXPECT_EQ(nearest_name("--samplr", flags), "--sampler"); // misspelled flags come first
  EXPECT_EQ(nearest_name("--hdri", {"--spp"}), "");        // only flags of the command
}

} // namespace
} // namespace kindling::app
