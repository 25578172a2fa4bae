/* Every set of kernels that this processor has gives the bits of a plain
 * reading of formats/SPEC.md (plain_remap.c), on random tables: mild, steep,
 * mirrored and broken ones, of even and odd sizes, with every border. Frames
 * lie in memory of exactly their size; where there are pages, one that cannot
 * be read begins where a frame ends, or ends where it begins. */
#if defined(__linux__)
#define _GNU_SOURCE
#endif
#include <stdio.h>

#include "kernels/kernel.h"
#include "plain_remap.h"
#include "random_tables.h"

#define GUARD 0xc3u
#define MARGIN 32u

#if defined(__unix__)
#define NUM_CASES 600u
#else
#define NUM_CASES 60u
#endif

#define RG_KERNEL(name, parts, abilities, runs) #name,
static const char* const kNames[] = {
    "portable", RG_ALL_KERNELS NULL /* the fastest, or the only one */};
#define NUM_NAMES (sizeof(kNames) / sizeof(kNames[0]))

/* ---- Frames -------------------------------------------------------------- */

typedef struct frame_style {
  rg_format format;
  uint32_t num_planes;
  plane_lattice planes[3];
} frame_style;

static const frame_style kFrames[] = {
    {RG_FORMAT_GREY8, 1, {{1, 0, 0}}},
    {RG_FORMAT_RGB24, 1, {{3, 0, 0}}},
    {RG_FORMAT_RGB32, 1, {{4, 0, 0}}},
    {RG_FORMAT_NV12, 2, {{1, 0, 0}, {2, 1, 1}}},
    {RG_FORMAT_YUV420, 3, {{1, 0, 0}, {1, 1, 1}, {1, 1, 1}}}};
#define NUM_FRAMES (sizeof(kFrames) / sizeof(kFrames[0]))

static const uint16_t kBorder[4] = {201, 17, 99, 255};

static uint8_t expected[3][(4 * MAX_SIZE + 8) * MAX_SIZE + 2 * MARGIN];
static uint8_t output[3][(4 * MAX_SIZE + 8) * MAX_SIZE + 2 * MARGIN];

static void check_frame(const frame_style* style) {
  rg_image image;
  rg_target target;
  exact_memory sources[3];
  uint32_t row_bytes[3];
  uint16_t width, height;
  rg_remap_section table;
  rg_remap_size(&camera, &width, &height);
  rg_read_remap(SECTION, &table);
  memset(&image, 0, sizeof(image));
  memset(&target, 0, sizeof(target));
  image.format = style->format;
  image.width = camera.frame_width;
  image.height = camera.frame_height;
  target.num_rows = height;
  target.border = (rg_border)below(3);
  target.sampling = below(4) == 0 ? RG_SAMPLING_NEAREST : RG_SAMPLING_BILINEAR;
  memcpy(target.border_values, kBorder, sizeof(kBorder));
  for (uint32_t k = 0; k < style->num_planes; ++k) {
    const plane_lattice component = style->planes[k];
    const uint32_t bytes =
        ((uint32_t)camera.frame_width >> component.l) * component.channels;
    const uint32_t padding = below(3) == 0 ? below(40) : 0;
    const uint32_t source_rows = (uint32_t)camera.frame_height >> component.l;
    const uint32_t size = (bytes + padding) * (source_rows - 1) + bytes;
    sources[k] = new_memory(size);
    uint8_t* const bytes_of_plane = sources[k].bytes;
    for (uint32_t i = 0; i < size; ++i)
      bytes_of_plane[i] =
          (uint8_t)(below(3) == 0 ? 255 * below(2) : below(256));
    image.planes[k].data = bytes_of_plane;
    image.planes[k].stride = bytes + padding;
    row_bytes[k] = ((uint32_t)width >> component.l) * component.channels;
    target.planes[k].stride = row_bytes[k] + below(9);
    target.planes[k].data = output[k] + MARGIN;
    memset(expected[k], GUARD, sizeof(expected[k]));
    const plain_source plain = {bytes_of_plane, image.planes[k].stride,
                                camera.frame_width, camera.frame_height};
    const plain_target wanted = {expected[k] + MARGIN, target.planes[k].stride,
                                 target.border, target.sampling,
                                 kBorder + (style->num_planes == 1 ? 0 : k)};
    remap_plainly(&table, component, &plain, &wanted);
  }
  for (uint32_t name = 0; name < NUM_NAMES; ++name) {
    target.kernels = rg_find_kernels(kNames[name]);
    if (kNames[name] && !target.kernels) continue;
    memset(output, GUARD, sizeof(output));
    assert_int_equal(rg_remap(&camera, &image, &target), RG_OK);
    for (uint32_t k = 0; k < style->num_planes; ++k)
      if (memcmp(output[k], expected[k], sizeof(output[k])) != 0)
        fail_msg("kernels %s, format %d, plane %u, %u x %u to %u x %u",
                 kNames[name] ? kNames[name] : "of this processor",
                 (int)style->format, (unsigned)k, camera.frame_width,
                 camera.frame_height, width, height);
  }
  for (uint32_t k = 0; k < style->num_planes; ++k) free_memory(&sources[k]);
}

static void every_kernel_gives_the_specified_bits(void** unused) {
  (void)unused;
  uint32_t num_checked = 0, num_odd = 0;
  for (uint32_t k = 0; k < NUM_CASES; ++k) {
    state = 12345 + 7919 * k;
    const frame_style* const frame = &kFrames[below(NUM_FRAMES)];
    if (!make_table(k % NUM_STYLES, frame->num_planes == 1 ? 1 : 2)) continue;
    check_frame(frame);
    ++num_checked;
    num_odd += camera.frame_width & camera.frame_height & 1u;
  }
  printf("%u of %u tables, %u of frames of odd width and height\n",
         (unsigned)num_checked, (unsigned)NUM_CASES, (unsigned)num_odd);
  assert_true(num_checked > NUM_CASES / 2);
  assert_true(num_odd > NUM_CASES / 20);
}

/* ---- Frames of YUYV ------------------------------------------------------ */

/* Luma of YUYV is that of a grey frame, chroma the same by all kernels. */
static void check_yuyv(void) {
  static uint8_t luma[MAX_SIZE * MAX_SIZE], first[sizeof(output[0])];
  rg_image image;
  rg_target target;
  rg_remap_section table;
  uint16_t width, height;
  rg_remap_size(&camera, &width, &height);
  rg_read_remap(SECTION, &table);
  memset(&image, 0, sizeof(image));
  memset(&target, 0, sizeof(target));
  image.format = RG_FORMAT_YUYV;
  image.width = camera.frame_width;
  image.height = camera.frame_height;
  image.planes[0].stride = 2u * image.width;
  const uint32_t size = image.planes[0].stride * image.height;
  exact_memory memory = new_memory(size);
  image.planes[0].data = memory.bytes;
  for (uint32_t i = 0; i < size; ++i) memory.bytes[i] = (uint8_t)below(256);
  for (uint32_t i = 0; i < size; i += 2) luma[i / 2] = memory.bytes[i];
  target.num_rows = height;
  target.border = (rg_border)below(3);
  memcpy(target.border_values, kBorder, sizeof(kBorder));
  target.planes[0].stride = 2u * width + below(9);
  target.planes[0].data = output[0] + MARGIN;
  memset(expected[0], GUARD, sizeof(expected[0]));
  const plain_source plain = {luma, image.width, image.width, image.height};
  const plain_target wanted = {expected[0], width, target.border,
                               target.sampling, kBorder};
  const plane_lattice grey = {1, 0, 0};
  int has_first = 0;
  remap_plainly(&table, grey, &plain, &wanted);
  for (uint32_t name = 0; name < NUM_NAMES; ++name) {
    target.kernels = rg_find_kernels(kNames[name]);
    if (kNames[name] && !target.kernels) continue;
    memset(output[0], GUARD, sizeof(output[0]));
    assert_int_equal(rg_remap(&camera, &image, &target), RG_OK);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x)
        if (target.planes[0].data[y * target.planes[0].stride + 2 * x] !=
            expected[0][y * width + x])
          fail_msg("kernels %u, luma at %u, %u", (unsigned)name, (unsigned)x,
                   (unsigned)y);
    if (!has_first) memcpy(first, output[0], sizeof(first));
    has_first = 1;
    assert_memory_equal(output[0], first, sizeof(first));
  }
  free_memory(&memory);
}

static void frames_of_yuyv_are_the_same_by_every_kernel(void** unused) {
  (void)unused;
  uint32_t num_checked = 0;
  for (uint32_t k = 0; k < NUM_CASES; ++k) {
    state = 4321 + 7919 * k;
    if (!make_table(k % NUM_STYLES, 2)) continue;
    check_yuyv();
    ++num_checked;
  }
  assert_true(num_checked > NUM_CASES / 2);
}

/* ---- Frames of RGB565 ---------------------------------------------------- */

/* The fields of words, and what a target of them holds before. */
static const uint32_t kFieldShifts[3] = {11, 5, 0};
static const uint32_t kFieldMasks[3] = {31, 63, 31};
#define HELD_WORD (GUARD << 8 | GUARD)

static uint32_t field_of(uint32_t word, uint32_t k) {
  return word >> kFieldShifts[k] & kFieldMasks[k];
}

/* Undistorts a field as a frame of 16 bits, without gaps, into expected[0]. */
static void remap_field(const rg_image* words, const rg_target* like,
                        uint32_t k) {
  rg_image image = *words;
  rg_target target = *like;
  uint16_t width, height;
  rg_remap_size(&camera, &width, &height);
  const uint32_t num_samples = (uint32_t)image.width * image.height;
  const exact_memory memory = new_memory(2 * num_samples);
  for (uint32_t i = 0; i < num_samples; ++i)
    rg_store_u16(
        memory.bytes + 2 * i,
        (uint16_t)field_of(rg_load_u16(words->planes[0].data + 2 * i), k));
  image.format = RG_FORMAT_GREY16;
  image.planes[0].data = memory.bytes;
  target.planes[0].data = expected[0];
  target.planes[0].stride = 2u * width;
  target.border_values[0] = like->border_values[k];
  for (uint32_t i = 0; i < (uint32_t)width * height; ++i)
    rg_store_u16(expected[0] + 2 * i, (uint16_t)field_of(HELD_WORD, k));
  assert_int_equal(rg_remap(&camera, &image, &target), RG_OK);
  free_memory(&memory);
}

static void check_fields(const rg_image* image, const rg_target* target) {
  uint16_t width, height;
  rg_remap_size(&camera, &width, &height);
  for (uint32_t k = 0; k < 3; ++k) {
    remap_field(image, target, k);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const uint8_t* const row =
            target->planes[0].data + y * target->planes[0].stride;
        if (field_of(rg_load_u16(row + 2 * x), k) !=
            rg_load_u16(expected[0] + 2 * (y * width + x)))
          fail_msg("field %u at %u, %u", (unsigned)k, (unsigned)x, (unsigned)y);
      }
  }
}

static void check_rgb565(void) {
  rg_image image;
  rg_target target;
  uint16_t width, height;
  rg_remap_size(&camera, &width, &height);
  memset(&image, 0, sizeof(image));
  memset(&target, 0, sizeof(target));
  image.format = RG_FORMAT_RGB565;
  image.width = camera.frame_width;
  image.height = camera.frame_height;
  image.planes[0].stride = 2u * image.width;
  const uint32_t size = image.planes[0].stride * image.height;
  const exact_memory memory = new_memory(size);
  image.planes[0].data = memory.bytes;
  for (uint32_t i = 0; i < size; ++i)
    memory.bytes[i] = (uint8_t)(below(4) == 0 ? 255 : below(256));
  target.num_rows = height;
  target.border = (rg_border)below(3);
  target.sampling = (rg_sampling)(below(4) == 0);
  for (uint32_t k = 0; k < 3; ++k)
    target.border_values[k] = (uint16_t)below(kFieldMasks[k] + 1);
  target.planes[0].stride = 2u * width + 2 * below(5);
  target.planes[0].data = output[0] + MARGIN;
  for (uint32_t name = 0; name < NUM_NAMES; ++name) {
    target.kernels = rg_find_kernels(kNames[name]);
    if (kNames[name] && !target.kernels) continue;
    memset(output[0], GUARD, sizeof(output[0]));
    assert_int_equal(rg_remap(&camera, &image, &target), RG_OK);
    check_fields(&image, &target);
    for (uint32_t i = 0; i < MARGIN; ++i) assert_int_equal(output[0][i], GUARD);
  }
  free_memory(&memory);
}

static void fields_of_rgb565_are_frames_of_16_bits(void** unused) {
  (void)unused;
  uint32_t num_checked = 0;
  for (uint32_t k = 0; k < NUM_CASES / 3; ++k) {
    state = 987 + 7919 * k;
    if (!make_table(k % NUM_STYLES, 1)) continue;
    check_rgb565();
    ++num_checked;
  }
  assert_true(num_checked > NUM_CASES / 6);
}

/* ---- Runs about at the limits of the kernels' windows -------------------- */

#if defined(__unix__)
#if defined(__x86_64__)
#define NUM_RUNS 200000u
#else /* emulated, as a rule */
#define NUM_RUNS 40000u
#endif
#define RUN_WIDTH 1024u
#define RUN_HEIGHT 512u
#else
#define NUM_RUNS 4000u
#define RUN_WIDTH 320u
#define RUN_HEIGHT 200u
#endif

#define RUN_STRIDE (4 * RUN_WIDTH + 4)

static uint8_t source[RUN_STRIDE * RUN_HEIGHT];

/* Random samples, of the upper bits: the lower ones come again after 2^16. */
static void fill_source(void) {
  for (uint32_t i = 0; i < sizeof(source); ++i)
    source[i] = (uint8_t)(below(1u << 24) >> 16);
}

/* By name; in place of the fastest ones, those that are built in. */
static const rg_kernels* find_kernels(uint32_t name) {
#if RG_ALL_BUILT_IN
  static const rg_kernels kBuiltIn = {
      "built in",
      {RG_BUILT_IN(1), RG_BUILT_IN(2), RG_BUILT_IN(3), RG_BUILT_IN(4)},
      {0, 0, 0, 0},
      RG_HAS_VECTORS};
  if (!kNames[name]) return &kBuiltIn;
#endif
  return rg_find_kernels(kNames[name]);
}

/* A step of which some fit into whole pixels, but for a little. */
static int32_t limit_step(void) {
  const int32_t pixels = (2 << below(4)) - 1;
  const int32_t room = 4096 * (int32_t)(below(2) == 0 ? 1 : below(16));
  if (below(2) == 0) return room / pixels;
  return (room - 16 * (int32_t)below(2)) / pixels + between(-3, 3);
}

/* A position, at the edge of a pixel as a rule. */
static int32_t edge_position(int32_t pixel) {
  const int32_t fraction =
      below(4) == 0 ? between(0, 4095) : between(-20, 3) & 4095;
  return (pixel << 12) + fraction;
}

/* Lies in the source with its neighbours, and rows to spare. */
static int is_inside(const rg_span* span) {
  for (uint32_t k = 0; k < 4; ++k)
    for (int c = 0; c < 2; ++c) {
      const int32_t size = c == 0 ? (int32_t)RUN_WIDTH : (int32_t)RUN_HEIGHT;
      const int32_t q12 = span->block.corners[k].q12[c];
      if (q12 < 20 << 12 || q12 > (size - 20) << 12) return 0;
    }
  return 1;
}

static int make_run(rg_span* span) {
  const uint32_t log2 = 3 + below(3), size = 1u << log2;
  const int is_rising = below(2) == 0;
  rg_position* const corners = span->block.corners;
  int32_t step[2] = {limit_step(), limit_step()};
  if (is_rising) step[1] = -step[1];
  for (int c = 0; c < 2; ++c) {
    const int32_t first = c == 0      ? 70
                          : is_rising ? (int32_t)RUN_HEIGHT - 70
                                      : 70;
    corners[0].q12[c] = edge_position(first + between(0, 8));
    /* Rows may all begin at about the same position, or anywhere. */
    corners[2].q12[c] =
        corners[0].q12[c] + (below(2) == 0 ? between(-8, 8)
                             : c == 0      ? between(0, 5000)
                             : is_rising   ? -4096 * between(0, 9)
                                           : 4096 * between(0, 9));
    for (int k = 0; k < 2; ++k) {
      const int32_t extent = step[c] * (int32_t)size;
      /* Half a step more or less, so that rounding decides, or anything. */
      const int32_t more = below(4) != 0
                               ? (int32_t)size / 2 - between(0, 2)
                               : between(-(int32_t)size, (int32_t)size) / 2;
      corners[2 * k + 1].q12[c] =
          corners[2 * k].q12[c] + extent + (below(8) == 0 ? -more : more);
    }
  }
  span->block.width_log2 = span->block.height_log2 = (uint8_t)log2;
  span->first_source_row = (uint16_t)below(4);
  span->first_row = (uint8_t)below(size);
  span->num_rows = (uint8_t)(1 + below(size - span->first_row));
  span->first_pixel = (uint8_t)below(size);
  span->num_pixels = (uint8_t)(1 + below(size - span->first_pixel));
  if (below(2) == 0) {
    span->first_row = span->first_pixel = 0;
    span->num_rows = span->num_pixels = (uint8_t)size;
  }
  span->out_pixel = (uint16_t)(below(3) + span->first_pixel);
  return is_inside(span);
}

static void runs_at_the_limits_are_as_the_portable_ones(void** unused) {
  static rg_blend* const kPortable[4] = {rg_blend_1, rg_blend_2, rg_blend_3,
                                         rg_blend_4};
  const uint32_t out_stride = 4 * 40;
  const rg_kernels* kernels[NUM_NAMES];
  uint32_t num_checked = 0;
  (void)unused;
  for (uint32_t n = 0; n < NUM_NAMES; ++n) kernels[n] = find_kernels(n);
  state = 99;
  fill_source();
  for (uint32_t k = 0; k < NUM_RUNS; ++k) {
    rg_span span;
    if (!make_run(&span)) continue;
    const uint32_t channels = 1 + below(4);
    span.data = source + (size_t)span.first_source_row * RUN_STRIDE;
    span.stride = RUN_STRIDE;
    span.out_stride = out_stride;
    memset(expected[0], GUARD, 33 * out_stride);
    span.out = expected[0];
    kPortable[channels - 1](&span);
    for (uint32_t n = 0; n < NUM_NAMES; ++n) {
      if (!kernels[n]) continue;
      memset(output[0], GUARD, 33 * out_stride);
      span.out = output[0];
      kernels[n]->blend[channels - 1](&span);
      if (memcmp(output[0], expected[0], 33 * out_stride) != 0)
        fail_msg("kernels %s, %u channels, run %u", kernels[n]->name,
                 (unsigned)channels, (unsigned)k);
    }
    ++num_checked;
  }
  printf("%u of %u runs\n", (unsigned)num_checked, (unsigned)NUM_RUNS);
  assert_true(num_checked > NUM_RUNS / 20);
}

/* Components of one byte in each group of step; two of each 4. */
static void spread_runs_are_as_those_of_any_lattice(void** unused) {
  const uint32_t out_stride = 4 * 40;
  uint32_t num_checked = 0;
  (void)unused;
  state = 77;
  fill_source();
  for (uint32_t k = 0; RG_SELECT_KERNELS && k < NUM_RUNS / 4; ++k) {
    rg_span span;
    if (!make_run(&span)) continue;
    const uint32_t step = 2u << below(2), first = below(2);
    rg_component component = {
        RG_SAMPLE_8, 0, 0, (uint8_t)step, 1, {0, 0}, {0, 0}, 0, 1, 0};
    span.data = source + (size_t)span.first_source_row * RUN_STRIDE;
    span.stride = RUN_STRIDE;
    span.out_stride = out_stride;
    memset(expected[0], GUARD, 33 * out_stride);
    span.out = expected[0];
    for (uint32_t sample = first; sample < step; sample += 2) {
      component.first_sample = (uint8_t)sample;
      rg_blend_component(&span, &component);
    }
    span.out = output[0];
    for (uint32_t n = 0; n < NUM_NAMES; ++n) {
      const rg_kernels* const kernels = find_kernels(n);
      if (!kernels) continue;
      memset(output[0], GUARD, 33 * out_stride);
      for (uint32_t sample = first; sample < step; sample += 2) {
        component.first_sample = (uint8_t)sample;
        rg_blend_strided(kernels, &span, &component);
      }
      if (memcmp(output[0], expected[0], 33 * out_stride) != 0)
        fail_msg("kernels %s, step %u, run %u", kernels->name, (unsigned)step,
                 (unsigned)k);
    }
    ++num_checked;
  }
  assert_true(!RG_SELECT_KERNELS || num_checked > NUM_RUNS / 80);
}

/* ---- Whole blocks, whose rows the portable kernels may take together ----- */

/* How far 8 pixels and 8 rows lead, in q12, is about as far as 16 bits count.
 * Lies in so many rows of the source, 32 or 200. */
static void make_block(rg_span* span, uint32_t num_rows) {
  rg_position* const corners = span->block.corners;
  const uint32_t log2 = num_rows == 32 ? 3 : 3 + below(3);
  const int32_t tiles = 1 << (log2 - 3);
  for (int c = 0; c < 2; ++c) {
    const int is_low = c == 1 && num_rows == 32;
    const int32_t reach = is_low || below(2) == 0 ? 30000 : 64000;
    const int32_t across = between(-reach, reach);
    const int32_t rest = reach - (across < 0 ? -across : across);
    const int32_t down = between(-rest, rest);
    const int32_t turn =
        below(2) == 0 ? between(-64, 64) : between(-20000, 20000);
    corners[0].q12[c] = edge_position(is_low ? 15 : 100);
    corners[1].q12[c] = corners[0].q12[c] + across * tiles;
    corners[2].q12[c] = corners[0].q12[c] + down * tiles;
    corners[3].q12[c] = corners[2].q12[c] + across * tiles + turn;
  }
  span->block.width_log2 = span->block.height_log2 = (uint8_t)log2;
  span->num_pixels = span->num_rows = (uint8_t)(1u << log2);
}

static void do_portably(const rg_span* span, uint32_t channels, int is_copy) {
  static rg_blend* const kPortable[4] = {rg_blend_1, rg_blend_2, rg_blend_3,
                                         rg_blend_4};
  const rg_component component = {
      RG_SAMPLE_8, 0, 0, (uint8_t)channels, (uint8_t)channels, {0, 0}, {0, 0},
      0,           1, 0};
  if (is_copy)
    rg_copy_component(span, &component);
  else
    kPortable[channels - 1](span);
}

static void blocks_are_as_their_rows(void** unused) {
  const uint32_t out_stride = 4 * 40;
  (void)unused;
  state = 7;
  fill_source();
  for (uint32_t k = 0; k < NUM_RUNS / 4; ++k) {
    const uint32_t channels = 1 + below(4);
    const uint32_t num_rows = below(8) == 0 ? 32 : 200;
    const int is_copy = below(4) == 0;
    rg_span span;
    memset(&span, 0, sizeof(span));
    make_block(&span, num_rows);
    span.data = source;
    span.stride = 1024 + below((uint32_t)sizeof(source) / num_rows - 1024);
    span.out_stride = out_stride;
    span.out_pixel = (uint16_t)below(3);
    memset(expected[0], GUARD, 33 * out_stride);
    memset(output[0], GUARD, 33 * out_stride);
    span.out = output[0];
    do_portably(&span, channels, is_copy);
    for (uint32_t r = 0; r < span.num_pixels; ++r) {
      span.first_row = (uint8_t)r;
      span.num_rows = 1;
      span.out = expected[0] + r * out_stride;
      do_portably(&span, channels, is_copy);
    }
    if (memcmp(output[0], expected[0], 33 * out_stride) != 0)
      fail_msg("%u channels, block %u", (unsigned)channels, (unsigned)k);
  }
}

static void kernels_are_found_by_name(void** unused) {
  (void)unused;
  for (uint32_t name = 0; name + 1 < NUM_NAMES; ++name)
    printf("kernels: %s%s\n", kNames[name],
           rg_find_kernels(kNames[name]) ? "" : ", which this processor lacks");
  assert_null(rg_find_kernels("slide rule"));
  assert_null(rg_find_kernels(""));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_kernel_gives_the_specified_bits),
      cmocka_unit_test(runs_at_the_limits_are_as_the_portable_ones),
      cmocka_unit_test(frames_of_yuyv_are_the_same_by_every_kernel),
      cmocka_unit_test(fields_of_rgb565_are_frames_of_16_bits),
      cmocka_unit_test(spread_runs_are_as_those_of_any_lattice),
      cmocka_unit_test(blocks_are_as_their_rows),
      cmocka_unit_test(kernels_are_found_by_name),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
