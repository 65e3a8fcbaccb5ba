# SPDX-License-Identifier: MPL-2.0
# Writes a header with the commit of the source and its date, if they changed since the last build.
# cmake -D SOURCE=folder -D HEADER=file -P commit.cmake
set(commit unknown)
set(date unknown)
set(changed "")
find_package(Git QUIET)
if(EXISTS ${SOURCE}/.git AND Git_FOUND)
  execute_process(COMMAND ${GIT_EXECUTABLE} -c safe.directory=* -C ${SOURCE} log -1 "--format=%h %cs"
                  OUTPUT_VARIABLE found ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
  execute_process(COMMAND ${GIT_EXECUTABLE} -c safe.directory=* -C ${SOURCE} diff --quiet HEAD
                  RESULT_VARIABLE differs ERROR_QUIET)
  if(differs EQUAL 1)
    set(changed ", with local changes")
  endif()
else()  # git archive fills this file in
  file(STRINGS ${SOURCE}/cmake/commit.txt found LIMIT_COUNT 1)
endif()
if(found MATCHES "^([0-9a-f]+) ([-0-9]+)$")
  set(commit ${CMAKE_MATCH_1})
  set(date ${CMAKE_MATCH_2})
endif()
file(CONFIGURE OUTPUT ${HEADER} CONTENT [[
// The commit of the source, by cmake/commit.cmake.
#define BATTEN_COMMIT "@commit@"
#define BATTEN_COMMIT_DATE "@date@@changed@"
]] @ONLY)
