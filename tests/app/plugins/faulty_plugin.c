// A plugin that goes wrong in the way that its options name; without any it is the template.
// SPDX-License-Identifier: Apache-2.0
#define _DEFAULT_SOURCE
#define kindling_accelerator_plugin template_plugin
#include "accel/plugin/template.c"
#undef kindling_accelerator_plugin

#include <pthread.h>
#include <string.h>
#include <unistd.h>

// Compile-time faults, of the library as a whole.
#ifndef PLUGIN_VERSION
#define PLUGIN_VERSION KINDLING_ACCELERATOR_VERSION
#endif

static char wanted[64];
static long calls = 0;

static int is(const char* fault) { return strcmp(wanted, fault) == 0; }
static void crash(void) {
  volatile int* volatile nowhere = NULL;
  *nowhere = 1;
}
static void hang(void) {
  for (;;) usleep(1000);
}

static KindlingAccelerator* faulty_build(const KindlingScene* scene, const KindlingBuildSettings* settings, char* error,
                                         size_t error_bytes) {
  snprintf(wanted, sizeof wanted, "%s", settings->options);
  calls = 0;
  if (is("crash-in-build")) crash();
  if (is("hang-in-build")) hang();
  if (is("exit-in-build")) _exit(3);
  if (is("abort-in-build")) abort();
  if (is("write-scene")) ((float*)scene->meshes[0].positions)[0] = 1.0f;
  if (is("print")) puts("a line on standard output");
  if (is("fail-build")) {
    snprintf(error, error_bytes, "no luck with\n%d threads", (int)settings->thread_count);
    return NULL;
  }
  if (is("silent-failure")) return NULL;
  if (is("endless-error")) {
    memset(error, 'x', error_bytes); // and no zero
    return NULL;
  }
  return build(scene, settings, error, error_bytes);
}

static void faulty_destroy(KindlingAccelerator* accelerator) {
  destroy(accelerator);
  if (is("crash-in-destroy")) crash();
}

static void* work(void* unused) {
  (void)unused;
  for (volatile long i = 0; i < 200000000; ++i) {
  }
  return NULL;
}

static int faulty_intersect(const KindlingAccelerator* accelerator, const KindlingRay* rays, KindlingHit* hits,
                            size_t count) {
  ++calls;
  if (is("crash-in-query") && calls == 40) crash();
  if (is("hang-in-query") && calls == 40) hang();
  if (is("fail-query") && calls == 40) return 7;
  if (is("leave-out") && count > 1) {
    --count;
    memset(&hits[count], 0xee, sizeof hits[count]);
  }
  if (is("threads") && calls == 1) {
    pthread_t thread;
    if (pthread_create(&thread, NULL, work, NULL) == 0) pthread_join(thread, NULL);
  }
  const int result = intersect(accelerator, rays, hits, count);
  for (size_t i = 0; i < count; ++i) {
    if (is("misses")) hits[i].instance = KINDLING_NO_HIT;
    if (hits[i].instance == KINDLING_NO_HIT) continue;
    if (is("wrong-instance")) hits[i].instance = 1000000;
    if (is("wrong-mesh")) hits[i].mesh = 1000000;
    if (is("wrong-triangle")) hits[i].triangle = 1000000;
    if (is("other-triangle")) hits[i].triangle ^= 1;
    if (is("nan")) hits[i].t = NAN;
    if (is("behind")) hits[i].t = -1.0f;
    if (is("outside")) hits[i].u = 2.0f;
    if (is("fickle")) hits[i].t *= 1.0f + 1e-6f * (float)(calls & 1023);
    if (is("nearly")) hits[i].t *= 1.0005f;
  }
  return result;
}

static int faulty_occluded(const KindlingAccelerator* accelerator, const KindlingRay* rays, uint8_t* blocked,
                           size_t count) {
  const int result = occluded(accelerator, rays, blocked, count);
  if (is("occluded-two"))
    for (size_t i = 0; i < count; ++i) blocked[i] = blocked[i] != 0 ? 2 : 0;
  return result;
}

static const char* faulty_error_text(int error) { return error == 7 ? "the query of doom" : NULL; }

static const KindlingAcceleratorTable faulty_table = {
    .version = PLUGIN_VERSION,
    .table_bytes = sizeof(KindlingAcceleratorTable),
    .description = "a plugin for tests",
    .build = faulty_build,
#ifndef PLUGIN_WITHOUT_DESTROY
    .destroy = faulty_destroy,
#endif
    .intersect = faulty_intersect,
    .occluded = faulty_occluded,
    .error_text = faulty_error_text,
};

#ifndef PLUGIN_WITHOUT_SYMBOL
const KindlingAcceleratorTable* kindling_accelerator_plugin(uint32_t newest) {
  (void)newest;
#ifdef PLUGIN_CRASHES_AT_ONCE
  crash();
#endif
#ifdef PLUGIN_WITHOUT_TABLE
  return NULL;
#else
  (void)template_plugin;
  return &faulty_table;
#endif
}
#endif
