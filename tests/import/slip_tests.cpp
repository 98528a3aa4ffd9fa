// Loads and renders every file of the corpus of faults.
// A load repairs the fault with one warning or refuses it; a strict load refuses it.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/slips.h"

#include "renderer/facade/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace kindling::test {
namespace {

bool has_text(std::string_view text, std::string_view part) { return text.find(part) != std::string_view::npos; }

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

// Renders a few pixels of the middle of the animation; geometry must be seen.
void expect_geometry(Scene scene) {
  auto renderer = Renderer::take(std::move(scene));
  ASSERT_TRUE(renderer) << renderer.error().message;
  ImageSettings settings;
  settings.size_px = V2i(8, 8);
  settings.spp = 1;
  settings.time_s = 0.5;
  settings.aovs.insert(Aov::depth);
  RunOptions run;
  run.threads = 1;
  const auto image = renderer.value().render(settings, run);
  ASSERT_TRUE(image) << image.error().message;
  const std::vector<float> pixels = image.value().linear_rgb();
  EXPECT_TRUE(std::all_of(pixels.begin(), pixels.end(), [](float value) { return std::isfinite(value); }));
  EXPECT_TRUE(std::any_of(pixels.begin(), pixels.end(), [](float value) { return value > 0.0f; }));
  const std::vector<float> depth = image.value().film.resolve(Aov::depth);
  EXPECT_TRUE(std::any_of(depth.begin(), depth.end(), [](float value) { return value > 0.0f; }));
}

void check_slip(std::string_view content, const char* file, std::string_view fault, std::string_view remedy) {
  ASSERT_FALSE(fault.empty());
  const Loaded strict = load_text(content, kStrict, file);
  EXPECT_FALSE(strict.scene);
  EXPECT_TRUE(has_text(strict.error, fault)) << strict.error;

  Loaded loaded = load_text(content, kLenient, file);
  if (remedy.empty()) {
    EXPECT_FALSE(loaded.scene);
    EXPECT_TRUE(has_text(loaded.error, fault)) << loaded.error << joined(loaded.warnings);
    return;
  }
  ASSERT_TRUE(loaded.scene) << loaded.error;
  const auto reports = std::count_if(loaded.warnings.begin(), loaded.warnings.end(), [&](const std::string& warning) {
    return has_text(warning, fault) && has_text(warning, remedy);
  });
  EXPECT_EQ(reports, 1) << joined(loaded.warnings);
  EXPECT_LE(loaded.warnings.size(), 2U) << joined(loaded.warnings); // and perhaps what follows from it
  expect_geometry(std::move(*loaded.scene));
}

TEST(Slips, SoundFileHasNoFinding) {
  for (const std::string& content : {sound_file().gltf(), sound_file().glb()}) {
    Loaded loaded = load_text(content, kStrict, content.front() == '{' ? "test.gltf" : "test.glb");
    ASSERT_TRUE(loaded.scene) << loaded.error;
    EXPECT_EQ(joined(loaded.warnings), "");
    EXPECT_EQ(loaded.scene->animations[0].channels.size(), 3U);
    expect_geometry(std::move(*loaded.scene));
  }
}

TEST(Slips, AreManyAndNamed) {
  std::set<std::string_view> names;
  for (const Slip& slip : slips()) EXPECT_TRUE(names.insert(slip.name).second) << slip.name;
  for (const DataSlip& slip : data_slips()) EXPECT_TRUE(names.insert(slip.name).second) << slip.name;
  EXPECT_GE(names.size() + container_slips().size(), 150U);
}

TEST(Slips, JsonIsRepairedOrRefused) {
  for (const Slip& slip : slips()) {
    SCOPED_TRACE(slip.name);
    check_slip(with_slip(slip).gltf(), "test.gltf", slip.fault, slip.remedy);
  }
}

TEST(Slips, DataAreRepairedOrRefused) {
  for (const DataSlip& slip : data_slips()) {
    SCOPED_TRACE(slip.name);
    GltfBuilder builder = sound_file();
    slip.change(builder);
    check_slip(builder.gltf(), "test.gltf", slip.fault, slip.remedy);
  }
}

TEST(Slips, ContainersAreRepairedOrRefused) {
  for (const ContainerSlip& slip : container_slips()) {
    SCOPED_TRACE(slip.name);
    std::string bytes = sound_file().glb();
    slip.change(bytes);
    check_slip(bytes, "test.glb", slip.fault, slip.remedy);
  }
}

} // namespace
} // namespace kindling::test
