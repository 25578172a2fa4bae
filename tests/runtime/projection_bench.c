/* Time of unprojection and projection on this machine: medians over runs, of
 * the golden lens of 220 degrees, points of its area in random order. */
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "golden_blobs.h"
#include "raygrid.h"
#include "test_frame.h"

#define NUM_POINTS 4096u
#define NUM_RUNS 101

static rg_camera wide;
static rg_pixel pixels[NUM_POINTS], found[NUM_POINTS];
static rg_ray rays[NUM_POINTS], outside[NUM_POINTS];

static void unproject(void) {
  rg_unproject_batch(&wide, pixels, rays, NUM_POINTS);
}

static void project(void) { rg_project_batch(&wide, rays, found, NUM_POINTS); }

static void project_outside(void) {
  rg_project_batch(&wide, outside, found, NUM_POINTS);
}

static double now_ns(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (double)time.tv_sec * 1e9 + (double)time.tv_nsec;
}

static int compare(const void* a, const void* b) {
  const double x = *(const double*)a, y = *(const double*)b;
  return (x > y) - (x < y);
}

static void print_median(const char* name, void (*span)(void)) {
  double times_ns[NUM_RUNS];
  for (int k = 0; k < NUM_RUNS; ++k) {
    const double begin_ns = now_ns();
    span();
    times_ns[k] = (now_ns() - begin_ns) / NUM_POINTS;
  }
  qsort(times_ns, NUM_RUNS, sizeof(times_ns[0]), compare);
  printf("%-28s %6.1f ns\n", name, times_ns[NUM_RUNS / 2]);
}

int main(void) {
  uint32_t random = 5;
  if (rg_camera_open(&wide, kWideBlob, sizeof(kWideBlob)) != RG_OK) return 1;
  for (uint32_t i = 0; i < NUM_POINTS; ++i) {
    pixels[i].x_q16 = (int32_t)(next_random(&random) % RG_PIXEL(319));
    pixels[i].y_q16 = (int32_t)(next_random(&random) % RG_PIXEL(239));
  }
  unproject();
  for (uint32_t i = 0; i < NUM_POINTS; ++i) {
    outside[i] = rays[i];
    outside[i].z_q30 = INT32_MIN;
  }
  print_median("un-project", unproject);
  print_median("project", project);
  print_median("project, outside the field", project_outside);
  return 0;
}
