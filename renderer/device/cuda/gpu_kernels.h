// The kernels for GPUs as PTX, which a driver compiles; empty without clang-19 at build time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace kindling {

// Ends with a zero, which does not count.
[[nodiscard]] std::string_view gpu_kernels();

} // namespace kindling
