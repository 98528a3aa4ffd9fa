// Loader of the module kindling_oiio.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/image/oiio_interface.h"

#include <filesystem>
#include <span>
#include <vector>

namespace kindling::image_detail {

// The functions of the module, which is never unloaded. OpenImageIO links about 230 shared
// libraries on common systems, which would cost every start 0.2 s and 100 MB; a module is only
// loaded by runs that need it.
struct OiioModule {
  kindling_oiio_write_tiled_function* write_tiled = nullptr;
  kindling_oiio_open_cache_function* open_cache = nullptr;
  kindling_oiio_close_cache_function* close_cache = nullptr;
  kindling_oiio_add_to_cache_function* add_to_cache = nullptr;
  kindling_oiio_fetch_texels_function* fetch_texels = nullptr;
};

// Returns the module, which the first call loads; a failure is final. Thread-safe.
[[nodiscard]] const Result<OiioModule>& oiio_module();

// Returns the folders that oiio_module() searches, in order: that of the running program, that of
// an installation around it, that of the shared library that has this code, if one does, and the
// configured installation and build folders.
[[nodiscard]] std::vector<std::filesystem::path> oiio_module_folders();

// Loads the module from the first of these folders that has one.
[[nodiscard]] Result<OiioModule> load_oiio_module(std::span<const std::filesystem::path> folders);

} // namespace kindling::image_detail
