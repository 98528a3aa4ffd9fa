// The C interface of accelerator plugins: shared libraries that `kindling shootout --plugin` races.
//
// Plain C99, and C++. A plugin exports one function, kindling_accelerator_plugin(), which returns a
// table of functions. template.c is a complete one; README.md has the rules.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// The version of this header. A new one keeps the meaning of all older versions.
#define KINDLING_ACCELERATOR_VERSION 1u

// KindlingHit::instance of a ray that hits nothing.
#define KINDLING_NO_HIT 0xffffffffu

// A ray, 48 bytes; arrays of rays are aligned to 16. The direction need not be normalized: t counts
// in lengths of it. Hits lie in (t_min, t_max]; a t_min below 0 counts as 0, t_max may be infinite.
// A ray hits nothing if its direction is zero, a number of it is NaN, or origin or direction are
// not finite.
typedef struct KindlingRay {
  float origin[3];
  float t_min;
  float direction[3];
  float t_max;
  uint32_t reserved[4]; // of no meaning to a plugin
} KindlingRay;

// The nearest hit of a ray, 24 bytes. u and v are barycentric coordinates in [0, 1]:
// p = (1 - u - v) p0 + u p1 + v p2. Where instance is KINDLING_NO_HIT the rest has no meaning.
typedef struct KindlingHit {
  float t;
  float u, v;
  uint32_t instance; // index into KindlingScene::instances
  uint32_t mesh;     // index into KindlingScene::meshes, one of the instance's meshes
  uint32_t triangle; // index of the triangle in its mesh
} KindlingHit;

// An indexed triangle mesh in its own space. Both sides of a triangle can be hit. Triangles without
// area, or with a vertex that is not finite, are never hit.
typedef struct KindlingMesh {
  const float* positions;  // three for each vertex; 16 bytes after the last one are readable
  const uint32_t* indices; // three for each triangle, each below vertex_count
  uint64_t vertex_count;
  uint64_t triangle_count;
} KindlingMesh;

// Meshes placed in the world: [first_mesh, first_mesh + mesh_count). Column vectors, by rows:
// p_world[i] = sum over k of object_to_world[i][k] p[k] + object_to_world[i][3]. Nothing of an
// instance is hit if the matrix cannot be inverted.
typedef struct KindlingInstance {
  float object_to_world[3][4];
  uint32_t first_mesh;
  uint32_t mesh_count;
  uint32_t is_identity; // 1 if the matrix is the identity, else 0
  uint32_t reserved;
} KindlingInstance;

// Everything to build over. Arrays are borrowed: they remain until destroy(), and cannot be written
// to.
typedef struct KindlingScene {
  const KindlingMesh* meshes;
  const KindlingInstance* instances;
  uint64_t mesh_count;
  uint64_t instance_count;
} KindlingScene;

typedef struct KindlingBuildSettings {
  uint32_t version;      // of the interface, as agreed on
  uint32_t thread_count; // threads that the build may use, the calling one included
  const char* options;   // the text after the comma of --plugin FILE,OPTIONS; empty if there is none
} KindlingBuildSettings;

// Figures for reports; 0 stands for unknown.
typedef struct KindlingStatistics {
  uint64_t memory_bytes; // held by the accelerator, without the arrays of the scene
  uint64_t node_count;
  uint64_t leaf_count;
  uint64_t reference_count; // references to triangles in leaves
} KindlingStatistics;

// Whatever the plugin keeps of a build.
typedef struct KindlingAccelerator KindlingAccelerator;

// The functions of a plugin. All are called on one thread, and queries start none of their own.
// Queries return 0, or another number if they fail; the race of the plugin then ends. The same ray
// gets the same answer whenever and in whatever batch it is asked for; coherent queries may differ
// by rounding. No C++ exception may leave them.
typedef struct KindlingAcceleratorTable {
  uint32_t version;        // of the interface that the table follows
  uint32_t table_bytes;    // sizeof(KindlingAcceleratorTable) of the header that it was compiled with
  const char* description; // one line for reports, as "8-wide compressed BVH"

  // Returns null if the build fails, with a reason in `error`, zero-terminated within `error_bytes`
  // bytes. Not called with accelerators that are still in use.
  KindlingAccelerator* (*build)(const KindlingScene* scene, const KindlingBuildSettings* settings, char* error,
                                size_t error_bytes);
  void (*destroy)(KindlingAccelerator* accelerator);

  // Sets each of the `count` hits to the nearest one of its ray. Rays are mixed; a count of 1 is
  // usual.
  int (*intersect)(const KindlingAccelerator* accelerator, const KindlingRay* rays, KindlingHit* hits, size_t count);
  // Sets occluded[i] to 1 if ray i hits anything, else to 0.
  int (*occluded)(const KindlingAccelerator* accelerator, const KindlingRay* rays, uint8_t* occluded, size_t count);

  // The same for rays that start close together and point almost the same way. Null: the functions
  // above.
  int (*intersect_coherent)(const KindlingAccelerator* accelerator, const KindlingRay* rays, KindlingHit* hits,
                            size_t count);
  int (*occluded_coherent)(const KindlingAccelerator* accelerator, const KindlingRay* rays, uint8_t* occluded,
                           size_t count);

  // Null: nothing is known.
  void (*statistics)(const KindlingAccelerator* accelerator, KindlingStatistics* statistics);
  // Returns a text for a number that a query returned, or null. Null: there are no texts.
  const char* (*error_text)(int error);
} KindlingAcceleratorTable;

// The function that a plugin exports. `newest` is the newest version that the caller knows; it
// knows all from 1 on. Returns the table for that version or an older one, which remains valid;
// null if the plugin has none.
#if defined(_WIN32)
#define KINDLING_EXPORT __declspec(dllexport)
#else
#define KINDLING_EXPORT __attribute__((visibility("default")))
#endif
KINDLING_EXPORT const KindlingAcceleratorTable* kindling_accelerator_plugin(uint32_t newest);

#ifdef __cplusplus
}
#endif
