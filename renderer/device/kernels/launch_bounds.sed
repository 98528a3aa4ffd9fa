# Launch bounds of entry points, for sed -E: clang has an attribute for them in CUDA alone.
#
# Blocks have kThreadsPerBlock (cuda_device.cpp) threads. Six of them fit a multiprocessor's 65,536
# registers if a thread has at most 80; with 128, four would.
# SPDX-License-Identifier: Apache-2.0
/^\.visible \.entry kindling_(intersect_opaque|trace_shadow_opaque|trace_sight_opaque|trace_link_opaque|nearest_hit|any_hit)\(/,/^\{/ s/^\{/.maxntid 128, 1, 1\n.minnctapersm 6\n{/
