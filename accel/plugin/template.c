// A plugin to start from: brute force over the boxes of the meshes, in about a hundred lines.
// Build and race it:
//   cc -std=c99 -O3 -shared -fPIC template.c -o libtemplate.so
//   kindling shootout scenes/cornell_box.glb --plugin ./libtemplate.so
// SPDX-License-Identifier: Apache-2.0
#include "kindling_accelerator.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

// Whatever your structure is; here the scene itself, with the inverse of each instance's matrix.
struct KindlingAccelerator {
  const KindlingScene* scene;
  float (*to_object)[3][4];
  unsigned char* is_singular;
};

static int invert(const float m[3][4], float inverse[3][4]) {
  double c[3][3], determinant = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) { // cofactors, transposed
      const int a = (k + 1) % 3, b = (k + 2) % 3, p = (i + 1) % 3, q = (i + 2) % 3;
      c[i][k] = (double)m[a][p] * m[b][q] - (double)m[a][q] * m[b][p];
    }
  for (int k = 0; k < 3; ++k) determinant += m[0][k] * c[k][0];
  if (!isfinite(determinant) || determinant == 0.0) return 0;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) inverse[i][k] = (float)(c[i][k] / determinant);
    inverse[i][3] = (float)(-(c[i][0] * m[0][3] + c[i][1] * m[1][3] + c[i][2] * m[2][3]) / determinant);
  }
  return 1;
}

static void destroy(KindlingAccelerator* a) {
  free(a->to_object);
  free(a->is_singular);
  free(a);
}

static KindlingAccelerator* build(const KindlingScene* scene, const KindlingBuildSettings* settings, char* error,
                                  size_t error_bytes) {
  (void)settings; // thread_count and options are here
  KindlingAccelerator* a = calloc(1, sizeof *a);
  if (a != NULL) a->to_object = calloc(scene->instance_count + 1, sizeof *a->to_object);
  if (a != NULL) a->is_singular = calloc(scene->instance_count + 1, 1);
  if (a == NULL || a->to_object == NULL || a->is_singular == NULL) {
    snprintf(error, error_bytes, "no memory for %llu instances", (unsigned long long)scene->instance_count);
    if (a != NULL) destroy(a);
    return NULL;
  }
  a->scene = scene;
  for (uint64_t i = 0; i < scene->instance_count; ++i)
    a->is_singular[i] = !invert(scene->instances[i].object_to_world, a->to_object[i]);
  return a;
}

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static void cross(const double a[3], const double b[3], double c[3]) {
  for (int k = 0; k < 3; ++k) c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

// Moeller and Trumbore in double precision; shortens *t_max if the triangle is hit.
static int hit_triangle(const KindlingMesh* mesh, uint64_t triangle, const double o[3], const double d[3], double t_min,
                        float* t_max, KindlingHit* hit) {
  double e1[3], e2[3], s[3], p[3], q[3];
  const float* v[3];
  for (int k = 0; k < 3; ++k) v[k] = mesh->positions + 3 * (size_t)mesh->indices[3 * triangle + k];
  for (int k = 0; k < 3; ++k) {
    e1[k] = (double)v[1][k] - v[0][k];
    e2[k] = (double)v[2][k] - v[0][k];
    s[k] = o[k] - v[0][k];
  }
  cross(d, e2, p);
  cross(s, e1, q);
  const double determinant = dot(e1, p);
  if (!(determinant != 0.0)) return 0;
  const double u = dot(s, p) / determinant, w = dot(d, q) / determinant, t = dot(e2, q) / determinant;
  if (!(u >= 0.0 && w >= 0.0 && u + w <= 1.0 && t > t_min && t <= *t_max)) return 0;
  *t_max = hit->t = (float)t;
  hit->u = (float)u;
  hit->v = (float)w;
  hit->triangle = (uint32_t)triangle;
  return 1;
}

static void trace(const KindlingAccelerator* a, const KindlingRay* ray, int any, KindlingHit* hit) {
  float t_max = ray->t_max;
  hit->instance = KINDLING_NO_HIT;
  for (uint64_t i = 0; i < a->scene->instance_count && !(any && hit->instance != KINDLING_NO_HIT); ++i) {
    const KindlingInstance* instance = &a->scene->instances[i];
    if (a->is_singular[i]) continue;
    double o[3], d[3];
    for (int k = 0; k < 3; ++k) {
      const float* row = a->to_object[i][k];
      o[k] =
          (double)row[0] * ray->origin[0] + (double)row[1] * ray->origin[1] + (double)row[2] * ray->origin[2] + row[3];
      d[k] =
          (double)row[0] * ray->direction[0] + (double)row[1] * ray->direction[1] + (double)row[2] * ray->direction[2];
    }
    for (uint32_t m = instance->first_mesh; m < instance->first_mesh + instance->mesh_count; ++m)
      for (uint64_t n = 0; n < a->scene->meshes[m].triangle_count; ++n)
        if (hit_triangle(&a->scene->meshes[m], n, o, d, fmax(ray->t_min, 0.0), &t_max, hit)) {
          hit->instance = (uint32_t)i;
          hit->mesh = m;
        }
  }
}

static int intersect(const KindlingAccelerator* a, const KindlingRay* rays, KindlingHit* hits, size_t count) {
  for (size_t i = 0; i < count; ++i) trace(a, &rays[i], 0, &hits[i]);
  return 0;
}

static int occluded(const KindlingAccelerator* a, const KindlingRay* rays, uint8_t* blocked, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    KindlingHit hit;
    trace(a, &rays[i], 1, &hit);
    blocked[i] = hit.instance != KINDLING_NO_HIT;
  }
  return 0;
}

static const KindlingAcceleratorTable table = {
    .version = KINDLING_ACCELERATOR_VERSION,
    .table_bytes = sizeof(KindlingAcceleratorTable),
    .description = "a loop over all triangles",
    .build = build,
    .destroy = destroy,
    .intersect = intersect,
    .occluded = occluded,
};

const KindlingAcceleratorTable* kindling_accelerator_plugin(uint32_t newest) {
  return newest >= KINDLING_ACCELERATOR_VERSION ? &table : NULL;
}
