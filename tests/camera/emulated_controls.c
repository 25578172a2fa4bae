#include "emulated_controls.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

static const usb_control kControls[NUM_CONTROLS] = {
    [AE_MODE] = {"exposure mode", 1, 2, 1, 3, 1, 8, 9, AE_APERTURE_PRIORITY,
                 AE_APERTURE_PRIORITY},
    [EXPOSURE] = {"exposure", 1, 4, 4, 3, 3, 2047, 1, 100, 100},
    [FOCUS] = {"focus", 1, 6, 2, 3 | FOLLOWS, 0, 250, 1, 40, 40},
    [FOCUS_AUTO] = {"focus mode", 1, 8, 1, 3, 0, 1, 1, 1, 1},
    [GAIN] = {"gain", 3, 4, 2, 3, 0, 255, 1, 64, 64},
    [WHITE] = {"white", 3, 0x0a, 2, 3, 2000, 6500, 1, 4600, 4600},
    [WHITE_AUTO] = {"white mode", 3, 0x0b, 1, 3, 0, 1, 1, 1, 1}};

void reset_controls(usb_controls* controls) {
  memcpy(controls->all, kControls, sizeof(kControls));
}

/* Each frame has a focus and an exposure of its own while they follow. */
static void follow(usb_controls* controls, long num_sent) {
  if (controls->all[AE_MODE].value != AE_MANUAL)
    controls->all[EXPOSURE].value = (uint16_t)(100 + num_sent % 50);
  if (controls->all[FOCUS_AUTO].value != 0)
    controls->all[FOCUS].value = (uint16_t)(40 + num_sent % 20);
}

usb_control* find_control(usb_controls* controls, unsigned index,
                          unsigned value, long num_sent) {
  if ((index & 255) != CONTROL_INTERFACE) return NULL;
  follow(controls, num_sent);
  for (int i = 0; i < NUM_CONTROLS; ++i)
    if (controls->all[i].entity == index >> 8 &&
        controls->all[i].selector == value >> 8)
      return &controls->all[i];
  return NULL;
}

int get_control(const usb_control* control, unsigned request, bytes* answer) {
  enum { CURRENT = 0x81, MINIMUM, MAXIMUM, STEP, LENGTH, INFORMATION, DEFAULT };
  if (!control) return 0;
  if (request == LENGTH) add16(answer, control->size);
  if (request == INFORMATION) add8(answer, control->info);
  if (request == LENGTH || request == INFORMATION) return 1;
  add32(answer, request == CURRENT   ? control->value
                : request == MINIMUM ? control->minimum
                : request == MAXIMUM ? control->maximum
                : request == STEP    ? control->step
                                     : control->initial);
  answer->size = control->size;
  return 1;
}

void set_control(usb_controls* controls, usb_control* control,
                 const uint8_t* data, int size) {
  if (!control || size < control->size) return;
  control->value =
      (uint16_t)(control->size == 1 ? data[0] : data[0] | data[1] << 8);
  if (controls->num_settings == MAX_SETTINGS) return;
  const int i = controls->num_settings++;
  controls->settings[i].name = control->name;
  controls->settings[i].value = control->value;
  controls->settings[i].exposure = controls->all[EXPOSURE].value;
  controls->settings[i].focus = controls->all[FOCUS].value;
}

void print_settings(const usb_controls* controls) {
  for (int i = 0; i < controls->num_settings; ++i)
    printf("%s %u, exposure %u, focus %u\n", controls->settings[i].name,
           controls->settings[i].value, controls->settings[i].exposure,
           controls->settings[i].focus);
}
