# A test of ctest for each suite of a GoogleTest program: tests of one process
# share what they set up. FILTER is nothing, or ":-" and which tests to leave out.
function(raygrid_test_suites program filter)
  set(list ${CMAKE_CURRENT_BINARY_DIR}/${program}_suites.cmake)
  add_custom_command(TARGET ${program} POST_BUILD
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${program}> "-DFILTER=${filter}" -DLIST=${list}
      -P ${PROJECT_SOURCE_DIR}/tests/support/list_suites.cmake
    BYPRODUCTS ${list} VERBATIM)
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/${program}_tests.cmake
    "if(EXISTS ${list})\n  include(${list})\nelse()\n  add_test(${program} ${program})\nendif()\n")
  set_property(DIRECTORY APPEND PROPERTY
    TEST_INCLUDE_FILES ${CMAKE_CURRENT_BINARY_DIR}/${program}_tests.cmake)
endfunction()
