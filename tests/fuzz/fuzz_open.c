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
  const rg_status strict = rg_blob_open(bytes, blob_size, &blob);
  require(status == RG_OK || strict != RG_OK,
          "what the host's reader accepts, a board opens");
  require(strlen(rg_status_text(status)) > 1, "every status has a text");
  require(strlen(rg_status_text(strict)) > 1, "every status has a text");
  if (status != RG_OK) {
    require(memcmp(&camera, &before, sizeof(camera)) == 0,
            "a failed call leaves its outputs alone");
  } else {
    uint32_t num_tables = 0;
    while (num_tables <= RG_MAX_SECTIONS) {
      const rg_status selected = rg_select_remap(&camera, num_tables);
      if (selected == RG_ERR_NO_REMAP) break;
      require(selected == RG_OK || strict != RG_OK,
              "what the host's reader accepts, a board selects");
      ++num_tables;
    }
    require(num_tables <= RG_MAX_SECTIONS, "tables are sections");
  }
  free(bytes);
  return 0;
}
