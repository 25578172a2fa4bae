#include <string.h>

#include "golden_blobs.h"
#include "raygrid.h"
#include "unit_test.h"

static uint8_t blob[sizeof(kExampleBlob)] __attribute__((aligned(4)));

static void handle_is_at_most_64_bytes(void** state) {
  (void)state;
  assert_true(sizeof(rg_camera) <= 64);
}

static void camera_is_opened(void** state) {
  (void)state;
  rg_camera camera;
  assert_int_equal(rg_camera_open(&camera, kExampleBlob, sizeof(kExampleBlob)),
                   RG_OK);
}

static void damaged_blob_leaves_the_camera_untouched(void** state) {
  (void)state;
  rg_camera camera, untouched;
  memset(&camera, 0x5a, sizeof(camera));
  memset(&untouched, 0x5a, sizeof(untouched));
  memcpy(blob, kExampleBlob, sizeof(blob));
  blob[sizeof(blob) - 1] ^= 1;
  assert_int_equal(rg_camera_open(&camera, blob, sizeof(blob)),
                   RG_ERR_SECTION_CRC);
  assert_memory_equal(&camera, &untouched, sizeof(camera));
}

static void null_is_refused(void** state) {
  (void)state;
  rg_camera camera;
  assert_int_equal(rg_camera_open(NULL, kExampleBlob, sizeof(kExampleBlob)),
                   RG_ERR_ARGUMENT);
  assert_int_equal(rg_camera_open(&camera, NULL, sizeof(kExampleBlob)),
                   RG_ERR_ARGUMENT);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(handle_is_at_most_64_bytes),
      cmocka_unit_test(camera_is_opened),
      cmocka_unit_test(damaged_blob_leaves_the_camera_untouched),
      cmocka_unit_test(null_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
