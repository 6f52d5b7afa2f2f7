# SPDX-License-Identifier: Apache-2.0
# Headers that most files include and that rarely change are precompiled once for the rooms and once for the tests.
# Targets with CGAL are excluded: its rounding flags differ.
option(LIVEGS_PRECOMPILE "Precompile the headers of Eigen, GoogleTest and the standard library" ON)
set(LIVEGS_COMMON_HEADERS <Eigen/Core> <Eigen/Geometry> <Eigen/LU> <algorithm> <array> <atomic> <chrono> <cmath>
                          <condition_variable> <cstdint> <deque> <filesystem> <fstream> <functional> <map> <memory> <mutex>
                          <optional> <random> <set> <span> <sstream> <string> <thread> <unordered_map> <variant> <vector>)

# livegs_precompile(TARGET common|tests|hot_tests LIBRARIES...): uses the precompiled headers unless a library is CGAL's.
function(livegs_precompile target set)
  if(NOT LIVEGS_PRECOMPILE OR "${ARGN}" MATCHES "CGAL")
    return()
  endif()
  if(NOT TARGET livegs_headers_${set})
    find_package(Eigen3 REQUIRED NO_MODULE)
    set(source ${CMAKE_BINARY_DIR}/headers_${set}.cpp)
    file(CONFIGURE OUTPUT ${source} CONTENT "// Holds the precompiled headers only.\n")
    add_library(livegs_headers_${set} OBJECT ${source})
    target_link_libraries(livegs_headers_${set} PRIVATE Eigen3::Eigen)
    set(headers ${LIVEGS_COMMON_HEADERS})
    if(set MATCHES "tests")
      find_package(GTest REQUIRED)
      livegs_test_flags(livegs_headers_${set} ${set})
      target_link_libraries(livegs_headers_${set} PRIVATE GTest::gtest)
      list(APPEND headers <gtest/gtest.h>)
    endif()
    target_precompile_headers(livegs_headers_${set} PRIVATE ${headers})
  endif()
  target_precompile_headers(${target} REUSE_FROM livegs_headers_${set})
endfunction()

# Compiles several sources of a target as one unit, so that headers are parsed and templates instantiated once. OFF shortens
# the rebuild after an edit of one file.
option(LIVEGS_UNITY "Compile the sources of a target in batches" ON)
set(LIVEGS_UNITY_BATCH 24 CACHE STRING
    "Sources in a batch; more take less processor time, and up to 2 GB of memory for each process of the compiler")

# Test sources are compiled for a short build; the code under test is optimised in its own room. Those that compute much
# themselves (LIVEGS_HOT_TESTS of their folder, or the label nightly) are optimised a little.
set(LIVEGS_TEST_FLAGS "-O0;-g0" CACHE STRING "Compile options of test sources")
set(LIVEGS_HOT_TEST_FLAGS "-O1;-g0" CACHE STRING "Compile options of test sources that compute much themselves")

# livegs_test_flags(TARGET tests|hot_tests)
function(livegs_test_flags target set)
  if(set STREQUAL "hot_tests")
    target_compile_options(${target} PRIVATE ${LIVEGS_HOT_TEST_FLAGS})
  else()
    target_compile_options(${target} PRIVATE ${LIVEGS_TEST_FLAGS})
  endif()
endfunction()

# livegs_optimise_test(TARGET LIBRARIES...): adds the compile options and the precompiled headers of a test.
function(livegs_optimise_test target)
  set(set tests)
  if(LIVEGS_HOT_TESTS)
    set(set hot_tests)
  endif()
  livegs_test_flags(${target} ${set})
  livegs_precompile(${target} ${set} ${ARGN})
endfunction()

# Targets that are built only on request: `benches` and `nightly_tests`.
add_custom_target(benches)
add_custom_target(nightly_tests)

# livegs_unite(TARGET): compiles the target in batches. A source with its own compile options is compiled alone.
function(livegs_unite target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${LIVEGS_UNITY} UNITY_BUILD_BATCH_SIZE ${LIVEGS_UNITY_BATCH})
endfunction()

# livegs_add_room(NAME SOURCES ... [PUBLIC ...] [PRIVATE ...])
#   A room is one static library livegs_NAME with the alias livegs::NAME. Includes name the room ("skin/driver_frame.h");
#   the include folder is the parent of the room: common/, server/ or client/.
function(livegs_add_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(livegs_${name} STATIC ${ROOM_SOURCES})
  add_library(livegs::${name} ALIAS livegs_${name})
  target_include_directories(livegs_${name} PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/..)
  target_link_libraries(livegs_${name} PUBLIC ${ROOM_PUBLIC} PRIVATE livegs::options ${ROOM_PRIVATE})
  livegs_precompile(livegs_${name} common ${ROOM_PRIVATE})
  livegs_unite(livegs_${name})
endfunction()

# livegs_linked_rooms(RESULT LIBRARIES...): the static libraries of this project that LIBRARIES contain or link, directly or not.
function(livegs_linked_rooms result)
  set(rooms)
  while(ARGN)
    list(POP_FRONT ARGN library)
    if(NOT TARGET ${library})
      continue()
    endif()
    get_target_property(alias ${library} ALIASED_TARGET)
    if(alias)
      set(library ${alias})
    endif()
    get_target_property(imported ${library} IMPORTED)
    get_target_property(type ${library} TYPE)
    if(imported OR NOT type STREQUAL "STATIC_LIBRARY" OR library IN_LIST rooms)
      continue()
    endif()
    list(APPEND rooms ${library})
    get_target_property(linked ${library} LINK_LIBRARIES)
    if(linked)
      list(APPEND ARGN ${linked})
    endif()
  endwhile()
  set(${result} ${rooms} PARENT_SCOPE)
endfunction()

# livegs_add_test_support(NAME SOURCES ... LINK ...): a static library of sources that several test programs share.
function(livegs_add_test_support name)
  cmake_parse_arguments(TEST "" "" "SOURCES;LINK" ${ARGN})
  add_library(${name} STATIC EXCLUDE_FROM_ALL ${TEST_SOURCES})
  target_link_libraries(${name} PUBLIC ${TEST_LINK} PRIVATE livegs::options)
  target_include_directories(${name} PUBLIC ${CMAKE_SOURCE_DIR}/tests)
  livegs_optimise_test(${name} ${TEST_LINK})
  livegs_unite(${name})
endfunction()

# livegs_add_test_program(NAME SOURCES ... LINK ...): a GoogleTest program without a ctest entry.
function(livegs_add_test_program name)
  cmake_parse_arguments(TEST "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${TEST_SOURCES})
  target_link_libraries(${name} PRIVATE livegs::options ${TEST_LINK} GTest::gtest_main)
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
  target_compile_definitions(${name} PRIVATE LIVEGS_SHARED_DATA_DIR="${CMAKE_SOURCE_DIR}/../shared/data"
                                             LIVEGS_TESTS_DIR="${CMAKE_SOURCE_DIR}/tests")
  # Rooms and tests instantiate the same templates, for example of JSON, and the linker keeps the first copy. The rooms'
  # objects stand first, so that a test runs the optimised copies, as the programs do.
  livegs_linked_rooms(rooms ${TEST_LINK})
  if(rooms)
    list(TRANSFORM rooms REPLACE "(.+)" "$<TARGET_FILE:\\1>")
    list(JOIN rooms " " rooms)
    target_link_options(${name} PRIVATE "SHELL:-Wl,--whole-archive ${rooms} -Wl,--no-whole-archive")
  endif()
  livegs_optimise_test(${name} ${TEST_LINK})
  livegs_unite(${name})
endfunction()

# livegs_add_test(NAME SOURCES ... LINK ... [LABELS ...] [TIMEOUT seconds] [SHARDS count] [SERIAL] [EACH] [WAITS] [HOT])
#   One GoogleTest program with one ctest entry per shard (SHARDS, 2 by default), so that data, tables and devices are loaded
#   once. The times of its TESTs go to test_times/ in the build tree.
#   EACH: one ctest entry per TEST, for tests of whole programs.
#   SERIAL: no other test runs at the same time.
#   WAITS: mostly waits for timers and sockets. Such a test takes one of the slots of `ctest --parallel`, another one two;
#   deploy/test has two slots for each core, and one more. ctest starts tests of a higher COST first, so that while tests of
#   two slots are left, they keep the cores busy and one test that waits runs next to them.
#   HOT: compiled with LIVEGS_HOT_TEST_FLAGS.
#   LABELS nightly: neither built nor run by default. TIMEOUT: 900 s by default, 300 s with EACH.
function(livegs_add_test name)
  cmake_parse_arguments(TEST "SERIAL;EACH;WAITS;HOT" "TIMEOUT;SHARDS" "SOURCES;LINK;LABELS" ${ARGN})
  if(NOT TEST_LABELS)
    set(TEST_LABELS unit)
  endif()
  if(TEST_HOT OR "nightly" IN_LIST TEST_LABELS)
    set(LIVEGS_HOT_TESTS ON)
  endif()
  livegs_add_test_program(${name} SOURCES ${TEST_SOURCES} LINK ${TEST_LINK})
  if("nightly" IN_LIST TEST_LABELS)
    set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL ON)
    add_dependencies(nightly_tests ${name})
  endif()
  set(slots 2)
  if(TEST_WAITS)
    set(slots 1)
  endif()
  set(run RUN_SERIAL ${TEST_SERIAL} PROCESSORS ${slots} COST ${slots})
  set(environment)
  if(LIVEGS_SANITIZE MATCHES address AND TEST_LABELS MATCHES vulkan)
    # Vulkan drivers and layers keep memory until the process ends; the leaks are not in our code.
    set(environment ASAN_OPTIONS=detect_leaks=0)
  endif()
  if(TEST_EACH)
    if(NOT TEST_TIMEOUT)
      set(TEST_TIMEOUT 300)
    endif()
    # Several labels are one list property; GoogleTest.cmake of CMake 3.25 expands its semicolons several times.
    string(REPEAT "\\" 7 escapes)
    string(REPLACE ";" "${escapes};" TEST_LABELS "${TEST_LABELS}")
    if(environment)
      set(environment ENVIRONMENT ${environment})
    endif()
    gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST
                         PROPERTIES LABELS "${TEST_LABELS}" TIMEOUT ${TEST_TIMEOUT} ${run} ${environment})
    return()
  endif()
  if(NOT TEST_TIMEOUT)
    set(TEST_TIMEOUT 900)
  endif()
  if(NOT TEST_SHARDS)
    set(TEST_SHARDS 2)
  endif()
  foreach(shard RANGE 1 ${TEST_SHARDS})
    math(EXPR index "${shard} - 1")
    set(entry ${name})
    if(TEST_SHARDS GREATER 1)
      set(entry ${name}.${shard})
    endif()
    add_test(NAME ${entry} COMMAND ${name})
    set_tests_properties(${entry} PROPERTIES
      LABELS "${TEST_LABELS}" TIMEOUT ${TEST_TIMEOUT} ${run}
      ENVIRONMENT "GTEST_TOTAL_SHARDS=${TEST_SHARDS};GTEST_SHARD_INDEX=${index};GTEST_OUTPUT=xml:${CMAKE_BINARY_DIR}/test_times/${entry}.xml;${environment}")
  endforeach()
endfunction()

# livegs_add_second_device(NAME FILTER)
#   Repeats the tests that match FILTER on SwiftShader (Debian package chromium-common), nightly. Unlike lavapipe, SwiftShader
#   draws both eyes at once, as a GPU does, and rounds 16-bit floats to nearest. Skipped with a message if not installed.
set(LIVEGS_SWIFTSHADER_ICD /usr/lib/chromium/vk_swiftshader_icd.json)
function(livegs_add_second_device name filter)
  add_test(NAME SwiftShader.${name}
           COMMAND sh -c "test -f ${LIVEGS_SWIFTSHADER_ICD} || { echo 'SwiftShader: not installed; run apt-get install chromium-common'; exit 77; }; \
                          exec $<TARGET_FILE:${name}> --gtest_filter='${filter}'")
  set_tests_properties(SwiftShader.${name} PROPERTIES
                       LABELS "parity;vulkan;nightly" TIMEOUT 900 SKIP_RETURN_CODE 77 FAIL_REGULAR_EXPRESSION "multiview draws wrong;vulkan: none of;vulkan: no loader;vulkan: no driver"
                       ENVIRONMENT "VK_ICD_FILENAMES=${LIVEGS_SWIFTSHADER_ICD};ASAN_OPTIONS=detect_leaks=0")
endfunction()

# livegs_add_bench(NAME SOURCES ... LINK ...)
#   A program that the target `benches` builds and that is run by hand; its CSV goes to tests/bench/results.
function(livegs_add_bench name)
  cmake_parse_arguments(BENCH "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} EXCLUDE_FROM_ALL ${BENCH_SOURCES})
  add_dependencies(benches ${name})
  target_link_libraries(${name} PRIVATE livegs::options ${BENCH_LINK})
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
  target_compile_definitions(${name} PRIVATE LIVEGS_SHARED_DATA_DIR="${CMAKE_SOURCE_DIR}/../shared/data"
                                             LIVEGS_TESTS_DIR="${CMAKE_SOURCE_DIR}/tests")
endfunction()

# livegs_embed_text(TARGET FILE CONSTANT)
#   Generates NAME.h in the build tree with the text of FILE as the constant CONSTANT. NAME is the file name without folders.
function(livegs_embed_text target file constant)
  cmake_path(GET file FILENAME name)
  set(header ${CMAKE_CURRENT_BINARY_DIR}/embedded/${name}.h)
  add_custom_command(OUTPUT ${header}
    COMMAND ${CMAKE_COMMAND} -DINPUT=${CMAKE_CURRENT_SOURCE_DIR}/${file} -DOUTPUT=${header} -DNAME=${constant}
            -P ${CMAKE_SOURCE_DIR}/deploy/cmake/embed_text.cmake
    DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${file} ${CMAKE_SOURCE_DIR}/deploy/cmake/embed_text.cmake
    VERBATIM)
  target_sources(${target} PRIVATE ${header})
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/embedded)
endfunction()

# livegs_add_shader(TARGET NAME STAGE)
#   Compiles NAME.STAGE.glsl (comp, vert or frag; NAME may have folders) to SPIR-V in the build tree. BASE.spv.h, or
#   BASE_STAGE.spv.h for vert and frag, holds it as the array BASE[_STAGE]_spirv; BASE is the last part of NAME. Includes in
#   shaders name the room, as in C++.
function(livegs_add_shader target name stage)
  find_program(LIVEGS_GLSLANG glslangValidator REQUIRED)
  set(source ${CMAKE_CURRENT_SOURCE_DIR}/${name}.${stage}.glsl)
  cmake_path(GET name FILENAME name)
  if(NOT stage STREQUAL "comp")
    string(APPEND name _${stage})
  endif()
  set(header ${CMAKE_CURRENT_BINARY_DIR}/passes/${name}.spv.h)
  file(MAKE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/passes)
  add_custom_command(OUTPUT ${header}
    COMMAND ${LIVEGS_GLSLANG} --quiet --target-env vulkan1.3 -S ${stage} -I${CMAKE_CURRENT_SOURCE_DIR}/..
            -I${CMAKE_SOURCE_DIR}/common --vn ${name}_spirv --depfile ${header}.d -o ${header} ${source}
    DEPENDS ${source}
    DEPFILE ${header}.d
    VERBATIM)
  target_sources(${target} PRIVATE ${header})
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/passes)
  set_property(GLOBAL APPEND_STRING PROPERTY LIVEGS_SHADER_HEADERS "${header}\n")  # read by shader_modules_test
endfunction()

# livegs_add_pass(TARGET NAME): adds the compute shader of a pass.
function(livegs_add_pass target name)
  livegs_add_shader(${target} ${name} comp)
endfunction()
