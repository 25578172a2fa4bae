/* raygrid-undistort: the runtime as a program. Reads a blob and a raw grey
 * frame, and writes the undistorted frame. Uses only standard C file functions,
 * so that it also runs on bare metal with semihosting. */
#if defined(__unix__)
#define _XOPEN_SOURCE 700
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>
#endif
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "crc32.h"
#include "raygrid.h"

enum { DONE = 0, USAGE = 1, INPUT = 2, OUTPUT = 7, BLOB = 8 };

static const char kHelp[] =
    "Undistort a grey frame with a remap table of a raygrid blob.\n"
    "\n"
    "Usage: raygrid-undistort BLOB IN OUT\n"
    "  BLOB  packed with --remap\n"
    "  IN    raw frame of the blob's image size, 8 or 16 bits per pixel\n"
    "        (16: little-endian); or 8-bit PGM\n"
    "  OUT   raw frame with the same bit depth; PGM if the name ends in .pgm;\n"
    "        must differ from BLOB and IN\n"
    "Prints the size and CRC-32 of the output.\n"
    "Exit codes: 0 done, 1 usage, 2 blob or frame cannot be read, 7 output, 8 "
    "blob.\n"
    "\n"
    "Example:\n"
    "  raygrid-undistort camera.raygrid frame.raw flat.pgm\n";

static int fail(int code, const char* image_regions, const char* what) {
  fprintf(stderr, "raygrid-undistort: %s: %s\n", image_regions, what);
  return code;
}

#if defined(__unix__)

/* Opening a pipe without a writer would block. */
static int is_readable(const char* path) {
  struct stat status;
  return stat(path, &status) == 0 && S_ISREG(status.st_mode);
}

/* Compares the files themselves, not their names. */
static int are_one_file(const char* a, const char* b) {
  struct stat of_a, of_b;
  return stat(a, &of_a) == 0 && stat(b, &of_b) == 0 &&
         of_a.st_dev == of_b.st_dev && of_a.st_ino == of_b.st_ino;
}

#else

static int is_readable(const char* path) {
  (void)path;
  return 1;
}

static int are_one_file(const char* a, const char* b) {
  return strcmp(a, b) == 0;
}

#endif

/* Reads a whole file; malloc's alignment exceeds that of blobs. NULL on
 * failure. */
static uint8_t* read_file(const char* path, uint32_t* size) {
  FILE* file = is_readable(path) ? fopen(path, "rb") : NULL;
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

/* Parses the next number in the header of a PGM file, after white space and
 * comments, and advances past it; 0 if there is none. */
static uint32_t next_number(const uint8_t** at, const uint8_t* end) {
  const uint8_t* p = *at;
  while (p != end && (isspace(*p) || *p == '#')) {
    if (*p == '#')
      while (p != end && *p != '\n') ++p;
    else
      ++p;
  }
  uint32_t number = 0;
  for (; p != end && isdigit(*p) && number < 100000; ++p)
    number = 10 * number + (uint32_t)(*p - '0');
  *at = p;
  return number;
}

/* Returns the pixels of a frame file and stores the number of bytes per pixel;
 * NULL if the size does not match. */
static const uint8_t* find_pixels(const uint8_t* bytes, uint32_t size,
                                  uint32_t width, uint32_t height,
                                  uint32_t* pixel_bytes) {
  const uint32_t num_pixels = width * height;
  const uint8_t *p = bytes + 2, *const end = bytes + size;
  *pixel_bytes = size == 2 * num_pixels ? 2 : 1;
  if (size == *pixel_bytes * num_pixels) return bytes;
  if (size < num_pixels || memcmp(bytes, "P5", 2) != 0) return NULL;
  if (next_number(&p, end) != width || next_number(&p, end) != height ||
      next_number(&p, end) != 255)
    return NULL;
  return p != end && isspace(*p) && (uint32_t)(end - p) == num_pixels + 1
             ? p + 1
             : NULL;
}

static int has_suffix(const char* text, const char* suffix) {
  const size_t n = strlen(text), m = strlen(suffix);
  return n >= m && strcmp(text + n - m, suffix) == 0;
}

/* An undistorted frame. */
struct picture {
  uint8_t* pixels;
  uint32_t width, height, pixel_bytes;
};

static size_t num_bytes(const struct picture* picture) {
  return (size_t)picture->width * picture->height * picture->pixel_bytes;
}

/* PGM is big-endian. */
static void swap_bytes(uint8_t* pixels, size_t size) {
  for (size_t i = 0; i + 1 < size; i += 2) {
    const uint8_t low = pixels[i];
    pixels[i] = pixels[i + 1];
    pixels[i + 1] = low;
  }
}

/* Closes the file. */
static int write_pixels(FILE* file, int as_pgm, const struct picture* picture) {
  if (!file) return 0;
  int good = 1;
  const size_t size = num_bytes(picture);
  if (as_pgm) {
    good = fprintf(file, "P5\n%lu %lu\n%d\n", (unsigned long)picture->width,
                   (unsigned long)picture->height,
                   picture->pixel_bytes == 2 ? 65535 : 255) > 0;
    if (picture->pixel_bytes == 2) swap_bytes(picture->pixels, size);
  }
  good = good && fwrite(picture->pixels, 1, size, file) == size;
  return fclose(file) == 0 && good;
}

#if defined(__unix__)

/* A stream is an existing target that is not a regular file, such as a pipe.
 * The frame is written to it directly; it is not replaced. */
static int is_stream(const char* path) {
  struct stat status;
  return stat(path, &status) == 0 && !S_ISREG(status.st_mode);
}

/* The target does not exist yet. */
static FILE* create(const char* path) {
  const int number = open(path, O_WRONLY | O_CREAT | O_EXCL, 0666);
  return number < 0 ? NULL : fdopen(number, "wb");
}

/* Writes to a temporary file in the target's folder first, so that a partial
 * frame is never visible under its name; for a link, in the folder of the
 * link's target. */
static int write_frame(const char* path, const struct picture* picture) {
  const int as_pgm = has_suffix(path, ".pgm");
  if (is_stream(path)) return write_pixels(fopen(path, "wb"), as_pgm, picture);
  char* const real = realpath(path, NULL);
  const char* const target = real ? real : path;
  const size_t size = strlen(target) + sizeof(".part-") + 20;
  char* const part = (char*)malloc(size);
  int good = 0;
  if (part) {
    snprintf(part, size, "%s.part-%ld", target, (long)getpid());
    FILE* const file = create(part);
    good = write_pixels(file, as_pgm, picture) && rename(part, target) == 0;
    if (file && !good) remove(part);
  }
  free(part);
  free(real);
  return good;
}

#else

/* Semihosting cannot rename. */
static int write_frame(const char* path, const struct picture* picture) {
  const int good =
      write_pixels(fopen(path, "wb"), has_suffix(path, ".pgm"), picture);
  if (!good) remove(path);
  return good;
}

#endif

static int undistort(const rg_camera* camera, const uint8_t* pixels,
                     uint32_t pixel_bytes, const char* out_path) {
  uint16_t width, height;
  rg_status status = rg_remap_size(camera, &width, &height);
  if (status != RG_OK) return fail(BLOB, "blob", rg_status_text(status));
  struct picture picture = {NULL, width, height, pixel_bytes};
  picture.pixels = (uint8_t*)malloc(num_bytes(&picture));
  if (!picture.pixels) return fail(INPUT, "output", "not enough memory");
  rg_image frame = {0};
  frame.format = pixel_bytes == 2 ? RG_FORMAT_GREY16 : RG_FORMAT_GREY8;
  rg_frame_size(camera, &frame.width, &frame.height);
  frame.planes[0].data = pixels;
  frame.planes[0].stride = frame.width * pixel_bytes;
  rg_target target = {0};
  target.planes[0].data = picture.pixels;
  target.planes[0].stride = width * pixel_bytes;
  target.num_rows = height;
  int code = DONE;
  status = rg_remap(camera, &frame, &target);
  const uint32_t crc = status == RG_OK ? rg_crc32(0, picture.pixels,
                                                  (uint32_t)num_bytes(&picture))
                                       : 0;
  if (status != RG_OK)
    code = fail(BLOB, "blob", rg_status_text(status));
  else if (!write_frame(out_path, &picture))
    code = fail(OUTPUT, out_path, "cannot be written; use another path");
  else if (printf("%lu x %lu, CRC %08lx\n", (unsigned long)width,
                  (unsigned long)height, (unsigned long)crc) < 0 ||
           fflush(stdout) != 0)
    code = fail(OUTPUT, "standard output", "cannot be written");
  free(picture.pixels);
  return code;
}

int main(int argc, char** argv) {
  if (argc == 2 && strcmp(argv[1], "--help") == 0) {
    if (fputs(kHelp, stdout) < 0 || fflush(stdout) != 0)
      return fail(OUTPUT, "standard output", "cannot be written");
    return DONE;
  }
  if (argc != 4)
    return fail(USAGE, "usage", "raygrid-undistort BLOB IN OUT; see --help");
  for (int i = 1; i <= 2; ++i)
    if (are_one_file(argv[i], argv[3]))
      return fail(OUTPUT, argv[3],
                  "would overwrite an input; use another path");
#if defined(__unix__)
  signal(SIGXFSZ, SIG_IGN); /* exceeding the file-size limit then fails */
#endif

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
    uint32_t pixel_bytes;
    uint16_t width, height;
    rg_frame_size(&camera, &width, &height);
    const uint8_t* pixels =
        find_pixels(frame, frame_size, width, height, &pixel_bytes);
    code = pixels ? undistort(&camera, pixels, pixel_bytes, argv[3])
                  : fail(INPUT, argv[2],
                         "is not a grey frame of the blob's image size");
  }
  free(frame);
  free(blob);
  return code;
}
