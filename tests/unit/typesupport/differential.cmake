# Compares SFT's types with Cyclone DDS's types of the same IDL files. These are the IDL files of this folder and of
# tests/generators/idl, and those that ROS 2's own tool makes of the common packages and of ROS 2's test messages.
find_package(CycloneDDS REQUIRED)

file(GLOB ros_packages LIST_DIRECTORIES true ${PROJECT_SOURCE_DIR}/typesupport/interfaces/*_*)
list(APPEND ros_packages /usr/share/test_interface_files)
set(ros_idl_dir ${CMAKE_CURRENT_BINARY_DIR}/ros_idl)
set(ros_msg)
set(ros_idl)
foreach(package IN LISTS ros_packages)
  cmake_path(GET package PARENT_PATH root)
  file(GLOB messages CONFIGURE_DEPENDS RELATIVE ${root} ${package}/msg/*.msg ${package}/srv/*.srv)
  if(NOT messages)
    message(FATAL_ERROR "There are no messages in ${package}/msg; .ci/packages lists what the tests need")
  endif()
  # idlc has no wide strings, and ROS 2's tool declares the arrays of a service twice, which is no IDL.
  list(FILTER messages EXCLUDE REGEX /msg/WStrings[.]msg$|/srv/Arrays[.]srv$)
  list(TRANSFORM messages REPLACE "(.*)[.](msg|srv)$" "${ros_idl_dir}/\\1.idl" OUTPUT_VARIABLE idl)
  list(TRANSFORM messages PREPEND ${root}/)
  list(APPEND ros_msg ${messages})
  list(APPEND ros_idl ${idl})
endforeach()
add_custom_command(
  OUTPUT ${ros_idl}
  COMMAND sh ${support}/quietly.sh ${SFT_PYTHON} ${support}/ros_idl.py ${ros_idl_dir} ${ros_msg}
  DEPENDS ${support}/ros_idl.py ${ros_msg}
  COMMENT "Converting ROS 2 messages to IDL"
  VERBATIM)
sft_generate(TARGET sft_ros_idl_interfaces FILES ${ros_idl} BASE_DIR ${ros_idl_dir})

# C types of all IDL files. The output of idlc is hidden, because idlc prints for each member that its C has no default
# values.
set(cyclone_dir ${CMAKE_CURRENT_BINARY_DIR}/cyclone)
set(cyclone_c)
function(cyclone_types base_dir)
  foreach(file IN LISTS ARGN)
    cmake_path(ABSOLUTE_PATH file NORMALIZE)
    cmake_path(RELATIVE_PATH file BASE_DIRECTORY ${base_dir} OUTPUT_VARIABLE name)
    string(REGEX REPLACE "[.]idl$" "" name ${name})
    add_custom_command(
      OUTPUT ${cyclone_dir}/${name}.c ${cyclone_dir}/${name}.h
      COMMAND sh ${support}/quietly.sh sh ${sft_run_idlc} ${cyclone_dir}/${name}.c ${SFT_IDLC} -l c -t
              -f case-sensitive -Wno-unsupported-annotations -Wno-implicit-extensibility
              -I${CMAKE_CURRENT_SOURCE_DIR} -I${PROJECT_SOURCE_DIR}/tests/generators/idl -I${ros_idl_dir}
              -b ${base_dir} -o ${cyclone_dir} ${file}
      DEPENDS ${file} ${ros_idl} ${PROJECT_SOURCE_DIR}/tests/generators/idl/torture_base.idl ${sft_run_idlc}
      COMMENT "Generating ${name}.c"
      VERBATIM)
    list(APPEND cyclone_c ${cyclone_dir}/${name}.c)
  endforeach()
  set(cyclone_c ${cyclone_c} PARENT_SCOPE)
endfunction()
set(sft_run_idlc ${PROJECT_SOURCE_DIR}/typesupport/cmake/run_idlc.sh)
cyclone_types(${ros_idl_dir} ${ros_idl})
cyclone_types(${CMAKE_CURRENT_SOURCE_DIR} foreign.idl layouts.idl proof.idl)
file(GLOB unguarded_idl ${PROJECT_SOURCE_DIR}/tests/generators/idl/unguarded/*.idl)
set(torture_idl ${PROJECT_SOURCE_DIR}/tests/generators/idl)
cyclone_types(${torture_idl} ${torture_idl}/torture_base.idl ${torture_idl}/torture_types.idl ${unguarded_idl})
add_library(cyclone_test_types STATIC ${cyclone_c})
target_include_directories(cyclone_test_types SYSTEM PUBLIC ${cyclone_dir})
target_link_libraries(cyclone_test_types PUBLIC CycloneDDS::ddsc)
add_library(sft_cyclone_test_support STATIC
  ${support}/c_struct.cpp ${support}/cyclone_cdr.cpp ${support}/cyclone_loopback.cpp)
target_link_libraries(sft_cyclone_test_support PUBLIC sft_test_values cyclone_test_types PRIVATE sft_warnings)

# sft_differential_test(NAME PARTS n SHARDS n INTERFACES target... [OURS_ONLY header...] [SOURCES file...])
# Adds a test that compares all types which sft_generate makes for INTERFACES. The types of OURS_ONLY have no C types.
function(sft_differential_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "PARTS;SHARDS" "INTERFACES;OURS_ONLY;SOURCES")
  sft_list_types(parts ${name} PARTS ${arg_PARTS} INTERFACES ${arg_INTERFACES} DEPENDS ${cyclone_c}
    OPTIONS --cyclone ${cyclone_dir} --ours-only ${arg_OURS_ONLY})

  add_executable(${name} differential_test.cpp ${arg_SOURCES} ${parts})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${arg_INTERFACES} sft_cyclone_test_support
    GTest::gtest_main GTest::gmock sft_warnings)
  if(SFT_SANITIZE)
    target_compile_definitions(${name} PRIVATE SFT_TEST_ROUNDS=100)
  endif()
  add_dependencies(unit_tests ${name})
  sft_add_shards(${name} ${arg_SHARDS})
endfunction()

sft_differential_test(differential_test
  PARTS 2 SHARDS 2
  INTERFACES sft_common_interfaces sft_proof_interfaces sft_test_interfaces
  OURS_ONLY torture.hpp  # stock idlc crashes on members called `int` and on bitmask constants in this file
  SOURCES differential_projection_test.cpp)
if(NOT SFT_SANITIZE)  # the same types again, made from IDL files of ROS 2's tool
  sft_differential_test(ros_differential_test
    PARTS 6 SHARDS 4
    INTERFACES sft_ros_idl_interfaces)
endif()
