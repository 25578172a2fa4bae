/* The golden blobs, and where things stand in kExampleBlob. */
#ifndef RAYGRID_EXAMPLE_BLOB_H
#define RAYGRID_EXAMPLE_BLOB_H

#include "golden_blobs.h"

#define ENTRY(k) (32u + 16u * (k))
#define CAMERA 96u
#define GRID 168u
#define CONTROL_POINTS (GRID + 40u)
#define REMAP 336u
#define VERTICES (REMAP + 80u)
#define MASK (VERTICES + 24u)
#define QUALITY 444u
#define SIZE ((uint32_t)sizeof(kExampleBlob))

#endif /* RAYGRID_EXAMPLE_BLOB_H */
