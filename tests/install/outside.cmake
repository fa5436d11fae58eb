# cmake -D SOURCE=tree -D BUILD=tree -D WORK=folder -D GENERATOR=name -D CXX=compiler -D ISOLATE=program -P
# outside.cmake
# Installs SFT from its build into a folder, and moves that folder. Builds a project and a program of one file with the
# SFT in the moved folder, and runs both on an isolated host. "Five minutes" of docs/guide.md is executed there, too, as
# it is printed.
cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/verbs.cmake)
set(prefix ${WORK}/prefix)

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/installed --strip)
file(RENAME ${WORK}/installed ${prefix})
# No installed text file may contain the paths of these folders. Programs may contain them: the paths of sources are in
# their messages, and the path of the daemon is one of several.
foreach(place IN ITEMS ${WORK}/installed ${BUILD} ${SOURCE})
  execute_process(COMMAND grep --recursive --files-with-matches --binary-files=without-match --fixed-strings
      ${place} ${prefix} OUTPUT_VARIABLE output)
  expect("${output}" STREQUAL "")
endforeach()
file(READ_SYMLINK ${prefix}/bin/sftd daemon_in_path)
expect("${daemon_in_path}" STREQUAL ../libexec/sft/sftd)
run(${prefix}/bin/sftd --help)
file(GLOB_RECURSE headers RELATIVE ${prefix}/include ${prefix}/include/*.h)
list(FILTER headers EXCLUDE REGEX "^sft/(detail/)?[a-z0-9_]+[.]h$")
expect("${headers}" STREQUAL "")

run(${prefix}/bin/sft --version)
expect("${output}" MATCHES "^sft [0-9.]+")

run(${CMAKE_COMMAND} -S ${SOURCE}/examples/outside -B ${WORK}/build -G ${GENERATOR} -D CMAKE_PREFIX_PATH=${prefix}
    -D CMAKE_CXX_COMPILER=${CXX} "-D CMAKE_CXX_FLAGS=-Wall -Wextra -Wpedantic -Werror")
run(${CMAKE_COMMAND} --build ${WORK}/build)

file(GLOB package_folder ${prefix}/lib*/pkgconfig ${prefix}/lib/*/pkgconfig)
find_program(PKG_CONFIG NAMES pkg-config pkgconf REQUIRED)
run(${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${package_folder} ${PKG_CONFIG} --cflags --libs sft)
separate_arguments(flags UNIX_COMMAND "${output}")
cmake_path(GET package_folder PARENT_PATH library_folder)
run(${CXX} -std=c++20 ${CMAKE_CURRENT_LIST_DIR}/one_file.cpp ${flags} -Wl,-rpath,${library_folder} -o ${WORK}/one_file)

set(five_minutes ${WORK}/five_minutes)
file(MAKE_DIRECTORY ${five_minutes})
run(awk -v "heading=Five minutes" -v folder=${five_minutes}
    -f ${SOURCE}/tests/documents/code_blocks.awk ${SOURCE}/docs/guide.md)

# The isolated host hides /tmp, but not the folder of this program, even if that folder is below /tmp.
file(COPY ${ISOLATE} ${CMAKE_CURRENT_LIST_DIR}/run_outside.sh DESTINATION ${WORK})
cmake_path(GET ISOLATE FILENAME isolate)
run(${CMAKE_COMMAND} -E env CXX=${CXX} CMAKE_GENERATOR=${GENERATOR}
    ${WORK}/${isolate} /bin/sh ${WORK}/run_outside.sh ${prefix} ${WORK}/build ${WORK}/one_file ${five_minutes})
set(daemon ${prefix}/libexec/sft/sftd)
set(sent "monitor is sent {serial, charge} by")
set(printed "battery B-17: [0-9.]+ %")
expect("${output}" MATCHES "it says: hello")
expect("${output}" MATCHES "the command\nnumbers: 1 sample of std_msgs/msg/UInt32; 0 subscribers now\n")
expect("${output}" MATCHES "the daemon in the prefix.*${sent} shm.*${printed}.*daemon: ${daemon}\n")
expect("${output}" MATCHES
  "no daemon.*sftd could not be started: it is neither .* nor ${daemon} nor .* in PATH; install")
expect("${output}" MATCHES "no daemon.*${sent} udp.*${printed}.*environment names.*${sent} shm.*${printed}")
expect("${output}" MATCHES "five minutes.*monitor: 128 x 1024 points")
expect("${output}" MATCHES "five minutes.*nanosec: [0-9]+\nwidth: 1024\n")
expect("${output}" MATCHES "five minutes.*monitor.*shm.*height, width")
