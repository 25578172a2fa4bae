/* The descriptors of the emulated camera: UVC 1.0, one size, frames over a bulk
 * endpoint. */
#ifndef RAYGRID_TESTS_CAMERA_EMULATED_DESCRIPTORS_H
#define RAYGRID_TESTS_CAMERA_EMULATED_DESCRIPTORS_H

#include <stdint.h>

enum {
  CONTROL_INTERFACE = 0,
  STREAM_INTERFACE = 1,
  VIDEO_CLASS = 0x0e,
  STREAM_ENDPOINT = 0x81,
  STREAM_PACKET = 512,
  MAX_PAYLOAD = 16384, /* what uvcvideo reads at once */
  PROBE_SIZE = 26      /* of UVC 1.0 */
};

/* Bytes of an answer. */
typedef struct bytes {
  uint8_t data[256];
  int size;
} bytes;

/* Little-endian. */
void add8(bytes* to, unsigned value);
void add16(bytes* to, unsigned value);
void add32(bytes* to, uint32_t value);
void add_list(bytes* to, const uint8_t* values, int count);

#define ADD(to, ...)                           \
  add_list(to, (const uint8_t[]){__VA_ARGS__}, \
           (int)sizeof((const uint8_t[]){__VA_ARGS__}))

extern const uint8_t kDevice[18];

/* interval: of frames, 100 ns */
bytes make_configuration(int is_jpeg, unsigned width, unsigned height,
                         unsigned interval);
/* The only stream there is, as probe and commit answer it. */
bytes make_probe(unsigned width, unsigned height, unsigned interval);
bytes make_text(const char* text);

#endif
