/* The runtime's calls one after another, for an emulator that notes every
 * instruction (QEMU's user mode, -singlestep -d exec,nochain): mark_call() runs
 * before each and after the last. With an argument, their names and units a
 * call instead. */
#include <stdio.h>

#include "bench_scene.h"

/* Enough for a mean. */
#define NUM_TRACED 128u

static __attribute__((noinline)) void mark_call(void) {
  __asm__ volatile("" ::: "memory");
}

static void unproject(void) {
  rg_unproject_batch(&lens, pixels, rays, NUM_TRACED);
}

static void unproject_narrow(void) {
  rg_unproject_batch(&narrow, pixels, rays, NUM_TRACED);
}

static void unproject_lines(void) {
  static rg_line line;
  for (uint32_t k = 0; k < NUM_TRACED; ++k)
    rg_unproject_line(&lines, line_pixels[k], &line);
}

static void undistort_points(void) {
  rg_undistort_points(&lens, pixels, points, NUM_TRACED);
}

static void project(void) {
  rg_project_batch(&wide, wide_rays, points, NUM_TRACED);
}

static void project_points(void) {
  for (uint32_t k = 0; k < NUM_TRACED; ++k)
    rg_project_point(&seen_lines, near_points[k], 24, &points[k]);
}

static void refuse(void) {
  rg_project_batch(&wide, outside, points, NUM_TRACED);
}

static void remap(rg_format format, uint32_t stride) {
  const uint32_t strides[3] = {stride, WIDTH, WIDTH};
  remap_frame(format, strides);
}

static void remap_grey8(void) { remap(RG_FORMAT_GREY8, WIDTH); }
static void remap_grey16(void) { remap(RG_FORMAT_GREY16, 2 * WIDTH); }
static void remap_nv12(void) { remap(RG_FORMAT_NV12, WIDTH); }
static void remap_yuyv(void) { remap(RG_FORMAT_YUYV, 2 * WIDTH); }
static void remap_rgb24(void) { remap(RG_FORMAT_RGB24, 3 * WIDTH); }
static void remap_bayer10p(void) { remap(RG_FORMAT_BAYER10P, WIDTH / 4 * 5); }

typedef struct traced_call {
  const char* name;
  void (*call)(void);
  uint32_t num_units; /* points or pixels */
  uint8_t block_log2;
} traced_call;

#define POINTS(name) \
  { #name, name, NUM_TRACED, 4 }
#define REMAPS(name) \
  {#name, name, WIDTH * HEIGHT, 5}, { #name "_16", name, WIDTH* HEIGHT, 4 }
static const traced_call kCalls[] = {
    POINTS(unproject),        POINTS(unproject_narrow), POINTS(unproject_lines),
    POINTS(undistort_points), POINTS(project),          POINTS(project_points),
    POINTS(refuse),           REMAPS(remap_grey8),      REMAPS(remap_grey16),
    REMAPS(remap_nv12),       REMAPS(remap_yuyv),       REMAPS(remap_rgb24),
    REMAPS(remap_bayer10p)};
#define NUM_CALLS (sizeof(kCalls) / sizeof(kCalls[0]))

int main(int argc, char** argv) {
  (void)argv;
  if (argc > 1) {
    for (uint32_t k = 0; k < NUM_CALLS; ++k)
      printf("%s %u\n", kCalls[k].name, (unsigned)kCalls[k].num_units);
    return 0;
  }
  if (!make_scene(4)) return 1;
  uint8_t block_log2 = 4;
  for (uint32_t k = 0; k < NUM_CALLS; ++k) {
    if (kCalls[k].block_log2 != block_log2) {
      block_log2 = kCalls[k].block_log2;
      open_inner(block_log2);
    }
    mark_call();
    kCalls[k].call();
    mark_call();
  }
  return 0;
}
