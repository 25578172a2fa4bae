#include <string.h>

#include "rg_status.h"
#include "unit_test.h"

/* The named values lie between RG_ERR_NO_SLOT and RG_OK. */
static void every_status_has_its_own_text(void** state) {
  (void)state;
  for (int a = RG_OK; a >= RG_ERR_NO_SLOT - 1; --a) {
    const char* text = rg_status_text((rg_status)a);
    if (strcmp(text, rg_status_text((rg_status)1)) == 0) continue;
    for (int b = RG_OK; b > a; --b)
      assert_string_not_equal(text, rg_status_text((rg_status)b));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_status_has_its_own_text),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
