# C++ headers from IDL files.
#
#   sft_generate(TARGET my_interfaces
#                FILES my_pkg/msg/Status.idl ...
#                [BASE_DIR dir]          # mirrored: dir/my_pkg/msg/Status.idl is included as <my_pkg/msg/Status.hpp>;
#                                        # default: the current source directory
#                [INCLUDES dir...]       # more directories that #include in the IDL files is relative to
#                [LINK target...])       # targets made by sft_generate whose IDL files these include
#
# makes an interface library. Targets that link to it are built after its headers, which follow changes of the IDL
# files, of all that they include, and of the compiler.
include_guard(GLOBAL)

find_program(SFT_IDLC idlc REQUIRED DOC "The IDL compiler of Cyclone DDS (Debian package cyclonedds-tools)")

# Makes the custom command for one file and sets `header_variable` to what it generates.
function(sft_generate_header file output_dir base_dir roots header_variable)
  cmake_path(ABSOLUTE_PATH file NORMALIZE)
  cmake_path(IS_PREFIX base_dir ${file} is_below)
  if(NOT is_below)
    message(FATAL_ERROR "sft_generate: ${file} is not below ${base_dir}: name a directory above it as BASE_DIR")
  endif()
  cmake_path(RELATIVE_PATH file BASE_DIRECTORY ${base_dir} OUTPUT_VARIABLE name)
  cmake_path(REPLACE_EXTENSION name LAST_ONLY .hpp)
  set(header ${output_dir}/${name})
  set(script_dir ${CMAKE_CURRENT_FUNCTION_LIST_DIR})
  set(script ${script_dir}/run_idlc.sh)

  list(TRANSFORM roots PREPEND -I OUTPUT_VARIABLE include_options)
  list(JOIN roots : root_list)
  add_custom_command(
    OUTPUT ${header}
    COMMAND sh ${script} ${header} ${SFT_IDLC} -l $<TARGET_FILE:cycloneddsidlsft>
            -f case-sensitive -Wno-unsupported-annotations -Wno-implicit-extensibility
            ${include_options} -r ${root_list} -b ${base_dir} -o ${output_dir} -d ${header}.d ${file}
    DEPENDS ${file} cycloneddsidlsft ${script} ${script_dir}/idlc_copy.awk ${script_dir}/idlc_messages.awk
    DEPFILE ${header}.d
    COMMENT "Generating ${name}"
    VERBATIM)
  set(${header_variable} ${header} PARENT_SCOPE)
endfunction()

function(sft_generate)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "TARGET;BASE_DIR" "FILES;INCLUDES;LINK")
  if(NOT arg_TARGET OR NOT arg_FILES OR arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "usage: sft_generate(TARGET t FILES a.idl... [BASE_DIR dir] [INCLUDES dir...] [LINK t...])")
  endif()
  if(NOT arg_BASE_DIR)
    set(arg_BASE_DIR ${CMAKE_CURRENT_SOURCE_DIR})
  endif()
  set(absolute_roots)
  foreach(root IN LISTS arg_BASE_DIR arg_INCLUDES)
    cmake_path(ABSOLUTE_PATH root NORMALIZE)
    cmake_path(APPEND root x)  # a trailing slash, if any, goes with it
    cmake_path(GET root PARENT_PATH root)
    list(APPEND absolute_roots ${root})
  endforeach()
  list(GET absolute_roots 0 base_dir)
  foreach(linked IN LISTS arg_LINK)
    get_property(linked_roots TARGET ${linked} PROPERTY SFT_IDL_ROOTS)
    if(NOT linked_roots)
      message(FATAL_ERROR "sft_generate: LINK ${linked}, which sft_generate did not make")
    endif()
    list(APPEND absolute_roots ${linked_roots})
  endforeach()
  list(REMOVE_DUPLICATES absolute_roots)

  set(output_dir ${CMAKE_CURRENT_BINARY_DIR}/sft_generated/${arg_TARGET})
  set(headers)
  foreach(file IN LISTS arg_FILES)
    sft_generate_header(${file} ${output_dir} ${base_dir} "${absolute_roots}" header)
    list(APPEND headers ${header})
  endforeach()

  add_custom_target(${arg_TARGET}_headers DEPENDS ${headers})
  add_library(${arg_TARGET} INTERFACE)
  add_dependencies(${arg_TARGET} ${arg_TARGET}_headers)
  target_include_directories(${arg_TARGET} SYSTEM INTERFACE ${output_dir})
  target_link_libraries(${arg_TARGET} INTERFACE sft_typesupport ${arg_LINK})
  set_property(TARGET ${arg_TARGET} PROPERTY SFT_IDL_ROOTS ${absolute_roots})
  set_property(TARGET ${arg_TARGET} PROPERTY SFT_HEADERS ${headers})
endfunction()
