# cmake -D SOURCE=tree -D WORK=folder -D GENERATOR=name -D CXX=compiler -P without_tools.cmake
# Configures the tests as if the system had none of the programs that only some tests need. Each of these tests must be
# skipped under its own name, and the reason must name the missing program. All other tests must exist.
cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/verbs.cmake)

set(found_nowhere -D SFT_PYTHON= -D SFT_SPIN= -D SFT_TSHARK= -D SFT_DOXYGEN=)
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G ${GENERATOR} -D CMAKE_CXX_COMPILER=${CXX} ${found_nowhere})
expect("${output}" MATCHES "benchmarks are left out: they need python3-rosidl")

cmake_path(GET CMAKE_COMMAND PARENT_PATH programs)
function(expect_skipped test needs)
  run(${programs}/ctest --test-dir ${WORK}/build --verbose --tests-regex "^${test}$")
  string(REPLACE "." "[.]" line ${test})
  expect("${output}" MATCHES "skipped: needs ${needs}\n")
  expect("${output}" MATCHES "${line} [.]*[*]*Skipped")
endfunction()
expect_skipped(model_gates.network spin)
expect_skipped(documents.reference doxygen)
expect_skipped(documents.check python3)
expect_skipped(wireshark.dissector python3)
expect_skipped(python.messages "pybind11-dev, python3-numpy and python3-pytest")
expect_skipped(every_type_law_test "python3-rosidl and ros2-test-interface-files")
expect_skipped(ros_structs_test "rosidl-generator-c-cpp and libfastcdr-dev")
expect_skipped(documents.recipes_with_ros rosidl-generator-c-cpp)

run(${programs}/ctest --test-dir ${WORK}/build --show-only)
expect("${output}" MATCHES "core_test_not_built")
