/* Predicts the pixel of a distant point after a rotation of the camera measured
 * by a gyroscope: a tracker searches for it there, in a radius given by the
 * camera's uncertainty.
 *
 * track_point BLOB X Y YAW_DEG PITCH_DEG */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "raygrid.h"

static int fail(const char* where, const char* what) {
  fprintf(stderr, "track_point: %s: %s\n", where, what);
  return 1;
}

static double number(const char* text) {
  char* end;
  const double value = strtod(text, &end);
  if (end == text || *end != 0) exit(fail(text, "is not a number"));
  return value;
}

static int32_t to_pixel(const char* text) {
  return (int32_t)lround(number(text) * 65536);
}

/* Rotates (a, b) by an angle. */
static void turn(int32_t* a, int32_t* b, const char* degrees) {
  const double angle = number(degrees) * 3.14159265358979323846 / 180;
  const double c = cos(angle), s = sin(angle), x = *a, y = *b;
  *a = (int32_t)lround(c * x - s * y);
  *b = (int32_t)lround(s * x + c * y);
}

int main(int argc, char** argv) {
  static uint32_t blob[1 << 18]; /* blobs must be aligned to 4 bytes */
  if (argc != 6) return fail("usage", "track_point BLOB X Y YAW_DEG PITCH_DEG");
  FILE* file = fopen(argv[1], "rb");
  if (!file) return fail(argv[1], "cannot be read");
  const size_t size = fread(blob, 1, sizeof(blob), file);
  fclose(file);

  rg_camera camera;
  rg_status status = rg_camera_open(&camera, blob, (uint32_t)size);
  if (status != RG_OK) return fail(argv[1], rg_status_text(status));

  const rg_pixel before = {to_pixel(argv[2]), to_pixel(argv[3])};
  rg_ray ray;
  status = rg_unproject(&camera, before, &ray);
  if (status != RG_OK) return fail("pixel", rg_status_text(status));
  printf("direction %.6f %.6f %.6f\n", ray.x_q30 / 1073741824.0,
         ray.y_q30 / 1073741824.0, ray.z_q30 / 1073741824.0);

  /* The camera rotates right and up, so points rotate left and down. */
  turn(&ray.x_q30, &ray.z_q30, argv[4]);
  turn(&ray.z_q30, &ray.y_q30, argv[5]);

  rg_pixel after;
  status = rg_project(&camera, &ray, &after);
  if (status == RG_ERR_NOT_SEEN) {
    puts("not visible");
    return 0;
  }
  if (status != RG_OK) return fail("direction", rg_status_text(status));
  printf("pixel %.4f %.4f\n", after.x_q16 / 65536.0, after.y_q16 / 65536.0);
  uint16_t sigma_q12;
  if (rg_uncertainty(&camera, after, &sigma_q12) == RG_OK)
    printf("standard deviation %.4f\n", sigma_q12 / 4096.0);
  return 0;
}
