# Compares SFT's types with ROS 2's reading of the same messages. rosidl_adapter converts the messages to IDL, and types
# are generated from that IDL, too.
find_package(nlohmann_json REQUIRED)
set(oracle ${CMAKE_CURRENT_BINARY_DIR}/oracle)
list(TRANSFORM plain_files PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/interfaces/ OUTPUT_VARIABLE oracle_msgs)
list(TRANSFORM test_interface_files PREPEND /usr/share/ OUTPUT_VARIABLE test_interface_paths)
list(APPEND oracle_msgs ${test_interface_paths})
list(TRANSFORM plain_files PREPEND ${oracle}/ OUTPUT_VARIABLE oracle_idl)
list(TRANSFORM test_interface_files PREPEND ${oracle}/ OUTPUT_VARIABLE test_interface_idl)
list(APPEND oracle_idl ${test_interface_idl})
list(TRANSFORM oracle_idl REPLACE "\\.msg$" ".idl")
add_custom_command(
  OUTPUT ${oracle_idl} ${oracle}/types.inc ${oracle}/values.json
  COMMAND ${SFT_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/rosidl.py ${oracle} ${oracle_msgs}
  DEPENDS ${CMAKE_CURRENT_LIST_DIR}/rosidl.py ${oracle_msgs}
  COMMENT "Converting messages with rosidl_adapter"
  VERBATIM)
sft_generate(
  TARGET sft_oracle_idl
  FILES ${oracle_idl}
  BASE_DIR ${oracle})

# Also compares the IDL that sft_generate itself makes of messages that IDL files nest.
set(our_idl ${plain_files} ${test_interface_files})
list(TRANSFORM our_idl REPLACE "\\.msg$" ".idl")
set(idl_of ${CMAKE_CURRENT_BINARY_DIR}/sft_generated)
list(TRANSFORM our_idl PREPEND ${idl_of}/sft_plain_msgs_idl/ REGEX "^plain_msgs/")
list(TRANSFORM our_idl PREPEND ${idl_of}/sft_test_interface_files_idl/ REGEX "^test_interface_files/")
sft_generate(
  TARGET sft_our_idl
  FILES ${our_idl}
  INCLUDES ${idl_of}/sft_plain_msgs_idl ${idl_of}/sft_test_interface_files_idl)
add_dependencies(sft_our_idl_headers sft_plain_msgs_headers sft_test_interface_files_headers)

foreach(source IN ITEMS msg idl our_idl)
  add_executable(describe_${source} ${CMAKE_CURRENT_LIST_DIR}/describe.cpp ${oracle}/types.inc)
  target_include_directories(describe_${source} PRIVATE ${oracle})
  target_link_libraries(describe_${source} PRIVATE sft_typesupport nlohmann_json::nlohmann_json sft_warnings)
  add_dependencies(unit_tests describe_${source})
endforeach()
target_link_libraries(describe_msg PRIVATE sft_test_interface_files sft_plain_msgs)
target_link_libraries(describe_idl PRIVATE sft_oracle_idl)
target_link_libraries(describe_our_idl PRIVATE sft_our_idl)
add_test(NAME msg.is_read_as_ros_reads_it
         COMMAND ${SFT_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/compare.py ${oracle}/values.json
                 $<TARGET_FILE:describe_msg> $<TARGET_FILE:describe_idl> $<TARGET_FILE:describe_our_idl>)
set_tests_properties(msg.is_read_as_ros_reads_it PROPERTIES LABELS unit)
