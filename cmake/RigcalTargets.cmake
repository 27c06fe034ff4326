# One function for each kind of target, so that every room is built by the same rules.

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(RIGCAL_CCACHE ccache)
if(RIGCAL_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # Without this it keeps nothing that was compiled with precompiled headers.
  set(CMAKE_CXX_COMPILER_LAUNCHER
    "${CMAKE_COMMAND};-E;env;CCACHE_SLOPPINESS=pch_defines,time_macros;${RIGCAL_CCACHE}")
endif()

include(GNUInstallDirs)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")

# Another compiler may warn of what is right: it must not keep anybody from building.
set(rigcal_tried_compilers "GNU 12" "GNU 14" "Clang 14")
string(REGEX MATCH "^[0-9]+" rigcal_compiler_version "${CMAKE_CXX_COMPILER_VERSION}")
set(rigcal_tries_compiler OFF)
if("${CMAKE_CXX_COMPILER_ID} ${rigcal_compiler_version}" IN_LIST rigcal_tried_compilers)
  set(rigcal_tries_compiler ON)
endif()
option(RIGCAL_WERROR "Take warnings for errors; by default with compilers that are tried" ${rigcal_tries_compiler})

add_library(rigcal_rules INTERFACE)
target_compile_features(rigcal_rules INTERFACE cxx_std_20)
target_include_directories(rigcal_rules INTERFACE "$<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}>")
target_compile_options(rigcal_rules INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Woverloaded-virtual
  # Not of sources that a later GCC reads as one: what it sees across them is not so, or is seen in each file, too.
  $<$<AND:$<BOOL:${RIGCAL_WERROR}>,$<NOT:$<AND:$<BOOL:$<TARGET_PROPERTY:UNITY_BUILD>>,$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,13>>>>:-Werror>
  # GCC 12 and 13 see overlaps in "text" + std::string that are not there (GCC bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  # The same sums on every processor of a kind: no fusing of multiply and add behind our back (Eigen's own code for
  # arm64 fuses them all the same).
  -ffp-contract=off
  # GCC sweeps its memory over and over from 128 MB on, a tenth of its time; most sources take more in any case.
  $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=800000>
  # Nobody asks errno about a square root: without it loops with roots are done for many numbers at once.
  -fno-math-errno)
# Debug builds check what the standard library can check of itself: indices, empty containers.
target_compile_definitions(rigcal_rules INTERFACE $<$<CONFIG:Debug>:_GLIBCXX_ASSERTIONS>)
if(RIGCAL_SANITIZE)
  # What a sanitizer puts between hides from GCC that Eigen's matrices are written before they are read.
  target_compile_options(rigcal_rules INTERFACE
    -fsanitize=${RIGCAL_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(rigcal_rules INTERFACE -fsanitize=${RIGCAL_SANITIZE})
endif()
if(RIGCAL_BUILD_FUZZ)
  target_compile_options(rigcal_rules INTERFACE -fsanitize=fuzzer-no-link)
endif()
set_target_properties(rigcal_rules PROPERTIES POSITION_INDEPENDENT_CODE ON)

# What many sources of a kind include, read once for all of them: a quarter of the time that they take to compile. Each file
# says itself what it needs all the same; RIGCAL_PRECOMPILE=OFF shows where one does not.
function(rigcal_precompile target)
  if(RIGCAL_PRECOMPILE)
    rigcal_allow_precompiled(${target})
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

function(rigcal_use_precompiled target headers)
  # GLib's flags define what those of the precompiled headers do not.
  get_target_property(dependencies ${target} LINK_LIBRARIES)
  if(RIGCAL_PRECOMPILE AND NOT "Aravis::Aravis" IN_LIST dependencies)
    rigcal_allow_precompiled(${target})
    target_precompile_headers(${target} REUSE_FROM ${headers})
  endif()
endfunction()

# With precompiled headers GCC 12 warns of what is not so; and ccache has to see which of them were used.
function(rigcal_allow_precompiled target)
  target_compile_options(${target} PRIVATE
    "$<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess;-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread>")
endfunction()

add_library(rigcal_headers OBJECT cmake/precompiled_headers.cpp)
target_link_libraries(rigcal_headers PRIVATE rigcal_rules Eigen3::Eigen)
rigcal_precompile(rigcal_headers
  <Eigen/Core> <algorithm> <array> <cmath> <cstdint> <functional> <map> <memory> <optional> <span> <string> <string_view>
  <utility> <vector>)

# Sources of a target as one, sixteen at a time: what they share of templates and headers is compiled once (decision 006).
# Not those given behind it: they have private names that their neighbours have, too. It is tried with GCC, whose warning of
# what is private to an included file means nothing here; GCC 14 takes optional values in joined files for unset ones.
function(rigcal_join_sources target)
  if(RIGCAL_JOIN_SOURCES AND RIGCAL_PRECOMPILE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 16)
    set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
    if(CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13)
      target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized)
    endif()
  endif()
endfunction()

# rigcal_add_library(core_voxel SOURCES a.cpp ALONE b.cpp DEPS core_records PRIVATE_DEPS yaml-cpp)
# A room: DEPS are rooms it includes in its headers, PRIVATE_DEPS what only its .cpp files see. ALONE are sources that
# are not compiled as one with others.
function(rigcal_add_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;ALONE;DEPS;PRIVATE_DEPS" ${ARGN})
  add_library(rigcal_${name} STATIC ${ARG_SOURCES} ${ARG_ALONE})
  add_library(rigcal::${name} ALIAS rigcal_${name})
  set_target_properties(rigcal_${name} PROPERTIES EXPORT_NAME ${name})
  list(TRANSFORM ARG_DEPS PREPEND "rigcal::")
  target_link_libraries(rigcal_${name} PUBLIC ${ARG_DEPS} PRIVATE $<BUILD_INTERFACE:rigcal_rules> ${ARG_PRIVATE_DEPS})
  target_compile_features(rigcal_${name} PUBLIC cxx_std_20)
  rigcal_use_precompiled(rigcal_${name} rigcal_headers)
  rigcal_join_sources(rigcal_${name} ${ARG_ALONE})
  target_include_directories(rigcal_${name} PUBLIC
    "$<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}>" "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/rigcal>")
  install(TARGETS rigcal_${name} EXPORT rigcal
    ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}/rigcal" COMPONENT dev)
endfunction()

# What is tested is optimised as it is shipped; the tests themselves are half of the build.
function(rigcal_set_test_options target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# rigcal_add_test(core_voxel SOURCES voxel_map_test.cpp ALONE other_test.cpp DEPS core_voxel [LABELS slow])
# One GoogleTest program a room; every test case becomes a CTest test of its own, or with WHOLE the program is one: for
# cases that share something that takes long to make. LOCK names what no two tests may use at a time. COST: those of more
# begin earlier, as CTest has it. PROGRAM: they run rigcal itself, by the path RIGCAL_PROGRAM.
function(rigcal_add_test name)
  if(NOT RIGCAL_BUILD_TESTS)
    return()
  endif()
  cmake_parse_arguments(ARG "WHOLE;PROGRAM" "TIMEOUT;LOCK;COST" "SOURCES;ALONE;DEPS;PRIVATE_DEPS;LABELS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  add_executable(${name}_test ${ARG_SOURCES} ${ARG_ALONE})
  list(TRANSFORM ARG_DEPS PREPEND "rigcal::")
  target_link_libraries(${name}_test PRIVATE rigcal_rules rigcal_test_support ${ARG_DEPS} ${ARG_PRIVATE_DEPS}
                        GTest::gmock GTest::gtest_main)
  rigcal_set_test_options(${name}_test)
  rigcal_use_precompiled(${name}_test rigcal_test_headers)
  rigcal_join_sources(${name}_test ${ARG_ALONE})
  if(ARG_PROGRAM)
    target_compile_definitions(${name}_test PRIVATE RIGCAL_PROGRAM="$<TARGET_FILE:rigcal>")
    add_dependencies(${name}_test rigcal)
  endif()
  set(properties TIMEOUT ${ARG_TIMEOUT})
  if(ARG_LABELS)
    list(APPEND properties LABELS "${ARG_LABELS}")
  endif()
  if(ARG_LOCK)
    list(APPEND properties RESOURCE_LOCK "${ARG_LOCK}")
  endif()
  if(ARG_COST)
    list(APPEND properties COST ${ARG_COST})
  endif()
  if(ARG_WHOLE)
    add_test(NAME ${name} COMMAND ${name}_test)
    # Where every case skips, the program has skipped and not passed. Failures would be told after the skipped ones: what
    # matches is taken for skipped whatever else there is.
    set(all_skipped "\\[  PASSED  \\] 0 tests\\.\n\\[  SKIPPED \\] [0-9]+ tests?, listed below:\n")
    set_tests_properties(${name} PROPERTIES ${properties}
      SKIP_REGULAR_EXPRESSION "${all_skipped}(\\[  SKIPPED \\] [^\n]*\n)+$")
    return()
  endif()
  gtest_discover_tests(${name}_test TEST_PREFIX "${name}." DISCOVERY_TIMEOUT 60 PROPERTIES ${properties})
endfunction()

# rigcal_add_bench(codec SOURCES codec_bench.cpp DEPS drivers_livox_codec): Google Benchmark, run by hand.
function(rigcal_add_bench name)
  if(NOT RIGCAL_BUILD_BENCH)
    return()
  endif()
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${name}_bench ${ARG_SOURCES})
  list(TRANSFORM ARG_DEPS PREPEND "rigcal::")
  target_link_libraries(${name}_bench PRIVATE rigcal_rules ${ARG_DEPS} benchmark::benchmark_main)
  rigcal_use_precompiled(${name}_bench rigcal_headers)
endfunction()

# rigcal_add_fuzz(codec SOURCES codec_fuzz.cpp DEPS drivers_livox_codec): a libFuzzer target.
function(rigcal_add_fuzz name)
  if(NOT RIGCAL_BUILD_FUZZ)
    return()
  endif()
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${name}_fuzz ${ARG_SOURCES})
  list(TRANSFORM ARG_DEPS PREPEND "rigcal::")
  target_link_libraries(${name}_fuzz PRIVATE rigcal_rules ${ARG_DEPS})
  target_link_options(${name}_fuzz PRIVATE -fsanitize=fuzzer)
endfunction()
