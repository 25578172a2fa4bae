# The target raygrid_cmocka: from Debian's source package where
# RAYGRID_CMOCKA_SOURCE names it (tests/run does, for every target alike), else
# the machine's own library.
set(RAYGRID_CMOCKA_SOURCE "" CACHE PATH "Folder of CMocka's sources")

if(RAYGRID_CMOCKA_SOURCE)
  add_library(raygrid_cmocka STATIC ${RAYGRID_CMOCKA_SOURCE}/src/cmocka.c)
  target_include_directories(raygrid_cmocka SYSTEM PUBLIC ${RAYGRID_CMOCKA_SOURCE}/include)
  set_target_properties(raygrid_cmocka PROPERTIES C_EXTENSIONS ON)
  foreach(have STDDEF_H SETJMP_H STDIO_H STRING_H STDLIB_H INTTYPES_H STDINT_H SNPRINTF
               VSNPRINTF SIGNAL_H STRSIGNAL)
    target_compile_definitions(raygrid_cmocka PRIVATE HAVE_${have}=1)
  endforeach()
  if(NOT CMAKE_SYSTEM_NAME STREQUAL "Generic")
    target_compile_definitions(raygrid_cmocka PRIVATE
      HAVE_MALLOC_H=1 HAVE_TIME_H=1 HAVE_STRUCT_TIMESPEC=1)
  endif()
  target_compile_definitions(raygrid_cmocka PUBLIC _UINTPTR_T=1 _UINTPTR_T_DEFINED=1)
  target_compile_options(raygrid_cmocka PRIVATE -w)
else()
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(CMOCKA REQUIRED IMPORTED_TARGET cmocka)
  add_library(raygrid_cmocka INTERFACE)
  target_link_libraries(raygrid_cmocka INTERFACE PkgConfig::CMOCKA)
endif()

# One board of each instruction set runs all tests. The others differ from it by options of
# the compiler: they run what is compared with golden bits, arithmetic, and what is of their
# own, and are measured (tests/board).
option(RAYGRID_GOLDEN_TESTS "Of the runtime's tests, run those of golden blobs and arithmetic" OFF)
set(golden_tests blob_read_test camera_test unprojection_test projection_test remap_test remap_format_test
  assembler_test fixed_point_test multiply_test
  stm32h7_dcmi_test rp2040_pio_test esp32s3_cam_test)
# On the host these take more than two CPU seconds.
set(long_c_tests remap_kernels_test remap_rings_test small_remap_rings_test small_remap_kernels_test)

# A test program of one C file, run through the target's emulator by ctest.
function(raygrid_c_test name)
  add_executable(${name} ${ARGN})
  set(is_left_out OFF)
  if(RAYGRID_GOLDEN_TESTS AND NOT RAYGRID_LONG_TESTS AND NOT name IN_LIST golden_tests)
    set(is_left_out ON)
  endif()
  set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL ${is_left_out})
  set_target_properties(${name} PROPERTIES C_EXTENSIONS ON)
  target_link_libraries(${name} PRIVATE raygrid_runtime raygrid_golden raygrid_cmocka raygrid_warnings)
  if(is_left_out)
    return()
  endif()
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT 1800)
  if(RAYGRID_HOST AND NOT name IN_LIST long_c_tests)
    raygrid_quick_program(${name})
    raygrid_quick_test(${name})
  endif()
endfunction()

# The traversal of small boards, in front of the library's in programs that link it.
if(RAYGRID_HOST)
  add_library(raygrid_small_traversal OBJECT)
  foreach(source rays/camera rays/operating_point cortex_m/blended_corners frames/remap frames/remap_grey
      frames/remap_source_rows frames/traversal_fast frames/traversal_small kernels/dispatch kernels/portable)
    target_sources(raygrid_small_traversal PRIVATE ${PROJECT_SOURCE_DIR}/runtime/${source}.c)
  endforeach()
  target_compile_definitions(raygrid_small_traversal PUBLIC RG_FAST_TRAVERSAL=0)
  target_link_libraries(raygrid_small_traversal PRIVATE raygrid_runtime raygrid_warnings)
endif()
