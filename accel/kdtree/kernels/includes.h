// The headers that the kernels include from outside this folder.
// It precedes the pragma that raises the instruction set, so that no inline function of a foreign
// header is compiled for instructions that the rest of the program does not require.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/affine.h"
#include "accel/crossing_collector.h"
#include "accel/kdtree/candidate.h"
#include "accel/kdtree/config.h"
#include "accel/kdtree/crossing_batch.h"
#include "accel/kdtree/deforming/moving_block.h"
#include "accel/kdtree/node.h"
#include "accel/kdtree/queries.h"
#include "accel/kdtree/structure.h"
#include "accel/kdtree/tables.h"
#include "accel/kdtree/widening.h"
#include "accel/motion.h"
#include "accel/triangle.h"
#include "accel/vectors.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>
#include <span>
#include <type_traits>

#if defined(__x86_64__)
#include <immintrin.h>
#endif
