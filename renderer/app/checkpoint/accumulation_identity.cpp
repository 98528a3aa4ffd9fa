// Which image: made, and compared.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/checkpoint/accumulation_identity.h"

#include "renderer/app/terminal/version.h"
#include "renderer/app/text/text_format.h"
#include "renderer/distributed/work_parts.h"
#include "renderer/import/files/file_bytes.h"
#include "renderer/session/one_image.h"

#include <fmt/format.h>

#include <array>
#include <vector>

namespace kindling::app {

namespace fs = std::filesystem;

namespace {

bool is_whole(const AccumulationIdentity& identity) {
  return identity.part == SampleRange{0, identity.samples_per_pixel};
}

// "--seed: 0 in it, 2 here; --fov: ...", at most three of them; not program and scene, of which is more to say.
std::string describe_settings(const std::vector<ImageDifference>& differences) {
  constexpr size_t kMax = 3;
  std::string text;
  size_t count = 0;
  for (const auto& [what, there, here] : differences) {
    if (what == kProgramDiffers || what == kSceneDiffers || ++count > kMax) continue;
    text += fmt::format("{}{}: {} in it, {} here", count > 1 ? "; " : "", what, there, here);
  }
  if (count > kMax) text += fmt::format("; and {} more", count - kMax);
  return printable(text);
}

} // namespace

AccumulationIdentity make_identity(const RenderOptions& options, const ResolvedImage& resolved, uint64_t scene_hash) {
  AccumulationIdentity identity;
  identity.program = program_identity();
  identity.image = pixel_settings(options, resolved);
  const std::array<uint64_t, 2> hashes{scene_hash, resolved.environment_hash};
  identity.scene_hash =
      resolved.environment_hash == 0 ? scene_hash : gltf::hash_bytes(std::as_bytes(std::span(hashes)));
  identity.arguments = options.arguments;
  std::error_code ignored;
  identity.folder = fs::current_path(ignored);
  identity.size_px = resolved.size_px;
  identity.crop = options.crop.value_or(PixelRect{V2i(0, 0), resolved.size_px});
  identity.samples_per_pixel = options.samples_per_pixel();
  identity.planned_samples = options.planned_samples();
  identity.part = {0, identity.samples_per_pixel};
  if (options.part.samples)
    if (const Result<SampleRange> part = part_samples(identity.samples_per_pixel, *options.part.samples); part.ok())
      identity.part = part.value();
  return identity;
}

Result<void> check_same_render(const AccumulationIdentity& file, const fs::path& path,
                               const AccumulationIdentity& now) {
  const auto refuse = [&](const std::string& why) {
    return Error{ErrorKind::usage, fmt::format("{}: {}", path.string(), why)};
  };
  if (file.program != now.program)
    return refuse(
        fmt::format("was made by {}, this is {}; go on with the program that began it, or begin anew with --force",
                    printable(file.program), now.program));
  if (const std::string what = describe_settings(image_differences(file, now)); !what.empty())
    return refuse(fmt::format("is of another image ({}); make it as it was, or use another name{}", what,
                              file.planned_samples != now.planned_samples
                                  ? fmt::format(" (to add samples: kindling resume {} --spp N)", path.string())
                                  : ""));
  if (file.scene_hash != now.scene_hash)
    return refuse(fmt::format("the scene has changed since it was begun (hash {} then, {} now); put its files back as "
                              "they were, or use another name",
                              format_hash(file.scene_hash), format_hash(now.scene_hash)));
  if (!(is_whole(file) && is_whole(now)) && !(file.part == now.part))
    return refuse(fmt::format("is for samples {} to {} of each pixel, wanted are {} to {}; use another name",
                              file.part.first, file.part.end - 1, now.part.first, now.part.end - 1));
  return {};
}

} // namespace kindling::app
