// Light groups, light passes and all other layers of a device are those of the CPU, to the bit.
// SPDX-License-Identifier: Apache-2.0
#include "tests/device/tested_device.h"
#include "tests/session/split_renders.h"

#include <gtest/gtest.h>

#include <vector>

namespace kindling::test {
namespace {

std::vector<SplitCase> split_cases_of_devices() {
  std::vector<SplitCase> cases = all_split_cases();
  std::erase_if(cases, [](const SplitCase& what) { return what.accelerator != accel::Kind::kdtree; });
  return cases;
}

AovSet without_catchers(AovSet aovs) {
  AovSet others;
  for (const AovInfo& info : kAovs)
    if (aovs.contains(info.aov) && info.aov != Aov::shadow_catcher) others.insert(info.aov);
  for (const MatteInfo& info : kMattes)
    if (aovs.contains(info.matte)) others.insert(info.matte);
  return others;
}

class SplitLightOnDevices : public testing::TestWithParam<SplitCase> {};

TEST_P(SplitLightOnDevices, HasTheBitsOfTheCpu) {
  const SplitScene scene(GetParam());
  RenderSettings settings = scene.settings();
  settings.aovs = without_catchers(settings.aovs);
  const RenderOutcome expected = scene.render(settings);
  settings.device = tested_device();
  settings.threads = 2;
  const RenderOutcome found = scene.render(settings);
  expect_same_bits(found.film, expected.film, "the device");
  EXPECT_EQ(found.film.light_groups().empty(), settings.integrator.light_groups == LightGrouping::off);
}

INSTANTIATE_TEST_SUITE_P(Cases, SplitLightOnDevices, testing::ValuesIn(split_cases_of_devices()), split_case_name);

} // namespace
} // namespace kindling::test
