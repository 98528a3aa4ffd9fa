// Parts of one render by the CPU and by another device.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/render_session.h"
#include "renderer/session/tile_scheduler.h"
#include "tests/device/tested_device.h"
#include "tests/session/same_bits.h"

#include <initializer_list>

namespace kindling::test {

// Expects that parts of the samples and of the image, by both devices in turn, add up to the whole
// image by the CPU. film_on(device, settings) renders.
template <typename FilmOn>
void expect_parts_of_devices_add_up(const RenderSettings& settings, std::initializer_list<SampleRange> parts,
                                    const FilmOn& film_on) {
  const Film whole = film_on(DeviceKind::cpu, settings);
  Film of_samples(settings.size_px, whole.crop(), whole.aovs()), of_regions = of_samples;
  of_samples.enable_splats();
  of_regions.enable_splats();
  int part = 0;
  const auto next_device = [&part] { return part++ % 2 == 0 ? tested_device() : DeviceKind::cpu; };
  for (const SampleRange& samples : parts) {
    RenderSettings some = settings;
    some.samples = samples;
    of_samples.add(film_on(next_device(), some));
  }
  expect_same_bits(of_samples, whole, "parts of the samples");
  for (const PixelRect& region : make_regions(whole.crop(), 3)) {
    RenderSettings some = settings;
    some.region = region;
    of_regions.add(film_on(next_device(), some));
  }
  expect_same_bits(of_regions, whole, "parts of the image");
}

} // namespace kindling::test
