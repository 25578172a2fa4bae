/* Opening any bytes: a status, and nothing outside is read; both readers agree.
 */
#include <stdlib.h>
#include <string.h>

#include "fuzz_target.h"
#include "raygrid.h"
#include "rg_blob.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  uint32_t blob_size;
  uint8_t* const bytes = take_blob(data, size, &blob_size);
  if (!bytes) return 0;
  rg_camera camera, before;
  rg_blob blob;
  memset(&camera, 0xc3, sizeof(camera));
  before = camera;
  const rg_status status = rg_camera_open(&camera, bytes, blob_size);
  require(status == rg_blob_open(bytes, blob_size, &blob),
          "both readers give the same status");
  require(strlen(rg_status_text(status)) > 1, "every status has a text");
  if (status != RG_OK) {
    require(memcmp(&camera, &before, sizeof(camera)) == 0,
            "a failed call leaves its outputs alone");
  } else {
    require(camera.width != 0 && camera.height != 0, "an image has a size");
    uint32_t num_tables = 0;
    while (rg_select_remap(&camera, num_tables) == RG_OK) ++num_tables;
    require(num_tables <= RG_MAX_SECTIONS, "tables are sections");
  }
  free(bytes);
  return 0;
}
