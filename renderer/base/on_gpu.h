// Differences of code that is compiled for a GPU.
// SPDX-License-Identifier: Apache-2.0
#pragma once

// 1 for a GPU, else 0.
#if defined(__NVPTX__) || defined(__AMDGCN__)
#define KINDLING_ON_GPU 1
#else
#define KINDLING_ON_GPU 0
#endif

// For functions that a compiler inlines into many places: a GPU's processors share a small cache of
// instructions, and its driver compiles the kernels when they are first used.
#if KINDLING_ON_GPU
#define KINDLING_CALLED_ON_GPU [[gnu::noinline]]
#else
#define KINDLING_CALLED_ON_GPU
#endif
