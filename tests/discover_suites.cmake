# cmake -D PROGRAM=file -D LABELS=label [-D LEFT_OUT=file] -D OUTPUT=file -P discover_suites.cmake
# Writes, for CTest, one test for each suite of a GoogleTest program, because most tests take less time than the start
# of a process. A suite counts as skipped if some of its tests were skipped and none has failed: then the output ends
# with their names. Each line of LEFT_OUT that is no comment names a test that the suites omit.
cmake_minimum_required(VERSION 3.22)
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "(^|\n)[^ \n]+\\.( |\n)" suites "${listed}") # the tests of a suite are indented

set(left_out)
if(LEFT_OUT)
  file(STRINGS ${LEFT_OUT} left_out REGEX "^[^#]")
endif()
set(tests "")
foreach(suite IN LISTS suites)
  string(REGEX REPLACE "[ \n]|\\.[ \n]*$" "" suite "${suite}")
  set(filter "${suite}.*")
  set(sign "-")
  foreach(name IN LISTS left_out)
    if(name MATCHES "^${suite}\\.")
      string(APPEND filter "${sign}${name}")
      set(sign ":")
    endif()
  endforeach()
  string(APPEND tests "add_test([[${suite}]] [[${PROGRAM}]] [[--gtest_filter=${filter}]])\n"
                      "set_tests_properties([[${suite}]] PROPERTIES LABELS ${LABELS} "
                      "SKIP_REGULAR_EXPRESSION [=[\\[  SKIPPED \\] [^ \n]+[ \n]*$]=])\n")
endforeach()
file(WRITE ${OUTPUT} "${tests}")
