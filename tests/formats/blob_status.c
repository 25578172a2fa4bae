/* Prints, for each blob, its path and the numbers of two statuses: that of a
 * whole reader, and that of a board which opens it and selects each table. */
#include <stdio.h>
#include <stdlib.h>

#include "raygrid.h"
#include "rg_blob.h"

static rg_status open_on_board(const void* bytes, uint32_t size) {
  rg_camera camera;
  rg_status status = rg_camera_open(&camera, bytes, size);
  for (uint32_t k = 0; status == RG_OK; ++k) {
    status = rg_select_remap(&camera, k);
    if (status == RG_ERR_NO_REMAP) return RG_OK;
  }
  return status;
}

static int print_statuses(const char* path) {
  FILE* const file = fopen(path, "rb");
  if (!file) return 0;
  static uint32_t words[1 << 16];
  const uint32_t size = (uint32_t)fread(words, 1, sizeof(words), file);
  fclose(file);
  rg_blob blob;
  printf("%s %d %d\n", path, (int)rg_blob_open(words, size, &blob),
         (int)open_on_board(words, size));
  return 1;
}

int main(int argc, char** argv) {
  for (int k = 1; k < argc; ++k)
    if (!print_statuses(argv[k])) return EXIT_FAILURE;
  return EXIT_SUCCESS;
}
