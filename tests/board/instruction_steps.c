/* One of the runtime's calls, some times over, for an emulator that notes every
 * instruction (QEMU's user mode, -singlestep -d exec,nochain): the difference
 * of two numbers of times is the call's own. instruction_steps prints numbers,
 * names, units a call instruction_steps NUMBER TIMES BLOCK_LOG2 */
#include <stdio.h>
#include <stdlib.h>

#include "bench_scene.h"

static void unproject(void) {
  rg_unproject_batch(&lens, pixels, rays, NUM_POINTS);
}

static void project(void) { rg_project_batch(&wide, rays, points, NUM_POINTS); }

static void remap_grey8(void) {
  static const uint32_t kStrides[3] = {WIDTH, 0, 0};
  remap_frame(RG_FORMAT_GREY8, kStrides);
}

static void remap_nv12(void) {
  static const uint32_t kStrides[3] = {WIDTH, WIDTH, 0};
  remap_frame(RG_FORMAT_NV12, kStrides);
}

static void remap_rgb24(void) {
  static const uint32_t kStrides[3] = {3 * WIDTH, 0, 0};
  remap_frame(RG_FORMAT_RGB24, kStrides);
}

static const struct {
  const char* name;
  void (*call)(void);
  uint32_t num_units; /* points or pixels */
} kCalls[] = {{"unproject", unproject, NUM_POINTS},
              {"project", project, NUM_POINTS},
              {"remap_grey8", remap_grey8, WIDTH* HEIGHT},
              {"remap_nv12", remap_nv12, WIDTH* HEIGHT},
              {"remap_rgb24", remap_rgb24, WIDTH* HEIGHT}};
#define NUM_CALLS (sizeof(kCalls) / sizeof(kCalls[0]))

int main(int argc, char** argv) {
  if (argc != 4) {
    for (uint32_t k = 0; k < NUM_CALLS; ++k)
      printf("%u %s %u\n", (unsigned)k, kCalls[k].name,
             (unsigned)kCalls[k].num_units);
    return 0;
  }
  const unsigned long number = strtoul(argv[1], NULL, 10);
  if (!make_scene((uint8_t)atoi(argv[3])) || number >= NUM_CALLS) return 1;
  for (int times = atoi(argv[2]); times > 0; --times) kCalls[number].call();
  return 0;
}
