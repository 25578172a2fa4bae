/* CRC-32 as in zlib, PNG and Ethernet: reflected polynomial 0xEDB88320, start
 * and final exclusive-or 0xFFFFFFFF. */
#ifndef RAYGRID_CRC32_H
#define RAYGRID_CRC32_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Returns the CRC of num_bytes bytes, continuing crc (initially 0), so that
 * rg_crc32(rg_crc32(0, a, n), b, m) is the CRC of a followed by b. */
uint32_t rg_crc32(uint32_t crc, const uint8_t* bytes, uint32_t num_bytes);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_CRC32_H */
