# Functions for the tests in this folder. Each test makes a project that uses sft_generate(), in a directory with a
# space in its name. A test gets WORK (an empty directory), GENERATOR, SFT_CMAKE_DIR, SFT_MSGC and SFT_IDL_PLUGIN.
cmake_minimum_required(VERSION 3.22)
set(source "${WORK}/a project")
set(build "${WORK}/its build")
set(generated "${build}/sft_generated")  # contains a folder for each target
file(REMOVE_RECURSE "${WORK}")

# Writes a file of the project.
function(write path text)
  file(WRITE "${source}/${path}" "${text}")
endfunction()

# Writes the project's CMakeLists.txt. `text` is the part that differs between tests.
function(write_project text)
  write(CMakeLists.txt "
    cmake_minimum_required(VERSION 3.22)
    project(user LANGUAGES NONE)
    add_executable(sft::sft_msgc IMPORTED)
    set_target_properties(sft::sft_msgc PROPERTIES IMPORTED_LOCATION \"${SFT_MSGC}\")
    add_library(sft::cycloneddsidlsft SHARED IMPORTED)
    set_target_properties(sft::cycloneddsidlsft PROPERTIES IMPORTED_LOCATION \"${SFT_IDL_PLUGIN}\")
    add_library(sft_typesupport INTERFACE)
    add_library(sft::typesupport ALIAS sft_typesupport)
    include(\"${SFT_CMAKE_DIR}/SftGenerate.cmake\")
    ${text}
  ")
endfunction()

macro(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE errors)
  # CMake wraps its messages, so line breaks become spaces.
  string(REGEX REPLACE "[ \n]+" " " said "${output} ${errors}")
endmacro()

macro(configure)
  run(${CMAKE_COMMAND} -S ${source} -B ${build} -G ${GENERATOR} ${ARGN})
endmacro()

macro(build_headers target)
  run(${CMAKE_COMMAND} --build ${build} --target ${target}_headers --parallel 2)
endmacro()

function(expect_success)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "failed: ${output}${errors}")
  endif()
endfunction()

function(expect_error text)
  string(FIND "${said}" "${text}" position)
  if(status EQUAL 0)
    message(FATAL_ERROR "succeeded; expected: ${text}")
  elseif(position EQUAL -1)
    message(FATAL_ERROR "expected: ${text}\ngot: ${output}${errors}")
  endif()
endfunction()

function(expect_generated target)
  configure()
  expect_success()
  build_headers(${target})
  expect_success()
  expect_headers(${target} ${ARGN})
endfunction()

# Expects that exactly these headers were generated, given as pkg/msg/Name.
function(expect_headers target)
  set(directory "${generated}/${target}")
  file(GLOB_RECURSE headers RELATIVE "${directory}" "${directory}/*.hpp")
  list(TRANSFORM headers REPLACE "\\.hpp$" "")
  list(SORT headers)
  set(expected ${ARGN})
  list(SORT expected)
  if(NOT "${headers}" STREQUAL "${expected}")
    message(FATAL_ERROR "expected: ${expected}\ngot: ${headers}")
  endif()
endfunction()

# Expects that the header `name`, generated for `target`, contains the text.
function(expect_in_header target name text)
  file(READ "${generated}/${target}/${name}.hpp" header)
  string(FIND "${header}" "${text}" position)
  if(position EQUAL -1)
    message(FATAL_ERROR "expected: ${text}\nin: ${header}")
  endif()
endfunction()

# Makes all present files ten seconds older. So files that are written afterwards have later time stamps.
function(let_time_pass)
  file(GLOB_RECURSE files "${WORK}/*")
  foreach(file IN LISTS files)
    list(APPEND stamps "${file}")
  endforeach()
  execute_process(COMMAND touch -d "-10 seconds" -- ${stamps})
endfunction()
