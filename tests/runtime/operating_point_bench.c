/* Time of a camera between two samples of its stack, against the blob's own
 * camera: un-projection, and frames of each of the blob's tables.
 *   condition_bench BLOB VALUE
 * Runs of both take turns. Medians of 201 runs are printed, and that of the
 * ratios of runs one after the other. */
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "raygrid.h"

#define NUM_POINTS 4096u
#define NUM_RUNS 201

static rg_camera cameras[2]; /* the blob's own, at the condition */
static rg_pixel pixels[NUM_POINTS];
static rg_ray rays[NUM_POINTS];
static rg_grey_image frame;
static rg_grey_target band;

static void unproject(const rg_camera* camera) {
  rg_unproject_batch(camera, pixels, rays, NUM_POINTS);
}

static void remap(const rg_camera* camera) {
  rg_remap_grey(camera, &frame, &band);
}

static double now_us(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (double)time.tv_sec * 1e6 + (double)time.tv_nsec / 1e3;
}

static int compare(const void* a, const void* b) {
  const double x = *(const double*)a, y = *(const double*)b;
  return (x > y) - (x < y);
}

static double median(double values[NUM_RUNS]) {
  qsort(values, NUM_RUNS, sizeof(values[0]), compare);
  return values[NUM_RUNS / 2];
}

static void print_medians(const char* name, void (*span)(const rg_camera*)) {
  static double times_us[2][NUM_RUNS], ratios[NUM_RUNS];
  for (int k = 0; k < NUM_RUNS; ++k) {
    for (int c = 0; c < 2; ++c) {
      const double begin_us = now_us();
      span(&cameras[c]);
      times_us[c][k] = now_us() - begin_us;
    }
    ratios[k] = times_us[1][k] / times_us[0][k];
  }
  const double ratio = median(ratios);
  printf("%-20s %9.1f us, at the condition %9.1f us: %.3f times\n", name,
         median(times_us[0]), median(times_us[1]), ratio);
}

/* Frames of any content: what is there takes no time of its own. */
static int make_frames(void) {
  uint16_t width, height;
  rg_frame_size(&cameras[0], &frame.width, &frame.height);
  if (rg_remap_size(&cameras[0], &width, &height) != RG_OK) return 0;
  uint8_t* const source = calloc(frame.height, frame.width);
  uint8_t* const out = calloc(height, width);
  if (!source || !out) return 0;
  for (size_t k = 0; k < (size_t)frame.width * frame.height; ++k)
    source[k] = (uint8_t)(k * k >> 7);
  frame.data = source;
  frame.stride = frame.width;
  band.data = out;
  band.stride = width;
  band.num_rows = height;
  return 1;
}

static int open_cameras(const char* path, double value) {
  FILE* const file = fopen(path, "rb");
  if (!file) return 0;
  const size_t room = (size_t)1 << 24;
  uint8_t* const blob = malloc(room);
  const size_t size = blob ? fread(blob, 1, room, file) : 0;
  fclose(file);
  for (int c = 0; c < 2; ++c)
    if (rg_camera_open(&cameras[c], blob, (uint32_t)size) != RG_OK) return 0;
  if (rg_set_operating_point(&cameras[1], (int32_t)(value * 65536)) != RG_OK)
    return 0;
  uint16_t width, height;
  rg_calibrated_size(&cameras[0], &width, &height);
  uint32_t state = 5;
  for (uint32_t k = 0; k < NUM_POINTS; ++k) {
    state = state * 1664525u + 1013904223u;
    pixels[k].x_q16 = (int32_t)((state >> 16) % (width - 1u)) * 65536 + 999;
    pixels[k].y_q16 = (int32_t)((state & 0xffff) % (height - 1u)) * 65536 + 999;
  }
  return 1;
}

int main(int argc, char** argv) {
  if (argc != 3 || !open_cameras(argv[1], atof(argv[2]))) {
    fputs(
        "condition_bench BLOB VALUE: of a blob with a stack, and a value in "
        "its range\n",
        stderr);
    return 1;
  }
  print_medians("un-projection", unproject);
  for (uint32_t table = 0; rg_select_remap(&cameras[0], table) == RG_OK;
       ++table) {
    char name[40];
    if (rg_select_remap(&cameras[1], table) != RG_OK || !make_frames())
      return 1;
    snprintf(name, sizeof(name), "frames, table %u", (unsigned)table);
    print_medians(name, remap);
  }
  return 0;
}
