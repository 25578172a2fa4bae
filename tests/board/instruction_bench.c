/* Executed instructions of the runtime's calls, on an emulator that counts one
 * nanosecond an instruction (QEMU, -icount shift=0). Prints a line for each:
 * name, and instructions per call or per pixel times 100. */
#include <stdio.h>

#include "bench_scene.h"
#include "bench_stack.h"

#if defined(__arm__)

/* SysTick counts 25 MHz down, in 24 bits; 20 MHz on the board of the M33, 32
 * MHz on that of the M55. */
#if defined(__ARM_FEATURE_MVE)
#define INSTRUCTIONS_OF(ticks) ((ticks) / 4 * 125)
#elif defined(__ARM_ARCH_8M_MAIN__)
#define INSTRUCTIONS_OF(ticks) ((ticks)*50)
#else
#define INSTRUCTIONS_OF(ticks) ((ticks)*40)
#endif
#define SYSTICK ((volatile uint32_t*)0xe000e010)

static void start_clock(void) {
  SYSTICK[1] = 0xffffff;
  SYSTICK[2] = 0;
  SYSTICK[0] = 5;
  while (SYSTICK[2] == 0) {
  }
}

static uint32_t read_clock(void) { return 0xffffff - SYSTICK[2]; }

#elif defined(__XTENSA__)

/* The counter of cycles runs at 40 MHz. */
#define INSTRUCTIONS_OF(ticks) ((ticks)*25)

static void start_clock(void) {}

static uint32_t read_clock(void) {
  uint32_t cycles;
  __asm__ volatile("rsr %0, ccount" : "=r"(cycles));
  return cycles;
}

#else

#define INSTRUCTIONS_OF(ticks) (ticks)

static void start_clock(void) {}

static uint32_t read_clock(void) {
  uint32_t cycles;
  __asm__ volatile(".option arch, +zicsr\n\tcsrr %0, cycle" : "=r"(cycles));
  return cycles;
}

#endif

#define REPEATS 16u

static void print_cost(const char* name, uint32_t ticks, uint32_t count) {
  printf("%s %lu\n", name,
         (unsigned long)(INSTRUCTIONS_OF((uint64_t)ticks) * 100 / count));
}

/* A function that unprojects a pixel. */
typedef rg_status (*unprojection)(const rg_camera* camera, rg_pixel pixel,
                                  rg_ray* ray);

static rg_status do_nothing(const rg_camera* camera, rg_pixel pixel,
                            rg_ray* ray) {
  (void)camera, (void)pixel, (void)ray;
  return RG_OK;
}

/* Ticks of the calls and of the loop around them. */
static uint32_t time_unprojection(const rg_camera* camera,
                                  const rg_pixel* positions,
                                  unprojection call) {
  const unprojection volatile opaque = call;
  const unprojection unproject = opaque;
  const uint32_t begin = read_clock();
  for (uint32_t k = 0; k < NUM_POINTS * REPEATS; ++k)
    unproject(camera, positions[k % NUM_POINTS], &rays[k % NUM_POINTS]);
  return read_clock() - begin;
}

/* Without the loop's cost: that of a loop that calls an empty function. */
static void measure_unprojection(const char* name, const rg_camera* camera,
                                 const rg_pixel* positions, unprojection call) {
  const uint32_t loop = time_unprojection(camera, positions, do_nothing);
  const uint32_t ticks = time_unprojection(camera, positions, call);
  print_cost(name, ticks - loop, NUM_POINTS * REPEATS);
}

static rg_status unproject_line(const rg_camera* camera, rg_pixel pixel,
                                rg_ray* ray) {
  static rg_line line;
  (void)ray;
  return rg_unproject_line(camera, pixel, &line);
}

static void measure_points(void) {
  measure_unprojection("unproject", &lens, pixels, rg_unproject);
  measure_unprojection("unproject_narrow", &narrow, pixels, rg_unproject);
  measure_unprojection("unproject_line", &lines, line_pixels, unproject_line);

  uint32_t begin = read_clock();
  for (uint32_t k = 0; k < NUM_POINTS * REPEATS; ++k)
    rg_undistort_point(&lens, pixels[k % NUM_POINTS], &points[k % NUM_POINTS]);
  print_cost("undistort_point", read_clock() - begin, NUM_POINTS * REPEATS);

  begin = read_clock();
  for (uint32_t k = 0; k < NUM_POINTS * REPEATS; ++k)
    rg_project(&wide, &wide_rays[k % NUM_POINTS], &points[k % NUM_POINTS]);
  print_cost("project", read_clock() - begin, NUM_POINTS * REPEATS);

  begin = read_clock();
  for (uint32_t k = 0; k < NUM_POINTS * REPEATS; ++k)
    rg_project_point(&seen_lines, near_points[k % NUM_POINTS], 24,
                     &points[k % NUM_POINTS]);
  print_cost("project_point", read_clock() - begin, NUM_POINTS * REPEATS);

  begin = read_clock();
  for (uint32_t k = 0; k < NUM_POINTS * REPEATS; ++k)
    rg_project(&wide, &outside[k % NUM_POINTS], &points[k % NUM_POINTS]);
  print_cost("project_outside", read_clock() - begin, NUM_POINTS * REPEATS);
}

static void measure_remap(const char* name, rg_format format,
                          const uint32_t strides[3]) {
  const uint32_t begin = read_clock();
  const rg_status status = remap_frame(format, strides);
  const uint32_t end = read_clock();
  if (status != RG_OK) printf("%s: %s\n", name, rg_status_text(status));
  print_cost(name, end - begin, WIDTH * HEIGHT);
}

static void measure_remaps(void) {
  const uint32_t one[3] = {WIDTH, WIDTH, WIDTH}, two[3] = {2 * WIDTH, 0, 0},
                 three[3] = {3 * WIDTH, 0, 0},
                 packed[3] = {WIDTH / 4 * 5, 0, 0};
  measure_remap("remap_grey8", RG_FORMAT_GREY8, one);
  measure_remap("remap_grey16", RG_FORMAT_GREY16, two);
  measure_remap("remap_nv12", RG_FORMAT_NV12, one);
  measure_remap("remap_yuyv", RG_FORMAT_YUYV, two);
  measure_remap("remap_rgb24", RG_FORMAT_RGB24, three);
  measure_remap("remap_bayer10p", RG_FORMAT_BAYER10P, packed);
}

/* A grey frame of the stack's camera. */
static void measure_stack_frame(const char* name, uint8_t part_log2,
                                int is_between) {
  rg_camera camera;
  rg_status status = open_stack(part_log2, is_between, &camera);
  const rg_grey_image frame = {source, 160, 160, 120};
  const rg_grey_target band = {output, WIDTH, 0, HEIGHT, 0};
  const uint32_t begin = read_clock();
  if (status == RG_OK) status = rg_remap_grey(&camera, &frame, &band);
  const uint32_t end = read_clock();
  if (status != RG_OK) printf("%s: %s\n", name, rg_status_text(status));
  print_cost(name, end - begin, WIDTH * HEIGHT);
}

/* At a knot of a stack, and between two. */
static void measure_stacks(void) {
  static const char* const kNames[2][4] = {
      {"stack_unproject_knot", "stack_project_knot", "stack_grey8_16_knot",
       "stack_grey8_8_knot"},
      {"stack_unproject", "stack_project", "stack_grey8_16", "stack_grey8_8"}};
  for (int is_between = 0; is_between < 2; ++is_between) {
    const char* const* const names = kNames[is_between];
    rg_camera camera;
    if (open_stack(4, is_between, &camera) != RG_OK) printf("stack: fails\n");
    make_pixels(&camera, pixels);
    measure_unprojection(names[0], &camera, pixels, rg_unproject);
    rg_unproject_batch(&camera, pixels, rays, NUM_POINTS);
    const uint32_t begin = read_clock();
    for (uint32_t k = 0; k < NUM_POINTS * REPEATS; ++k)
      rg_project(&camera, &rays[k % NUM_POINTS], &points[k % NUM_POINTS]);
    print_cost(names[1], read_clock() - begin, NUM_POINTS * REPEATS);
    measure_stack_frame(names[2], 4, is_between);
    measure_stack_frame(names[3], 3, is_between);
  }
}

int main(void) {
  if (!make_scene(4)) return 1;
  start_clock();
  measure_points();
  measure_remaps();
  measure_stacks();
  return 0;
}
