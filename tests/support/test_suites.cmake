# A test of ctest for each suite of a GoogleTest program: tests of one process
# share what they set up. LEFT_OUT: patterns of tests that are not run. LABELS: a file
# that sets NOT_QUICK, the suites that do not get the label quick; empty: none does.
function(raygrid_test_suites program left_out labels)
  set(list ${CMAKE_CURRENT_BINARY_DIR}/${program}_suites.cmake)
  list(JOIN left_out ":" filter)
  if(filter)
    set(filter ":-${filter}")
  endif()
  add_custom_command(TARGET ${program} POST_BUILD
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${program}> "-DFILTER=${filter}"
      "-DLABELS=${labels}" -DLIST=${list}
      -P ${PROJECT_SOURCE_DIR}/tests/support/list_suites.cmake
    BYPRODUCTS ${list} VERBATIM)
  if(labels)
    set_property(TARGET ${program} APPEND PROPERTY LINK_DEPENDS ${labels})
  endif()
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/${program}_tests.cmake
    "if(EXISTS ${list})\n  include(${list})\nelse()\n  add_test(${program} ${program})\nendif()\n")
  set_property(DIRECTORY APPEND PROPERTY
    TEST_INCLUDE_FILES ${CMAKE_CURRENT_BINARY_DIR}/${program}_tests.cmake)
endfunction()

# Target quick builds the programs that tests with the label quick need.
add_custom_target(quick)
function(raygrid_quick_program)
  add_dependencies(quick ${ARGN})
endfunction()
function(raygrid_quick_test)
  set_tests_properties(${ARGN} PROPERTIES LABELS quick)
endfunction()
