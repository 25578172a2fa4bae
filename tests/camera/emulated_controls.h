/* Focus, exposure, gain and white balance of the emulated camera. */
#ifndef RAYGRID_TESTS_CAMERA_EMULATED_CONTROLS_H
#define RAYGRID_TESTS_CAMERA_EMULATED_CONTROLS_H

#include <stdint.h>

#include "emulated_descriptors.h"

enum {
  AE_MODE,
  EXPOSURE,
  FOCUS,
  FOCUS_AUTO,
  GAIN,
  WHITE,
  WHITE_AUTO,
  NUM_CONTROLS,
  MAX_SETTINGS = 64,
  AE_MANUAL = 1,
  AE_APERTURE_PRIORITY = 8,
  FOLLOWS = 8 /* in info: the value changes by itself */
};

/* The step of AE_MODE is a mask of the modes that there are, as UVC has it. */
typedef struct usb_control {
  const char* name;
  uint8_t entity, selector, size, info;
  uint16_t minimum, maximum, step, initial, value;
} usb_control;

typedef struct usb_controls {
  usb_control all[NUM_CONTROLS];
  struct {
    const char* name;
    unsigned value, exposure, focus; /* as it is, and as the camera stands */
  } settings[MAX_SETTINGS];          /* of controls, the first ones */
  int num_settings;
} usb_controls;

/* All modes are automatic, as after a camera was plugged in. Settings stay. */
void reset_controls(usb_controls* controls);
/* The control of a request's fields; NULL where there is none. num_sent: whole
 * frames so far, each of which has a focus and an exposure of its own while
 * they follow. */
usb_control* find_control(usb_controls* controls, unsigned index,
                          unsigned value, long num_sent);
/* 0: the control has no such request. */
int get_control(const usb_control* control, unsigned request, bytes* answer);
void set_control(usb_controls* controls, usb_control* control,
                 const uint8_t* data, int size);
void print_settings(const usb_controls* controls);

#endif
