# SPDX-License-Identifier: Apache-2.0
# cmake -DSOURCE=... -DBUILD=... -P build_fuzz.cmake: configures and builds the fuzz targets there with clang.
find_program(clang NAMES clang++-19)
if(NOT clang)
  message(FATAL_ERROR "clang++-19: not installed; deploy/install-dependencies installs it")
endif()
execute_process(COMMAND ${CMAKE_COMMAND} --preset fuzz -B ${BUILD} WORKING_DIRECTORY ${SOURCE} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${BUILD} COMMAND_ERROR_IS_FATAL ANY)
