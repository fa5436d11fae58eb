# Lists of generated types, and the list of all types.

# sft_list_types(VARIABLE NAME PARTS n INTERFACES target... [OPTIONS option...] [DEPENDS file...])
# Makes C++ files that list, in parts, all types which sft_generate makes for INTERFACES. Sets VARIABLE to the files.
function(sft_list_types variable name)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "PARTS" "INTERFACES;OPTIONS;DEPENDS")
  set(headers)
  set(header_options)
  foreach(target IN LISTS arg_INTERFACES)
    get_target_property(target_headers ${target} SFT_HEADERS)
    get_target_property(include_dir ${target} INTERFACE_INCLUDE_DIRECTORIES)
    list(APPEND headers ${target_headers})
    list(APPEND header_options --headers ${include_dir} ${target_headers})
  endforeach()
  set(parts)
  foreach(part RANGE ${arg_PARTS})
    list(APPEND parts ${CMAKE_CURRENT_BINARY_DIR}/${name}_types_${part}.cpp)
  endforeach()
  add_custom_command(
    OUTPUT ${parts}
    COMMAND ${SFT_PYTHON} ${support}/contestants.py ${header_options} ${arg_OPTIONS} -- ${parts}
    DEPENDS ${support}/contestants.py ${headers} ${arg_DEPENDS}
    COMMENT "Listing the types of ${name}"
    VERBATIM)
  set(${variable} ${parts} PARENT_SCOPE)
endfunction()

# Divides the tests of a program among few processes. Starting a process for each test of each type would take longer
# than the tests themselves.
function(sft_add_shards name shards)
  math(EXPR last "${shards} - 1")
  foreach(shard RANGE ${last})
    add_test(NAME ${name}.${shard} COMMAND ${name})
    set_tests_properties(${name}.${shard} PROPERTIES LABELS unit-search
      ENVIRONMENT "GTEST_TOTAL_SHARDS=${shards};GTEST_SHARD_INDEX=${shard}")
  endforeach()
endfunction()

set(every_interface
  sft_common_interfaces sft_proof_interfaces sft_test_interfaces sft_foreign_interfaces sft_view_interfaces
  sft_test_interface_files sft_torture_msgs sft_plain_msgs)
sft_list_types(every_type_parts every_type PARTS 4 INTERFACES ${every_interface})
add_library(sft_every_type STATIC ${support}/every_type.cpp ${fuzz}/decoder_input.cpp ${every_type_parts})
target_link_libraries(sft_every_type
  PUBLIC sft_typesupport_test_support
  PRIVATE ${every_interface} sft_warnings)

# Tests of the projection law with all types.
add_executable(every_type_law_test every_type_law_test.cpp)
target_link_libraries(every_type_law_test PRIVATE sft_every_type GTest::gtest_main sft_warnings)
if(SFT_SANITIZE)
  target_compile_definitions(every_type_law_test PRIVATE SFT_TEST_TRIPLES=10000)
endif()
add_dependencies(unit_tests every_type_law_test)
sft_add_shards(every_type_law_test 2)

# Tests of all types as text.
sft_unit_test(every_type_text_test SEARCH
  SOURCES json_law_test.cpp msg_text_test.cpp
  LIBRARIES sft_every_type)
target_compile_definitions(every_type_text_test PRIVATE SFT_INTERFACES="${PROJECT_SOURCE_DIR}/typesupport/interfaces")

if(SFT_SANITIZE)
  return() # the sanitizers run only the tests above; the rest is only compiled
endif()

# Every getter of every view of the common packages compiles.
sft_list_types(every_view_parts every_view PARTS 4 INTERFACES sft_common_interfaces OPTIONS --views)
list(POP_FRONT every_view_parts)  # the first file only joins the lists of the other files
add_library(sft_every_view OBJECT ${every_view_parts})
target_link_libraries(sft_every_view PRIVATE sft_typesupport_test_support sft_warnings)
target_compile_options(sft_every_view PRIVATE -O0 -g0)
add_dependencies(unit_tests sft_every_view)
