/* raygrid-undistort: the runtime as a program. A blob and a raw grey frame in,
 * the undistorted frame out. Standard C files, so that it also runs on bare
 * metal with semihosting. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "crc32.h"
#include "raygrid.h"

enum { DONE = 0, USAGE = 1, INPUT = 2, OUTPUT = 7, BLOB = 8 };

static const char kHelp[] =
    "Undistorts a grey frame with the table of a raygrid blob.\n"
    "\n"
    "Usage: raygrid-undistort BLOB IN OUT\n"
    "  BLOB  packed with --remap\n"
    "  IN    raw frame, 8 bits a pixel, of the size the blob is for; or PGM\n"
    "  OUT   raw frame; PGM if the name ends in .pgm\n"
    "Prints the output's size and CRC-32.\n"
    "\n"
    "Example:\n"
    "  raygrid-undistort camera.raygrid frame.raw flat.pgm\n";

static int fail(int code, const char* where, const char* what) {
  fprintf(stderr, "raygrid-undistort: %s: %s\n", where, what);
  return code;
}

/* A whole file; malloc aligns it more than the blob needs. NULL on failure. */
static uint8_t* read_file(const char* path, uint32_t* size) {
  FILE* file = fopen(path, "rb");
  if (!file) return NULL;
  uint8_t* bytes = NULL;
  long length = -1;
  if (fseek(file, 0, SEEK_END) == 0) length = ftell(file);
  if (length >= 0 && length < 0x7fffffff && fseek(file, 0, SEEK_SET) == 0)
    bytes = (uint8_t*)malloc((size_t)length + 1);
  if (bytes && fread(bytes, 1, (size_t)length, file) != (size_t)length) {
    free(bytes);
    bytes = NULL;
  }
  fclose(file);
  *size = (uint32_t)length;
  return bytes;
}

/* The pixels in a frame file, NULL if it is of another size. */
static const uint8_t* find_pixels(const uint8_t* bytes, uint32_t size,
                                  uint32_t width, uint32_t height) {
  const uint32_t num_pixels = width * height;
  if (size == num_pixels) return bytes;
  char header[40];
  const int length = snprintf(header, sizeof(header), "P5\n%lu %lu\n255\n",
                              (unsigned long)width, (unsigned long)height);
  if (size == num_pixels + (uint32_t)length &&
      memcmp(bytes, header, (size_t)length) == 0)
    return bytes + length;
  return NULL;
}

static int has_suffix(const char* text, const char* suffix) {
  const size_t n = strlen(text), m = strlen(suffix);
  return n >= m && strcmp(text + n - m, suffix) == 0;
}

static int write_pixels(const char* path, int as_pgm, const uint8_t* pixels,
                        uint32_t width, uint32_t height) {
  FILE* file = fopen(path, "wb");
  if (!file) return 0;
  int good = 1;
  if (as_pgm)
    good = fprintf(file, "P5\n%lu %lu\n255\n", (unsigned long)width,
                   (unsigned long)height) > 0;
  const size_t num_pixels = (size_t)width * height;
  good = good && fwrite(pixels, 1, num_pixels, file) == num_pixels;
  return fclose(file) == 0 && good;
}

/* Beside the target first, so that no half frame is ever seen under its name;
 * semihosting cannot rename. */
static int write_frame(const char* path, const uint8_t* pixels, uint32_t width,
                       uint32_t height) {
  char written[1024];
#if defined(__unix__)
  const char* const suffix = ".part";
#else
  const char* const suffix = "";
#endif
  if (snprintf(written, sizeof(written), "%s%s", path, suffix) >=
      (int)sizeof(written))
    return 0;
  int good =
      write_pixels(written, has_suffix(path, ".pgm"), pixels, width, height);
#if defined(__unix__)
  good = good && rename(written, path) == 0;
#endif
  if (!good) remove(written);
  return good;
}

static int undistort(const rg_camera* camera, const uint8_t* pixels,
                     const char* out_path) {
  uint16_t width, height;
  rg_status status = rg_remap_size(camera, &width, &height);
  if (status != RG_OK) return fail(BLOB, "blob", rg_status_text(status));
  uint8_t* out = (uint8_t*)malloc((size_t)width * height);
  if (!out) return fail(INPUT, "output", "not enough memory");
  const rg_frame frame = {pixels, camera->width, camera->width, camera->height};
  const rg_band band = {out, width, 0, height, 0};
  int code = DONE;
  status = rg_remap_grey(camera, &frame, &band);
  if (status != RG_OK)
    code = fail(BLOB, "blob", rg_status_text(status));
  else if (!write_frame(out_path, out, width, height))
    code = fail(OUTPUT, out_path, "cannot be written; choose another place");
  else
    printf("%lu x %lu, CRC %08lx\n", (unsigned long)width,
           (unsigned long)height,
           (unsigned long)rg_crc32(0, out, (uint32_t)width * height));
  free(out);
  return code;
}

int main(int argc, char** argv) {
  if (argc == 2 && strcmp(argv[1], "--help") == 0) {
    fputs(kHelp, stdout);
    return DONE;
  }
  if (argc != 4)
    return fail(USAGE, "usage", "raygrid-undistort BLOB IN OUT; see --help");

  uint32_t blob_size, frame_size;
  uint8_t* blob = read_file(argv[1], &blob_size);
  if (!blob) return fail(INPUT, argv[1], "cannot be read");
  rg_camera camera;
  rg_status status = rg_camera_open(&camera, blob, blob_size);
  if (status == RG_OK) status = rg_select_remap(&camera, 0);
  if (status != RG_OK) {
    free(blob);
    return fail(BLOB, argv[1], rg_status_text(status));
  }
  uint8_t* frame = read_file(argv[2], &frame_size);
  int code = INPUT;
  if (!frame) {
    fail(INPUT, argv[2], "cannot be read");
  } else {
    const uint8_t* pixels =
        find_pixels(frame, frame_size, camera.width, camera.height);
    code = pixels ? undistort(&camera, pixels, argv[3])
                  : fail(INPUT, argv[2],
                         "is not a grey frame of the size that the blob is "
                         "for");
  }
  free(frame);
  free(blob);
  return code;
}
