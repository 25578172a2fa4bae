/* Loads a wheel's library as Python does, undistorts the golden frame, and
   compares its CRC. For libraries of C and processors that no Python is at hand
   for. */
#include <dlfcn.h>
#include <stdio.h>

#include "golden_blobs.h"
#include "raygrid.h"
#include "test_frame.h"

#define SOURCE_WIDTH 160u
#define SOURCE_HEIGHT 120u
#define WIDTH 120u
#define HEIGHT 90u

static uint8_t source[SOURCE_WIDTH * SOURCE_HEIGHT], output[WIDTH * HEIGHT];

static uint32_t crc32(const uint8_t* data, size_t size) {
  uint32_t crc = 0xffffffffu;
  for (size_t i = 0; i < size; ++i) {
    crc ^= data[i];
    for (int bit = 0; bit < 8; ++bit)
      crc = crc >> 1 ^ (0xedb88320u & (0u - (crc & 1u)));
  }
  return ~crc;
}

/* A function's address, by way of an object's. */
static void find(void* library, const char* name, void* function) {
  *(void**)function = dlsym(library, name);
}

int main(int argc, char** argv) {
  void* library = argc == 2 ? dlopen(argv[1], RTLD_NOW | RTLD_LOCAL) : NULL;
  if (!library) {
    fprintf(stderr, "%s\n", argc == 2 ? dlerror() : "load_runtime LIBRARY");
    return 1;
  }
  rg_status (*open)(rg_camera*, const void*, uint32_t);
  rg_status (*select)(rg_camera*, uint32_t);
  rg_status (*remap)(const rg_camera*, const rg_grey_image*,
                     const rg_grey_target*);
  find(library, "rg_camera_open", &open);
  find(library, "rg_select_remap", &select);
  find(library, "rg_remap_grey", &remap);
  rg_camera lens;
  make_test_frame(source, SOURCE_WIDTH, SOURCE_WIDTH, SOURCE_HEIGHT);
  const rg_grey_image frame = {source, SOURCE_WIDTH, SOURCE_WIDTH,
                               SOURCE_HEIGHT};
  const rg_grey_target band = {output, WIDTH, 0, HEIGHT, GOLDEN_BORDER};
  if (!open || !select || !remap ||
      open(&lens, kLensBlob, sizeof(kLensBlob)) != RG_OK ||
      select(&lens, 0) != RG_OK || remap(&lens, &frame, &band) != RG_OK)
    return 2;
  const uint32_t crc = crc32(output, sizeof(output));
  printf("remap CRC %08lx\n", (unsigned long)crc);
  return crc == GOLDEN_LENS_REMAP_CRC ? 0 : 3;
}
