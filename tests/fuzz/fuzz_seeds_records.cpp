// fuzz_seeds_records FOLDER: writes seeds of the files that a session reads and writes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/accumulation_file.h"
#include "renderer/session/ray_file.h"

#include <cstdio>
#include <limits>
#include <string>

using namespace kindling;

namespace {

std::filesystem::path folder_of(const std::filesystem::path& out, const char* kind) {
  std::filesystem::create_directories(out / kind);
  return out / kind;
}

AccumulationIdentity identity_of(const V2i& size_px, const PixelRect& crop) {
  AccumulationIdentity identity;
  identity.program = "Kindling";
  identity.image = R"({"seed":7})";
  identity.scene_hash = 0xfedcba9876543210;
  identity.arguments = {"render", "scene.glb", std::string("a\xff", 2)};
  identity.folder = "/s";
  identity.size_px = size_px;
  identity.crop = crop;
  identity.samples_per_pixel = 64;
  identity.planned_samples = 64;
  identity.part = {16, 32};
  identity.metadata = R"({"a":"b"})";
  return identity;
}

// Sums are zero, which compresses well: a reader copies them whatever they are.
RenderState state_of(const V2i& size_px, const PixelRect& area, AovSet aovs, bool adaptive) {
  RenderState state{Film(size_px, area, aovs), Coverage(area), {}, {0.5, 1.0, {}, 2}};
  if (adaptive) {
    state.film.trim_outliers();
    state.adaptive.stop_at.resize(state.coverage.block_count(), 20);
    state.adaptive.rays.resize(state.coverage.block_count(), 5);
    state.adaptive.earlier.resize(static_cast<size_t>(area.pixel_count()));
  }
  for (size_t i = 0; i < state.coverage.block_count(); ++i) {
    state.coverage.add(i, {16, i % 2 == 0 ? 20U : 24U});
    if (i % 3 == 1) state.coverage.set_stopped(i);
  }
  state.work.rays.camera = 100;
  state.work.rays.add_non_finite(V2i(1, 2), 17);
  return state;
}

bool write_accumulations(const std::filesystem::path& folder) {
  const auto write = [&](const char* name, const V2i& size_px, const PixelRect& area, AovSet aovs, bool adaptive) {
    return write_accumulation(folder / name, identity_of(size_px, area), state_of(size_px, area, aovs, adaptive), false)
        .ok();
  };
  AovSet all;
  for (const AovInfo& info : kAovs) all.insert(info.aov);
  const PixelRect one{V2i(0), V2i(1)}, whole{V2i(0), V2i(17, 9)}, part{V2i(8, 0), V2i(17, 9)};
  return write("one", V2i(1), one, {}, false) && write("whole", V2i(17, 9), whole, {}, false) &&
         write("part", V2i(17, 9), part, all, false) && write("adaptive", V2i(17, 9), whole, {}, true) &&
         write("all", V2i(17, 9), part, all, true) && write("empty", V2i(17, 9), {V2i(0), V2i(0)}, {}, false);
}

bool write_rays(const std::filesystem::path& folder) {
  const accel::Ray ray{.origin = V3f(0.1f, 2.0f, -3.0f),
                       .t_min = 0.0f,
                       .direction = V3f(0.0f, 0.6f, 0.8f),
                       .t_max = std::numeric_limits<float>::infinity(),
                       .key = 1,
                       .time = 0.25f,
                       .index = 7,
                       .flags = 1};
  const RayRecording recording{
      7, V2i(64, 36), {{"camera", RayQuery::nearest, 64, {ray, ray, ray}}, {"shadow1", RayQuery::any_hit, 0, {ray}}}};
  return write_ray_file(folder / "two", recording).ok() &&
         write_ray_file(folder / "none", {7, V2i(1), {{"a", {}, 0, {}}}}).ok();
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: fuzz_seeds_records FOLDER\n");
    return 2;
  }
  const std::filesystem::path out = argv[1];
  return write_accumulations(folder_of(out, "kacc")) && write_rays(folder_of(out, "rays")) ? 0 : 1;
}
