# Run by test_suites.cmake: writes LIST, with a test for each suite of PROGRAM that
# has tests not left out by FILTER. LABELS sets NOT_QUICK: the suites without the
# label quick.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND ${PROGRAM} --gtest_list_tests "--gtest_filter=*${FILTER}"
  OUTPUT_VARIABLE tests COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "\n[A-Za-z0-9_/]+\\." suites "\n${tests}")
set(text)
if(LABELS)
  include(${LABELS})
endif()
foreach(suite ${suites})
  string(REGEX REPLACE "\n(.*)\\." "\\1" suite ${suite})
  string(APPEND text "add_test(${suite} ${PROGRAM} \"--gtest_filter=${suite}.*${FILTER}\")\n"
    "set_tests_properties(${suite} PROPERTIES TIMEOUT 1800 ")
  if(LABELS AND NOT suite IN_LIST NOT_QUICK)
    string(APPEND text "LABELS quick ")
  endif()
  # Skipped where nothing ran; after a failure other lines follow.
  string(APPEND text [=[SKIP_REGULAR_EXPRESSION "PASSED  . 0 tests\\.\n(.  SKIPPED [^\n]*\n)*$")
]=])
endforeach()
file(WRITE ${LIST} "${text}")
