// Identifies the render that an accumulation belongs to, and compares such identities.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/session/accumulation_file.h"
#include "renderer/session/pixel_settings.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// Returns the identity of a render of all samples by this program. `scene_hash`:
// Scene::content_hash, which covers all bytes read for the scene; the hash of the environment is
// combined with it. The folder is the current one. Left to the caller: `arguments` and `metadata`,
// which are not compared, and `part` where the accumulation is to hold fewer samples.
[[nodiscard]] AccumulationIdentity make_identity(const WorldSettings& world, const ImageSettings& image,
                                                 const ResolvedImage& resolved, uint64_t scene_hash);

inline constexpr std::string_view kProgramDiffers = "program", kSceneDiffers = "scene hash";
struct ImageDifference {
  std::string what; // kProgramDiffers, kSceneDiffers, or a member of the settings: "--seed"
  std::string in_a; // its value as text: "none" if it is not set, "nothing" where there is no such member
  std::string in_b;
  bool operator==(const ImageDifference&) const = default;
};

// Returns the differences that keep two accumulations from belonging to one render; empty if they
// do belong to one. The part that each holds, the final number of samples, the arguments and the
// folder may differ.
[[nodiscard]] std::vector<ImageDifference> image_differences(const AccumulationIdentity& a,
                                                             const AccumulationIdentity& b);

// Checks that the render `now` may resume from `file`, which was read from `path`: both have the
// same program, settings and scene, and hold the same part of the samples unless both are whole
// renders. Fails (usage) with the differences.
[[nodiscard]] Result<void> check_same_render(const AccumulationIdentity& file, const std::filesystem::path& path,
                                             const AccumulationIdentity& now);

} // namespace kindling
