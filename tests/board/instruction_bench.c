/* Executed instructions of the runtime's calls, on an emulator that counts one
 * nanosecond an instruction (QEMU, -icount shift=0). Prints a line for each:
 * name, and instructions per call or per pixel times 100. */
#include <stdio.h>
#include <string.h>

#include "golden_blobs.h"
#include "raygrid.h"
#include "rg_blob.h"
#include "test_frame.h"

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

#else

#define INSTRUCTIONS_OF(ticks) (ticks)

static void start_clock(void) {}

static uint32_t read_clock(void) {
  uint32_t cycles;
  __asm__ volatile(".option arch, +zicsr\n\tcsrr %0, cycle" : "=r"(cycles));
  return cycles;
}

#endif

#define NUM_POINTS 512u
#define WIDTH 64u
#define HEIGHT 48u
#define REPEATS 16u

static rg_camera lens, narrow, lines, wide, inner;
static rg_pixel pixels[NUM_POINTS], wide_pixels[NUM_POINTS], points[NUM_POINTS];
static rg_ray rays[NUM_POINTS], outside[NUM_POINTS];
static uint8_t source[WIDTH * HEIGHT * 4] __attribute__((aligned(4)));
static uint8_t output[WIDTH * HEIGHT * 4] __attribute__((aligned(4)));

static void print_cost(const char* name, uint32_t ticks, uint32_t count) {
  printf("%s %lu\n", name,
         (unsigned long)(INSTRUCTIONS_OF(ticks) / (count / 100)));
}

/* Random pixels of an area. */
static void make_pixels(const rg_camera* camera, rg_pixel* result) {
  uint32_t random = 7;
  uint32_t num_made = 0;
  while (num_made < NUM_POINTS) {
    const rg_pixel pixel = {(int32_t)(next_random(&random) >> 7),
                            (int32_t)(next_random(&random) >> 7)};
    if (rg_is_valid(camera, pixel)) result[num_made++] = pixel;
  }
}

/* A table of blocks of 16 whose sources all lie inside. */
static void open_inner(void) {
  static uint8_t bytes[1024] __attribute__((aligned(4)));
  static const int16_t residuals[2 * 5 * 4];
  static const uint8_t empty[4];
  static const int32_t control_points[2 * 4 * 4];
  rg_blob blob;
  rg_camera_section identity;
  rg_grid_section grid;
  const rg_remap_section table = {.width = WIDTH,
                                  .height = HEIGHT,
                                  .columns = 5,
                                  .rows = 4,
                                  .block_log2 = 4,
                                  .max_x_q12 = 63 << 12,
                                  .max_y_q12 = 47 << 12,
                                  .origin_x_q12 = 5000,
                                  .origin_y_q12 = 9000,
                                  .column_step_x_q12 = 59000,
                                  .column_step_y_q12 = 1300,
                                  .row_step_x_q12 = -800,
                                  .row_step_y_q12 = 57000,
                                  .fx_q16 = 1,
                                  .fy_q16 = 1,
                                  .empty_blocks = empty};
  if (rg_blob_open(kExampleBlob, sizeof(kExampleBlob), &blob) != RG_OK) return;
  rg_blob_camera(&blob, &identity);
  rg_blob_grid(&blob, &grid);
  const rg_blob_contents contents = {.camera = &identity,
                                     .grid = &grid,
                                     .control_points_q29 = control_points,
                                     .remap = &table,
                                     .residuals = residuals};
  if (rg_blob_write(&contents, bytes, sizeof(bytes)) == RG_OK)
    rg_camera_open(&inner, bytes, sizeof(bytes));
}

/* What un-projects a pixel. */
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
  static rg_pixel line_pixels[NUM_POINTS];
  make_pixels(&lines, line_pixels);
  measure_unprojection("unproject", &lens, pixels, rg_unproject);
  measure_unprojection("unproject_narrow", &narrow, pixels, rg_unproject);
  measure_unprojection("unproject_line", &lines, line_pixels, unproject_line);

  uint32_t begin = read_clock();
  for (uint32_t k = 0; k < NUM_POINTS * REPEATS; ++k)
    rg_undistort_point(&lens, pixels[k % NUM_POINTS], &points[k % NUM_POINTS]);
  print_cost("undistort_point", read_clock() - begin, NUM_POINTS * REPEATS);

  rg_unproject_batch(&wide, wide_pixels, rays, NUM_POINTS);
  begin = read_clock();
  for (uint32_t k = 0; k < NUM_POINTS * REPEATS; ++k)
    rg_project(&wide, &rays[k % NUM_POINTS], &points[k % NUM_POINTS]);
  print_cost("project", read_clock() - begin, NUM_POINTS * REPEATS);

  for (uint32_t k = 0; k < NUM_POINTS; ++k) {
    outside[k] = rays[k];
    outside[k].z_q30 = -0x7fffffff;
  }
  begin = read_clock();
  for (uint32_t k = 0; k < NUM_POINTS * REPEATS; ++k)
    rg_project(&wide, &outside[k % NUM_POINTS], &points[k % NUM_POINTS]);
  print_cost("project_outside", read_clock() - begin, NUM_POINTS * REPEATS);
}

static void measure_remap(const char* name, rg_format format,
                          const uint32_t strides[3]) {
  rg_image image;
  rg_target target;
  memset(&image, 0, sizeof(image));
  memset(&target, 0, sizeof(target));
  image.format = format;
  image.width = WIDTH;
  image.height = HEIGHT;
  target.num_rows = HEIGHT;
  for (int plane = 0; plane < 3; ++plane) {
    image.planes[plane].data = source;
    image.planes[plane].stride = strides[plane];
    target.planes[plane].data = output + (uint32_t)plane * (WIDTH * HEIGHT);
    target.planes[plane].stride = strides[plane];
  }
  const uint32_t begin = read_clock();
  const rg_status status = rg_remap(&inner, &image, &target);
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

int main(void) {
  if (rg_camera_open(&lens, kLensBlob, sizeof(kLensBlob)) != RG_OK ||
      rg_camera_open(&narrow, kNarrowBlob, sizeof(kNarrowBlob)) != RG_OK ||
      rg_camera_open(&lines, kLinesBlob, sizeof(kLinesBlob)) != RG_OK ||
      rg_camera_open(&wide, kWideBlob, sizeof(kWideBlob)) != RG_OK)
    return 1;
  open_inner();
  make_pixels(&lens, pixels);
  make_pixels(&wide, wide_pixels);
  make_test_frame(source, 4 * WIDTH, 4 * WIDTH, HEIGHT);
  start_clock();
  measure_points();
  measure_remaps();
  return 0;
}
