# Programs that tests need in addition to a compiler and libraries. If one of them is missing, its tests are skipped by
# name.
find_program(SFT_PYTHON python3 HINTS /usr/bin)  # Debian's own python3 finds Debian's rosidl
find_program(SFT_TSHARK tshark)
find_program(SFT_SPIN spin)
find_program(SFT_DOXYGEN doxygen)
find_program(SFT_GIT git)

# ROS 2's own compiler of messages, and the messages with which ROS 2 tests it. The types of tests and benchmarks are
# made with this compiler and these messages.
set(SFT_ROSIDL OFF)
if(SFT_PYTHON AND EXISTS /usr/share/test_interface_files/msg)
  execute_process(COMMAND ${SFT_PYTHON} -c "import rosidl_adapter.parser, em"
    RESULT_VARIABLE imported OUTPUT_QUIET ERROR_QUIET)
  if(imported EQUAL 0)
    set(SFT_ROSIDL ON)
  endif()
endif()
# ROS 2's generators of C++, and the libraries that generated code needs.
set(SFT_ROSIDL_CPP OFF)
find_library(ROSIDL_INTROSPECTION_LIBRARY rosidl_typesupport_introspection_cpp)
find_library(ROSIDL_RUNTIME_LIBRARY rosidl_runtime_c)
if(SFT_ROSIDL AND ROSIDL_INTROSPECTION_LIBRARY AND ROSIDL_RUNTIME_LIBRARY)
  execute_process(COMMAND ${SFT_PYTHON} -c "import rosidl_generator_cpp, rosidl_typesupport_introspection_cpp"
    RESULT_VARIABLE imported OUTPUT_QUIET ERROR_QUIET)
  if(imported EQUAL 0 AND EXISTS /usr/share/rosidl_generator_cpp/resource)
    set(SFT_ROSIDL_CPP ON)
  endif()
endif()
if(SFT_BUILD_BENCH AND NOT SFT_ROSIDL)
  message(STATUS "The benchmarks are left out: they need python3-rosidl and ros2-test-interface-files")
  set(SFT_BUILD_BENCH OFF)
endif()

# sft_tool_test(NAME NEEDS program... COMMAND word... [WORKING_DIRECTORY folder]): adds a test that needs programs which
# may be missing.
function(sft_tool_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "WORKING_DIRECTORY" "NEEDS;COMMAND")
  foreach(program IN LISTS arg_NEEDS)
    string(TOUPPER ${program} variable)
    string(REPLACE "PYTHON3" "PYTHON" variable ${variable})
    if(NOT SFT_${variable})
      sft_skipped_test(${name} ${program})
      return()
    endif()
  endforeach()
  if(NOT arg_WORKING_DIRECTORY)
    set(arg_WORKING_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
  endif()
  add_test(NAME ${name} COMMAND ${arg_COMMAND} WORKING_DIRECTORY ${arg_WORKING_DIRECTORY})
endfunction()

# sft_skipped_test(NAME WORD...): adds a skipped test in place of a test, or of a program's tests. WORD... names what
# the skipped tests need.
function(sft_skipped_test name)
  list(JOIN ARGN " " needs)
  add_test(NAME ${name} COMMAND sh -c "echo 'skipped: needs ${needs}'; exit 77")
  set_tests_properties(${name} PROPERTIES SKIP_RETURN_CODE 77)
endfunction()

# sft_skip_without_rosidl(PROGRAM...): adds skipped tests in place of the tests of the programs, which are not built
# without SFT_ROSIDL.
function(sft_skip_without_rosidl)
  foreach(program IN LISTS ARGN)
    sft_skipped_test(${program} python3-rosidl and ros2-test-interface-files)
  endforeach()
endfunction()
