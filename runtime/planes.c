#include "planes.h"

uintptr_t rg_remainder(uintptr_t a, uintptr_t b) {
  for (int shift = 15; shift >= 0; --shift)
    if (a >> shift >= b) a -= b << shift;
  return a;
}

static uintptr_t end_of(const rg_plane* plane) {
  return (uintptr_t)plane->data +
         (uintptr_t)(plane->num_rows - 1) * plane->stride + plane->row_bytes;
}

int rg_do_planes_overlap(const rg_plane* a, const rg_plane* b) {
  if (a->num_rows == 0 || b->num_rows == 0) return 0;
  if (a->data > b->data) {
    const rg_plane* const first = b;
    b = a;
    a = first;
  }
  if ((uintptr_t)b->data >= end_of(a)) return 0;
  if (a->stride != b->stride) return 1;
  /* Rows may lie beside each other. */
  const uintptr_t offset = rg_remainder((uintptr_t)b->data - (uintptr_t)a->data,
                                        (uintptr_t)a->stride);
  return offset < a->row_bytes || offset + b->row_bytes > a->stride;
}
