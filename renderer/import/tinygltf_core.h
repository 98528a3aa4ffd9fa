// tinygltf, compiled into this folder under a namespace of our own.
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Debian's libdraco exports the symbols of another version of tinygltf than libtinygltf does; whichever the loader finds first
// serves both, and corrupts memory. So the package's header is compiled here (tinygltf_core.cpp), renamed, and neither library's
// copy is ever called. Nothing may include <tiny_gltf.h> but by this file.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define tinygltf kindling_tinygltf
#include <tiny_gltf.h>
#undef tinygltf

namespace kindling::gltf {
namespace tinygltf = kindling_tinygltf;
}
