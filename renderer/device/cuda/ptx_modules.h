// Parts of a PTX text that can be compiled by themselves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace kindling {

// Returns the text with one entry point alone and all that it refers to, directly or not, in their
// order; empty if `ptx` has no such entry. A driver's compiler takes minutes for all kernels
// together, and a render needs a few of them.
//
// `ptx` is as LLVM writes it: no two symbols of one name, no sections for debuggers.
[[nodiscard]] std::string ptx_of_entry(std::string_view ptx, std::string_view entry);

} // namespace kindling
