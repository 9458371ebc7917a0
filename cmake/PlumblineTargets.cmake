# SPDX-License-Identifier: Apache-2.0
# One interface target carries the warnings and sanitizers; nothing is set globally.
add_library(plumbline_settings INTERFACE)
target_compile_options(plumbline_settings INTERFACE -Wall -Wextra -Werror -Wshadow -Wno-missing-field-initializers)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC 12 reports false positives inside Eigen and the standard library at -O2 and above; and it takes what a source
  # keeps to itself for a header's where a large piece includes the source.
  target_compile_options(plumbline_settings INTERFACE -Wno-maybe-uninitialized -Wno-array-bounds -Wno-stringop-overflow
    -Wno-stringop-overread -Wno-restrict $<$<BOOL:${PLUMBLINE_UNITY}>:-Wno-subobject-linkage>)
endif()
# A hundred programs are linked: gold takes a third of the time that the usual linker takes.
if(NOT PLUMBLINE_SANITIZE)
  include(CheckLinkerFlag)
  check_linker_flag(CXX -fuse-ld=gold PLUMBLINE_HAS_GOLD)
  if(PLUMBLINE_HAS_GOLD)
    target_link_options(plumbline_settings INTERFACE -fuse-ld=gold)
  endif()
endif()
# A fixed evaluation order of floating point: the same run, bit for bit.
target_compile_options(plumbline_settings INTERFACE -ffp-contract=off)
target_include_directories(plumbline_settings INTERFACE ${CMAKE_SOURCE_DIR})
target_compile_definitions(plumbline_settings INTERFACE
  $<$<NOT:$<CONFIG:Release>>:EIGEN_INITIALIZE_MATRICES_BY_NAN>)
if(PLUMBLINE_SANITIZE STREQUAL "fuzz")  # clang; its warnings are others than those that are kept at none
  target_compile_options(plumbline_settings INTERFACE -w -fsanitize=fuzzer-no-link,address,undefined,float-cast-overflow
    -fno-sanitize=vptr -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(plumbline_settings INTERFACE -fsanitize=address,undefined)
elseif(PLUMBLINE_SANITIZE)
  target_compile_options(plumbline_settings INTERFACE -fsanitize=${PLUMBLINE_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(plumbline_settings INTERFACE -fsanitize=${PLUMBLINE_SANITIZE})
  if(PLUMBLINE_SANITIZE STREQUAL "thread")
    add_library(plumbline_one_tbb_thread OBJECT ${CMAKE_SOURCE_DIR}/tests/sanitizers/one_tbb_thread.cc)
    target_link_libraries(plumbline_one_tbb_thread PRIVATE TBB::tbb)
    target_compile_options(plumbline_one_tbb_thread PRIVATE -fsanitize=thread)
  endif()
endif()

# plumbline_precompile(TARGET engine|app|tests [OPTION]): TARGET reuses cmake/precompiled/NAME.h, compiled once for all of them
# (and once more for those that are compiled with OPTION).
function(plumbline_precompile target name)
  if(NOT PLUMBLINE_PRECOMPILED_HEADERS)
    return()
  endif()
  set(carrier plumbline_precompiled_${name}${ARGN})
  if(NOT TARGET ${carrier})
    file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/precompiled/${name}${ARGN}.cc CONTENT "// Carries a precompiled header.\n")
    add_library(${carrier} OBJECT ${CMAKE_BINARY_DIR}/precompiled/${name}${ARGN}.cc)
    target_compile_options(${carrier} PRIVATE ${ARGN})
    target_link_libraries(${carrier} PRIVATE plumbline_settings Eigen3::Eigen nlohmann_json::nlohmann_json
      $<$<STREQUAL:${name},tests>:GTest::gtest> $<$<STREQUAL:${name},tests>:GTest::gmock>)
    target_include_directories(${carrier} SYSTEM PRIVATE ${OpenCV_INCLUDE_DIRS})
    target_precompile_headers(${carrier} PRIVATE ${CMAKE_SOURCE_DIR}/cmake/precompiled/${name}.h)
  endif()
  target_precompile_headers(${target} REUSE_FROM ${carrier})
endfunction()

# plumbline_compile_in_pieces(TARGET a.cc ...): these sources, and no others, share pieces of eight at most.
function(plumbline_compile_in_pieces target)
  list(LENGTH ARGN count)
  if(count EQUAL 0)
    return()
  endif()
  get_target_property(first ${target} PLUMBLINE_NUM_PIECES)
  if(NOT first)
    set(first 0)
  endif()
  math(EXPR pieces "(${count} + 7) / 8")
  set(index 0)
  foreach(source IN LISTS ARGN)
    math(EXPR piece "${first} + ${index} * ${pieces} / ${count}")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${piece})
    math(EXPR index "${index} + 1")
  endforeach()
  math(EXPR first "${first} + ${pieces}")
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP PLUMBLINE_NUM_PIECES ${first})
endfunction()

# plumbline_add_module(NAME SOURCES a.cc ... REPORT_SOURCES b.cc ... LINKS plumbline_base ... SYSTEM Eigen3::Eigen ...)
# REPORT_SOURCES read the mapper's report (mapping/map_report.h): a new field of it compiles them again, and SOURCES not.
function(plumbline_add_module name)
  cmake_parse_arguments(arg "" "" "SOURCES;REPORT_SOURCES;LINKS;SYSTEM" ${ARGN})
  if(arg_SOURCES OR arg_REPORT_SOURCES)
    add_library(plumbline_${name} STATIC ${arg_SOURCES} ${arg_REPORT_SOURCES})
    plumbline_compile_in_pieces(plumbline_${name} ${arg_SOURCES})
    plumbline_compile_in_pieces(plumbline_${name} ${arg_REPORT_SOURCES})
    plumbline_precompile(plumbline_${name} engine)
    set(scope PUBLIC)
  else()  # headers only
    add_library(plumbline_${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  target_link_libraries(plumbline_${name} ${scope} plumbline_settings ${arg_LINKS} ${arg_SYSTEM})
  target_include_directories(plumbline_${name} SYSTEM ${scope} ${OpenCV_INCLUDE_DIRS})
endfunction()

# What `./dev test` builds: what no quick test runs is left out.
add_custom_target(plumbline_quick_tests)

# plumbline_add_test(NAME SOURCES a_test.cc ... LINKS ... LABEL unit|module|gpu|slow [TIMEOUT s])
# PLUMBLINE_TEST_OPTION is set by tests/CMakeLists.txt for each folder.
function(plumbline_add_test name)
  cmake_parse_arguments(arg "" "LABEL;TIMEOUT" "SOURCES;LINKS" ${ARGN})
  if(NOT arg_LABEL)
    set(arg_LABEL unit)
  endif()
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 300)  # three times what the slowest take on a machine busy with other work
  endif()
  if(PLUMBLINE_SANITIZE)
    math(EXPR arg_TIMEOUT "${arg_TIMEOUT} * 10")
  endif()
  add_executable(${name} ${arg_SOURCES})
  plumbline_precompile(${name} tests ${PLUMBLINE_TEST_OPTION})
  target_compile_options(${name} PRIVATE ${PLUMBLINE_TEST_OPTION})
  target_link_libraries(${name} PRIVATE plumbline_test_support ${arg_LINKS} GTest::gtest GTest::gmock)
  if(TARGET plumbline_one_tbb_thread)
    target_link_libraries(${name} PRIVATE plumbline_one_tbb_thread)
  endif()
  if(NOT arg_LABEL STREQUAL "slow")
    add_dependencies(plumbline_quick_tests ${name})
  endif()
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES LABELS ${arg_LABEL} TIMEOUT ${arg_TIMEOUT}
    ENVIRONMENT "PLUMBLINE_SOURCE_DIR=${CMAKE_SOURCE_DIR};PLUMBLINE_BINARY=${CMAKE_BINARY_DIR}/bin/plumbline")
endfunction()

# plumbline_embed(TARGET VARIABLE file ...): embeds text or binary files as
# `std::string_view plumbline::embedded::Find(name)` entries of that target (name = path below the source tree).
function(plumbline_embed target)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/${target}_embedded.cc)
  add_custom_command(OUTPUT ${out}
    COMMAND ${CMAKE_COMMAND} -DOUT=${out} -DROOT=${CMAKE_SOURCE_DIR} -DNAME=${target} "-DFILES=${ARGN}"
            -P ${CMAKE_SOURCE_DIR}/cmake/Embed.cmake
    DEPENDS ${ARGN} ${CMAKE_SOURCE_DIR}/cmake/Embed.cmake VERBATIM)
  target_sources(${target} PRIVATE ${out})
endfunction()
