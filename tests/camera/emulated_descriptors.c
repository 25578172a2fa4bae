#include "emulated_descriptors.h"

#include <string.h>

void add8(bytes* to, unsigned value) { to->data[to->size++] = (uint8_t)value; }

void add16(bytes* to, unsigned value) {
  add8(to, value & 255);
  add8(to, value >> 8 & 255);
}

void add32(bytes* to, uint32_t value) {
  add16(to, value & 0xffff);
  add16(to, value >> 16);
}

void add_list(bytes* to, const uint8_t* values, int count) {
  for (int i = 0; i < count; ++i) add8(to, values[i]);
}

const uint8_t kDevice[18] = {18,   1,    0x00, 0x02, 0xef, 2, 1, 64, 0x09,
                             0x12, 0x01, 0x00, 0x00, 1,    1, 2, 0,  1};

/* Writes a length over the two bytes at a place. */
static void set16(bytes* to, int place, int value) {
  to->data[place] = (uint8_t)(value & 255);
  to->data[place + 1] = (uint8_t)(value >> 8);
}

/* Camera terminal 1 and processing unit 3 to output terminal 2. */
static void add_control_interface(bytes* to) {
  ADD(to, 9, 4, CONTROL_INTERFACE, 0, 0, VIDEO_CLASS, 1, 0, 0);
  const int start = to->size;
  ADD(to, 13, 0x24, 1, 0x00, 0x01, 0, 0);
  add32(to, 48000000);
  ADD(to, 1, STREAM_INTERFACE);
  /* Its last bytes name the controls that are in kControls. */
  ADD(to, 18, 0x24, 2, 1, 0x01, 0x02, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0x2a, 0, 2);
  ADD(to, 11, 0x24, 5, 3, 1, 0, 0, 2, 0x40, 0x12, 0);
  ADD(to, 9, 0x24, 3, 2, 0x01, 0x01, 0, 3, 0);
  set16(to, start + 5, to->size - start);
}

static const uint8_t kYuyv[16] = {'Y',  'U',  'Y',  '2',  0, 0,
                                  0x10, 0,    0x80, 0x00, 0, 0xaa,
                                  0x00, 0x38, 0x9b, 0x71};

/* subtype: 5 of frames of pixels, 7 of JPEGs */
static void add_frame_sizes(bytes* to, uint8_t subtype, unsigned width,
                            unsigned height, unsigned interval) {
  const uint32_t frame_size = width * height * 2;
  const uint32_t bits = frame_size * 8 * (10000000 / interval);
  ADD(to, 30, 0x24, subtype, 1, 0);
  add16(to, width);
  add16(to, height);
  add32(to, bits);
  add32(to, bits);
  add32(to, frame_size);
  add32(to, interval);
  add8(to, 1);
  add32(to, interval);
}

static void add_stream_interface(bytes* to, int is_jpeg, unsigned width,
                                 unsigned height, unsigned interval) {
  ADD(to, 9, 4, STREAM_INTERFACE, 0, 1, VIDEO_CLASS, 2, 0, 0);
  const int start = to->size;
  ADD(to, 14, 0x24, 1, 1, 0, 0, STREAM_ENDPOINT, 0, 2, 0, 0, 0, 1, 0);
  if (is_jpeg) {
    ADD(to, 11, 0x24, 6, 1, 1, 0, 1, 0, 0, 0, 0);
  } else {
    ADD(to, 27, 0x24, 4, 1, 1);
    add_list(to, kYuyv, 16);
    ADD(to, 16, 1, 0, 0, 0, 0);
  }
  add_frame_sizes(to, is_jpeg ? 7 : 5, width, height, interval);
  ADD(to, 6, 0x24, 13, 1, 1, 4);
  set16(to, start + 4, to->size - start);
  ADD(to, 7, 5, STREAM_ENDPOINT, 2, STREAM_PACKET & 255, STREAM_PACKET >> 8, 0);
}

bytes make_configuration(int is_jpeg, unsigned width, unsigned height,
                         unsigned interval) {
  bytes all = {{0}, 0};
  ADD(&all, 9, 2, 0, 0, 2, 1, 0, 0x80, 50);
  ADD(&all, 8, 11, CONTROL_INTERFACE, 2, VIDEO_CLASS, 3, 0, 0);
  add_control_interface(&all);
  add_stream_interface(&all, is_jpeg, width, height, interval);
  set16(&all, 2, all.size);
  return all;
}

bytes make_probe(unsigned width, unsigned height, unsigned interval) {
  bytes probe = {{0}, 0};
  ADD(&probe, 1, 0, 1, 1);
  add32(&probe, interval);
  ADD(&probe, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
  add32(&probe, width * height * 2);
  add32(&probe, MAX_PAYLOAD);
  return probe;
}

bytes make_text(const char* text) {
  bytes result = {{0}, 0};
  ADD(&result, (uint8_t)(2 + 2 * strlen(text)), 3);
  for (; *text; ++text) add16(&result, (uint8_t)*text);
  return result;
}
