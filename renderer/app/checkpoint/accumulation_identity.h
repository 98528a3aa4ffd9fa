// What an accumulation file says of the image that it belongs to.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/checkpoint/pixel_settings.h"
#include "renderer/base/result.h"
#include "renderer/session/accumulation_file.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace kindling::app {

// `scene_hash`: of all bytes that were read for the scene; that of the environment is put to it. The folder is the current one.
[[nodiscard]] AccumulationIdentity make_identity(const RenderOptions& options, const ResolvedImage& resolved,
                                                 uint64_t scene_hash);

// That a render which makes `now` may go on with what `file` holds, which was found in `path`: the same program, image and scene, and no
// fewer samples than were asked for then, unless it is a part. Fails (usage) with what differs.
[[nodiscard]] Result<void> check_same_render(const AccumulationIdentity& file, const std::filesystem::path& path,
                                             const AccumulationIdentity& now);

} // namespace kindling::app
