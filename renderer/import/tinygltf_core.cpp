// The one place where tinygltf is compiled.
// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_INCLUDE_JSON
#include "renderer/import/tinygltf_core.h"
