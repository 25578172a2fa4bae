/* Undistorts an NV12 frame.
 *   undistort_frame BLOB IN.nv12 OUT.nv12 */
#include <stdio.h>
#include <stdlib.h>

#include "raygrid.h"

/* Words, since blobs must be aligned to 4 bytes. */
static uint32_t blob[1 << 18];

/* Returns the number of bytes read, 0 on failure. */
static size_t read_file(const char* path, void* bytes, size_t size) {
  FILE* file = fopen(path, "rb");
  if (!file) return 0;
  const size_t num_read = fread(bytes, 1, size, file);
  fclose(file);
  return num_read;
}

static int write_file(const char* path, const uint8_t* bytes, size_t size) {
  FILE* file = fopen(path, "wb");
  if (!file) return 0;
  const size_t num_written = fwrite(bytes, 1, size, file);
  return fclose(file) == 0 && num_written == size;
}

static int fail(const char* where, const char* what) {
  fprintf(stderr, "undistort_frame: %s: %s\n", where, what);
  return 1;
}

static int undistort(const rg_camera* camera, const char* in, const char* out) {
  uint16_t width, height, frame_width, frame_height;
  rg_frame_size(camera, &frame_width, &frame_height);
  rg_status status = rg_remap_size(camera, &width, &height);
  if (status != RG_OK) return fail("blob", rg_status_text(status));
  const size_t num_source = (size_t)frame_width * frame_height;
  const size_t num_target = (size_t)width * height;
  const size_t frame_size = num_source / 2 * 3,
               target_size = num_target / 2 * 3;
  uint8_t* const source = malloc(frame_size);
  uint8_t* const result = malloc(target_size);
  if (!source || !result) return fail(in, "not enough memory");
  if (read_file(in, source, frame_size) != frame_size)
    return fail(in, "is not an NV12 frame of the blob's image size");

  const rg_image image = {
      .format = RG_FORMAT_NV12,
      .width = frame_width,
      .height = frame_height,
      .planes = {{source, frame_width}, {source + num_source, frame_width}}};
  const rg_target target = {
      .planes = {{result, width}, {result + num_target, width}},
      .num_rows = height,
      .border = RG_BORDER_VALUE,
      .border_values = {16, 128, 128}}; /* black */
  status = rg_remap(camera, &image, &target);
  if (status != RG_OK) return fail(in, rg_status_text(status));
  if (!write_file(out, result, target_size))
    return fail(out, "cannot be written");
  printf("%u x %u\n", width, height);
  free(source);
  free(result);
  return 0;
}

int main(int argc, char** argv) {
  if (argc != 4) return fail("usage", "undistort_frame BLOB IN.nv12 OUT.nv12");
  rg_camera camera;
  const size_t size = read_file(argv[1], blob, sizeof(blob));
  rg_status status = rg_camera_open(&camera, blob, (uint32_t)size);
  if (status == RG_OK) status = rg_select_remap(&camera, 0);
  if (status != RG_OK) return fail(argv[1], rg_status_text(status));
  return undistort(&camera, argv[2], argv[3]);
}
