// Finds and loads the module kindling_oiio. OpenImageIO brings some 230 shared libraries with it on common systems: they
// would cost every start 0.2 s and 100 MB, so only those runs pay that read what it alone can decode.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/image/oiio_interface.h"

#include <filesystem>
#include <span>
#include <vector>

namespace kindling::image_detail {

// Never unloaded; valid for the rest of the process.
struct OiioModule {
  kindling_oiio_decode_hdr_function* decode_hdr = nullptr;
  kindling_oiio_write_tiled_function* write_tiled = nullptr;
  kindling_oiio_open_cache_function* open_cache = nullptr;
  kindling_oiio_close_cache_function* close_cache = nullptr;
  kindling_oiio_add_to_cache_function* add_to_cache = nullptr;
  kindling_oiio_fetch_texels_function* fetch_texels = nullptr;
};

// Loaded by the first call, which also settles failure. Thread-safe.
[[nodiscard]] const Result<OiioModule>& oiio_module();

// The folders that oiio_module() looks in, in that order: of the running program, of an installation around it, of the
// installation and of the build that were configured.
[[nodiscard]] std::vector<std::filesystem::path> oiio_module_folders();

// The module in the first of these folders that has one.
[[nodiscard]] Result<OiioModule> load_oiio_module(std::span<const std::filesystem::path> folders);

} // namespace kindling::image_detail
