# What most stages include, parsed once for all of them, with the templates that these
# headers instantiate. Precompiled headers want the options that they were made with:
# those of numeric stages have loops over parameters, control points and observations,
# which g++ leaves scalar at -O2. Text stages are compiled for size: optimizing them for
# speed costs more build time than it saves at run time.
set(stage_headers
  camera/operating_point_model.h camera/camera_uncertainty.h camera/central_generic.h
  camera/noncentral_generic.h camera/opencv.h
  dataset/camera_file.h dataset/dataset.h dataset/error.h)
list(TRANSFORM stage_headers PREPEND ${PROJECT_SOURCE_DIR}/offline/)
list(PREPEND stage_headers
  ${PROJECT_SOURCE_DIR}/offline/camera/eigen_templates.h
  <algorithm> <array> <cmath> <filesystem> <functional> <map> <memory> <optional> <random> <set>
  <string> <thread> <vector>
  <fmt/format.h>)
set(general_headers <Eigen/SparseCore>)
set(numeric_headers <Eigen/SparseCore>)
set(text_headers <CLI/CLI.hpp> <nlohmann/json.hpp> <yaml-cpp/yaml.h>)
set(general_options)
set(numeric_options "$<$<CONFIG:Release>:-O3>")
set(text_options "$<$<CONFIG:Release>:-Oz>" "$<$<CONFIG:Sanitized>:-O0>")
foreach(kind general numeric text)
  add_library(raygrid_precompiled_${kind} OBJECT ${where_tests_need_it} offline/precompiled.cc)
  target_include_directories(raygrid_precompiled_${kind} PRIVATE ${PROJECT_SOURCE_DIR}/offline)
  target_link_libraries(raygrid_precompiled_${kind} PRIVATE
    CLI11::CLI11 Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json yaml-cpp raygrid_warnings)
  target_compile_options(raygrid_precompiled_${kind} PRIVATE ${${kind}_options})
  target_precompile_headers(raygrid_precompiled_${kind} PRIVATE ${stage_headers} ${${kind}_headers})
  raygrid_serve_modules(raygrid_precompiled_${kind})
endforeach()

# Compiles a target as stages of a kind are: with their options and precompiled headers.
function(raygrid_compile_as kind target)
  target_compile_options(${target} PRIVATE ${${kind}_options})
  target_precompile_headers(${target} REUSE_FROM raygrid_precompiled_${kind})
  get_target_property(type ${target} TYPE)
  if(NOT type STREQUAL "EXECUTABLE")
    raygrid_serve_modules(${target})
  elseif(RAYGRID_HAS_PYTHON OR RAYGRID_HAS_GSTREAMER OR RAYGRID_HAS_HOST_LIBRARY) # not -fPIE, as the headers were made
    set_target_properties(${target} PROPERTIES
      CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
    target_compile_options(${target} PRIVATE -fPIC)
  endif()
endfunction()
