// Renders a glTF file to an image: the shortest program that uses Kindling.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/renderer.h"

#include <cstdio>

static int fail(const kindling::Error& error) {
  std::printf("%s\n", error.message.c_str());
  return 1;
}

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  auto renderer = kindling::Renderer::load(argv[1]);
  if (!renderer) return fail(renderer.error());
  kindling::ImageSettings settings;
  settings.size_px = kindling::V2i(32, 32);
  settings.spp = 4;
  auto image = renderer.value().render(settings);
  if (!image) return fail(image.error());
  auto written = image.value().write(argv[2]);
  return written ? 0 : fail(written.error());
}
