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

// Returns how many registers a thread may have by the launch bounds of an entry point (.maxntid N,
// .minnctapersm N) in the text, of the 65,536 of a multiprocessor, which gives them out by eights;
// 255, all of them, without bounds.
//
// A driver's linker compiles functions that are called by themselves, without the bounds of their
// callers, and refuses them where they take more. So it needs this limit.
[[nodiscard]] unsigned max_registers(std::string_view ptx);

} // namespace kindling
