// All kernels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/kernels/first_hit_kernels.h"  // IWYU pragma: export
#include "renderer/device/kernels/kernel_list.h"        // IWYU pragma: export
#include "renderer/device/kernels/light_path_kernels.h" // IWYU pragma: export
#include "renderer/device/kernels/path_kernels.h"       // IWYU pragma: export
#include "renderer/device/kernels/ray_batch.h"          // IWYU pragma: export
#include "renderer/device/kernels/reuse_kernels.h"      // IWYU pragma: export
#include "renderer/device/kernels/split_kernels.h"      // IWYU pragma: export
#include "renderer/device/kernels/tree_kernels.h"       // IWYU pragma: export
