/* Every function of raygrid.h with arguments at their limits and beyond: a
 * status or a result, nothing outside is touched, and functions that do the
 * same thing agree. */
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "fuzz_target.h"
#include "raygrid.h"
#include "test_frame.h"

#define MAX_POINTS 20u

static uint32_t state;

/* Near a power of two or its complement, or of any size. */
static uint32_t draw(void) {
  const uint32_t random = next_random(&state);
  const uint32_t shift = next_random(&state) >> 27;
  const uint32_t near = (next_random(&state) >> 29) - 3u;
  if (random >> 31 == 0) return next_random(&state) >> shift;
  const uint32_t power = UINT32_C(1) << shift;
  return (random >> 30 == 2 ? power : 0u - power) + near;
}

static uint32_t below(uint32_t limit) {
  return (next_random(&state) >> 8) % limit;
}

/* ---- Points -------------------------------------------------------------- */

static int is_same(const void* a, const void* b, size_t size) {
  return memcmp(a, b, size) == 0;
}

/* Mostly inside, on one axis or both. */
static rg_pixel draw_pixel(const rg_camera* camera) {
  uint16_t width, height;
  rg_calibrated_size(camera, &width, &height);
  const uint32_t kind = below(4);
  const rg_pixel pixel = {
      (int32_t)(kind < 2 ? draw() : below(width + 1u) << 16 | below(65536)),
      (int32_t)(kind % 2 == 0 ? draw()
                              : below(height + 1u) << 16 | below(65536))};
  return pixel;
}

static void try_pixels(const rg_camera* camera) {
  rg_pixel pixels[MAX_POINTS] = {{0, 0}}, undistorted[MAX_POINTS];
  rg_ray rays[MAX_POINTS];
  rg_line lines[MAX_POINTS];
  const uint32_t num = below(MAX_POINTS + 1);
  for (uint32_t k = 0; k < num; ++k) pixels[k] = draw_pixel(camera);
  uint32_t inside = rg_unproject_batch(camera, pixels, rays, num);
  uint32_t on_lines = rg_unproject_lines(camera, pixels, lines, num);
  uint32_t seen = rg_undistort_points(camera, pixels, undistorted, num);
  for (uint32_t k = 0; k < num; ++k) {
    rg_ray ray = {0, 0, 0};
    rg_line line = {{0, 0, 0}, {0, 0, 0}};
    rg_pixel there = {RG_NO_PIXEL, RG_NO_PIXEL};
    inside -= rg_unproject(camera, pixels[k], &ray) == RG_OK;
    on_lines -= rg_unproject_line(camera, pixels[k], &line) == RG_OK;
    seen -= rg_undistort_point(camera, pixels[k], &there) == RG_OK;
    require(is_same(&ray, &rays[k], sizeof(ray)) &&
                is_same(&line, &lines[k], sizeof(line)) &&
                is_same(&there, &undistorted[k], sizeof(there)),
            "several points are as each alone");
    uint16_t sigma_q12;
    if (rg_is_valid(camera, pixels[k]))
      require(rg_unproject_line(camera, pixels[k], &line) == RG_OK,
              "what is valid lies in the area");
    rg_uncertainty(camera, pixels[k], &sigma_q12);
  }
  require(inside == 0 && on_lines == 0 && seen == 0, "counts are of results");
}

static void try_row(const rg_camera* camera) {
  rg_ray rays[MAX_POINTS];
  const uint32_t num = below(MAX_POINTS + 1);
  const rg_pixel first = draw_pixel(camera);
  rg_unproject_row(camera, first, rays, num);
  for (uint32_t k = 0; k < num; ++k) {
    const int64_t x_q16 = first.x_q16 + INT64_C(65536) * k;
    const rg_pixel pixel = {(int32_t)x_q16, first.y_q16};
    rg_ray ray = {0, 0, 0};
    if (x_q16 <= INT32_MAX) rg_unproject(camera, pixel, &ray);
    require(is_same(&ray, &rays[k], sizeof(ray)), "a row is its pixels");
  }
}

static void try_directions(const rg_camera* camera) {
  rg_ray rays[MAX_POINTS] = {{0, 0, 0}};
  rg_pixel pixels[MAX_POINTS];
  const uint32_t num = below(MAX_POINTS + 1);
  for (uint32_t k = 0; k < num; ++k) {
    rays[k].x_q30 = (int32_t)draw();
    rays[k].y_q30 = (int32_t)draw();
    rays[k].z_q30 = (int32_t)draw();
  }
  uint32_t seen = rg_project_batch(camera, rays, pixels, num);
  for (uint32_t k = 0; k < num; ++k) {
    rg_pixel pixel = {RG_NO_PIXEL, RG_NO_PIXEL}, found = pixel;
    seen -= rg_project(camera, &rays[k], &pixel) == RG_OK;
    require(is_same(&pixel, &pixels[k], sizeof(pixel)),
            "several directions are as each alone");
    const int32_t point[3] = {rays[k].x_q30, rays[k].y_q30, rays[k].z_q30};
    const uint32_t bits = draw();
    const rg_status status = rg_project_point(camera, point, bits, &found);
    require((status == RG_ERR_ARGUMENT) == (bits > RG_POINT_MAX_BITS),
            "fraction bits are those that there are");
    require(status == RG_OK || found.x_q16 == RG_NO_PIXEL,
            "a failed call leaves its outputs alone");
  }
  require(seen == 0, "counts are of results");
}

/* ---- The camera ---------------------------------------------------------- */

static rg_mode draw_mode(const rg_camera* camera) {
  rg_mode mode;
  if (below(2) == 0 && rg_remap_mode(camera, &mode) == RG_OK && below(4) != 0)
    return mode;
  const rg_mode drawn = {(uint16_t)draw(), (uint16_t)draw(), (int32_t)draw(),
                         (int32_t)draw(),  draw(),           draw(),
                         (uint8_t)draw(),  (uint8_t)draw()};
  return drawn;
}

static void try_mode(const rg_camera* camera) {
  const rg_mode mode = draw_mode(camera);
  const rg_pixel pixel = draw_pixel(camera);
  rg_pixel there, back;
  if (rg_mode_to_calibrated(&mode, pixel, &there) == RG_OK)
    rg_mode_from_calibrated(&mode, there, &back);
  rg_mode_from_calibrated(&mode, pixel, &back);
  char serial[40] = {0};
  memset(serial, (int)draw(), below(sizeof(serial)));
  uint32_t table = 0;
  const rg_match_result result =
      rg_match(camera, &mode, mode.width, mode.height, serial, &table);
  require(result == RG_MATCH_EXACT || result == RG_MATCH_MODE ||
              table == RG_NO_TABLE,
          "a table is of frames that match");
  rg_match(camera, NULL, (uint16_t)draw(), (uint16_t)draw(), NULL, NULL);
}

static void try_choices(rg_camera* camera) {
  static const char* const kNames[] = {NULL, "portable", "avx2",
                                       "",   "avx",      "avx22"};
  const char* const name = kNames[below(6)];
  rg_select_ray_kernels(camera, name);
  (void)rg_find_kernels(name);
  const rg_camera before = *camera;
  const uint32_t index = below(4) == 0 ? draw() : below(5);
  const rg_status status = rg_select_remap(camera, index);
  require(status == RG_OK || is_same(&before, camera, sizeof(before)),
          "a failed call leaves its outputs alone");
  if (below(2) == 0) rg_set_operating_point(camera, (int32_t)draw());
  require(strlen(rg_status_text((rg_status)draw())) > 1,
          "every status has a text");
}

static void try_sizes(const rg_camera* camera) {
  uint16_t width, height;
  rg_view view;
  int32_t row_time_ns_q10;
  rg_frame_size(camera, &width, &height);
  rg_remap_size(camera, &width, &height);
  rg_remap_view(camera, &view);
  rg_line_delay(camera, &row_time_ns_q10, NULL);
}

/* No number of bytes is beyond those that there are. */
static void try_open(const uint8_t* bytes, uint32_t num_bytes) {
  rg_camera camera;
  const uint32_t drawn = draw();
  rg_camera_open(&camera, bytes, drawn < num_bytes ? drawn : num_bytes);
  if (num_bytes > 4)
    require(rg_camera_open(&camera, bytes + 1 + below(3), num_bytes - 4) ==
                RG_ERR_MISALIGNED,
            "an address is a multiple of 4");
  require(rg_camera_open(NULL, bytes, num_bytes) == RG_ERR_ARGUMENT &&
              rg_camera_open(&camera, NULL, draw()) == RG_ERR_ARGUMENT,
          "null pointers are refused");
}

/* ---- Slots --------------------------------------------------------------- */

static void try_slots(const uint8_t* blob, uint32_t num_bytes) {
  const uint32_t slot_size = num_bytes + 64 + below(65);
  uint8_t* const slots = malloc(2 * (size_t)slot_size + 8);
  if (!slots || num_bytes == 0) {
    free(slots);
    return;
  }
  uint8_t* const second = slots + (slot_size + 3u) / 4u * 4u;
  memset(slots, 0xff, 2 * (size_t)slot_size + 8);
  const uint32_t sequence = draw();
  rg_make_slot_header(blob, num_bytes, sequence, (uint32_t*)(void*)slots);
  memcpy(slots + 64, blob, num_bytes);
  if (below(2) == 0) { /* any header in front of the other blob */
    for (uint32_t k = 0; k < 16; ++k) ((uint32_t*)(void*)second)[k] = draw();
    memcpy(second, slots, below(3) * 8u);
  }
  rg_slot newest;
  require(rg_select_slot(slots, second, slot_size, &newest) == RG_OK &&
              newest.sequence == sequence && newest.num_bytes == num_bytes,
          "a whole slot is found");
  const uint32_t drawn = draw();
  rg_select_slot(slots, below(2) == 0 ? NULL : second,
                 drawn < slot_size ? drawn : slot_size, &newest);
  require(
      rg_select_slot(slots, slots + 2, draw(), &newest) == RG_ERR_MISALIGNED &&
          rg_select_slot(slots, slots, below(65), &newest) == RG_ERR_ARGUMENT &&
          rg_make_slot_header(NULL, draw(), 0, (uint32_t*)(void*)slots) ==
              RG_ERR_ARGUMENT &&
          rg_make_slot_header(blob, 0, 0, (uint32_t*)(void*)slots) ==
              RG_ERR_ARGUMENT,
      "what is no slot is refused");
  free(slots);
}

/* ---- Frames -------------------------------------------------------------- */

/* Planes whose rows may lie 2 GiB apart: only the pages of rows become memory.
 * NULL: more than this machine gives. */
static uint8_t* reserve(uint64_t num_bytes) {
  if (num_bytes >> 42 != 0) return NULL;
  void* const memory =
      mmap(NULL, (size_t)(num_bytes + 1), PROT_READ | PROT_WRITE,
           MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  return memory == MAP_FAILED ? NULL : memory;
}

/* The stride of rows of any format, or about that of a grey one, or the largest
 * that there may be, or any number. */
static uint32_t draw_stride(uint32_t width) {
  switch (below(8)) {
    case 0:
      return draw();
    case 1:
      return width - 1 + below(3);
    case 2:
      return INT32_MAX - 3 + below(4);
    default:
      return 4 * width;
  }
}

static int is_too_large(uint32_t stride) { return stride >> 31 != 0; }

/* A frame, or a part of one, in every format and as a grey one. */
static void try_frame(const rg_camera* camera) {
  rg_image image;
  rg_target target;
  uint16_t width = 0, height = 0, first, num;
  memset(&image, 0, sizeof(image));
  memset(&target, 0, sizeof(target));
  rg_remap_size(camera, &width, &height);
  rg_frame_size(camera, &image.width, &image.height);
  image.format = below(3) == 0 ? RG_FORMAT_GREY8 : (rg_format)(draw() % 32);
  if (below(8) == 0) image.width = (uint16_t)draw();
  if (below(8) == 0) image.height = (uint16_t)draw();
  if (below(8) == 0) image.ring_rows = (uint16_t)draw();
  image.first_row = (uint16_t)draw();
  image.num_rows = (uint16_t)draw();
  target.num_rows = height;
  if (below(4) == 0) {
    target.first_row = (uint16_t)draw();
    target.num_rows = (uint16_t)draw();
  }
  target.border = (rg_border)(draw() % 4);
  target.sampling = (rg_sampling)(below(8) == 0 ? draw() : below(2));
  for (int c = 0; c < 4; ++c) target.border_values[c] = (uint16_t)draw();
  rg_remap_source_rows(camera, image.format, target.first_row, target.num_rows,
                       &first, &num);

  /* rg_remap_grey() takes all rows, also where they are not a ring's. */
  const uint32_t rows =
      image.ring_rows > image.height ? image.ring_rows : image.height;
  uint64_t sizes[6];
  uint8_t* planes[6] = {0};
  int is_there = 1, is_one_too_large = 0;
  for (int p = 0; p < 3; ++p) {
    image.planes[p].stride = draw_stride(image.width);
    target.planes[p].stride = draw_stride(width);
    is_one_too_large |= p == 0 && (is_too_large(image.planes[p].stride) ||
                                   is_too_large(target.planes[p].stride));
    /* Too large ones are refused, so they need no memory. */
    const uint64_t strides[2] = {
        is_too_large(image.planes[p].stride) ? 0 : image.planes[p].stride,
        is_too_large(target.planes[p].stride) ? 0 : target.planes[p].stride};
    for (int k = 0; k < 2; ++k) {
      sizes[2 * p + k] =
          (k == 0 ? rows : target.num_rows) * strides[k] + 4 * 65536u;
      planes[2 * p + k] = reserve(sizes[2 * p + k]);
      is_there &= planes[2 * p + k] != NULL;
    }
    image.planes[p].data = planes[2 * p];
    target.planes[p].data = planes[2 * p + 1];
  }
  if (is_there) {
    const rg_status status = rg_remap(camera, &image, &target);
    require(status != RG_OK || !is_one_too_large,
            "rows lie less than 2^31 apart");
    const rg_grey_image frame = {image.planes[0].data, image.planes[0].stride,
                                 image.width, image.height};
    const rg_grey_target band = {target.planes[0].data, target.planes[0].stride,
                                 target.first_row, target.num_rows,
                                 (uint8_t)target.border_values[0]};
    const rg_status grey = rg_remap_grey(camera, &frame, &band);
    if (image.format == RG_FORMAT_GREY8 && image.ring_rows == 0 &&
        target.border == RG_BORDER_VALUE &&
        target.sampling == RG_SAMPLING_BILINEAR)
      require((grey == RG_OK) == (status == RG_OK),
              "grey frames are taken as those of any format");
    require(grey != RG_OK || !is_one_too_large,
            "rows lie less than 2^31 apart");
  }
  for (int k = 0; k < 6; ++k)
    if (planes[k]) munmap(planes[k], (size_t)(sizes[k] + 1));
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  uint32_t blob_size;
  uint8_t* const bytes = take_blob(data, size, &blob_size);
  if (!bytes) return 0;
  state = setting(data, 4);
  try_slots(bytes, blob_size);
  try_open(bytes, blob_size);
  rg_camera camera;
  memset(&camera, 0, sizeof(camera));
  if (rg_camera_open(&camera, bytes, blob_size) == RG_OK)
    for (int k = 0; k < 4; ++k) {
      try_choices(&camera);
      try_pixels(&camera);
      try_row(&camera);
      try_directions(&camera);
      try_mode(&camera);
      try_sizes(&camera);
      try_frame(&camera);
    }
  free(bytes);
  return 0;
}
