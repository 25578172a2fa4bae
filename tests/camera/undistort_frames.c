/* The reference for raygrid-camera: YUYV frames, one after the other, through
 * rg_remap() alone, by the portable kernels.
 *
 *   undistort_frames BLOB IN OUT */
#include <stdio.h>
#include <stdlib.h>

#include "raygrid.h"

static void fail(const char* what) {
  fprintf(stderr, "undistort_frames: %s\n", what);
  exit(1);
}

static uint8_t* read_file(const char* path, size_t* size) {
  FILE* const file = fopen(path, "rb");
  if (!file || fseek(file, 0, SEEK_END) != 0) fail(path);
  *size = (size_t)ftell(file);
  rewind(file);
  uint8_t* const bytes = (uint8_t*)malloc(*size + 1);
  if (!bytes || fread(bytes, 1, *size, file) != *size) fail(path);
  fclose(file);
  return bytes;
}

int main(int argc, char** argv) {
  if (argc != 4) fail("usage: BLOB IN OUT");
  size_t blob_size, size;
  uint8_t* const blob = read_file(argv[1], &blob_size);
  uint8_t* const frames = read_file(argv[2], &size);
  rg_camera camera;
  uint16_t width = 0, height = 0;
  if (rg_camera_open(&camera, blob, (uint32_t)blob_size) != RG_OK ||
      rg_select_remap(&camera, 0) != RG_OK ||
      rg_remap_size(&camera, &width, &height) != RG_OK)
    fail(argv[1]);
  uint16_t frame_width, frame_height;
  rg_frame_size(&camera, &frame_width, &frame_height);
  const size_t frame_size = (size_t)frame_width * frame_height * 2;
  const size_t out_size = (size_t)width * height * 2;
  uint8_t* const out = (uint8_t*)malloc(out_size);
  FILE* const file = fopen(argv[3], "wb");
  if (!out || !file) fail(argv[3]);
  for (size_t start = 0; start + frame_size <= size; start += frame_size) {
    const rg_image image = {.format = RG_FORMAT_YUYV,
                            .width = frame_width,
                            .height = frame_height,
                            .planes = {{frames + start, frame_width * 2u}}};
    const rg_target target = {.planes = {{out, width * 2u}},
                              .num_rows = height,
                              .border_values = {16, 128, 128},
                              .kernels = rg_find_kernels("portable")};
    if (rg_remap(&camera, &image, &target) != RG_OK ||
        fwrite(out, 1, out_size, file) != out_size)
      fail("frame");
  }
  if (fclose(file) != 0) fail(argv[3]);
  free(out);
  free(frames);
  free(blob);
  return 0;
}
