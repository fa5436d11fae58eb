# Generates C++ headers from message definitions: ROS 2's .msg and .srv files and IDL, in any mixture.
#
#   sft_generate(TARGET my_interfaces
#                FILES my_pkg/msg/Status.msg my_pkg/srv/SetMode.srv other_pkg/msg/Plan.idl ...
#                [BASE_DIR dir]       # default: the current source directory
#                [INCLUDES dir...]    # more directories of packages, such as /opt/ros/humble/share
#                [LINK target...]     # targets made by sft_generate
#                [NAMESPACE my::robot])    # around all types
#
# adds an interface library. Targets that link to it are built after its headers. The headers are generated again when
# the definitions, the definitions that these nest or include, or the compilers change.
#
# The roots are BASE_DIR, INCLUDES, and the roots of the LINK targets. FILES are absolute, or relative to the current
# source directory or to a root. The header of ROOT/my_pkg/msg/Status.msg is <my_pkg/msg/Status.hpp>, and that of
# ROOT/my_pkg/srv/SetMode.srv is <my_pkg/srv/SetMode.hpp>, whatever ROOT is.
# The header of an IDL file has the same path as the file, relative to the innermost root that contains it.
#
# Definitions that FILES nest or include, directly or not, are searched below the roots (first .msg, then .idl) and
# generated, too. If a LINK target generates a definition, that one is used, even if FILES lists the definition. IDL
# files include a message as "my_pkg/msg/Status.idl", which sft_generate() makes of the .msg file.
#
# With NAMESPACE my::robot, std_msgs/msg/Header is the class my::robot::std_msgs::msg::Header in the header
# <my/robot/std_msgs/msg/Header.hpp>, and so are all messages that FILES nest. So one source can include these headers
# and those of ROS 2 or of a target without NAMESPACE. What a LINK target generates is used if its NAMESPACE is the
# same, and is generated again otherwise. Names of types on the wire do not change.
#
# When you build for another architecture, the compilers of messages are programs of that architecture, too. They run if
# this machine runs such programs (with Debian's package qemu-user-static, for example), or if
# CMAKE_CROSSCOMPILING_EMULATOR says how. Or name the compilers of an SFT of the same release for this machine;
# `gcc -dumpmachine` prints its TRIPLET:
#   -D SFT_MSGC=/usr/bin/sft_msgc -D SFT_IDL_PLUGIN=/usr/lib/TRIPLET/sft/libcycloneddsidlsft.so
include_guard(GLOBAL)
include(${CMAKE_CURRENT_LIST_DIR}/SftNested.cmake)

# Only projects with .idl files need idlc.
find_program(SFT_IDLC idlc DOC "The IDL compiler of Cyclone DDS (Debian package cyclonedds-tools)")
set(SFT_MSGC "" CACHE FILEPATH "The sft_msgc that runs here, when building for another architecture")
set(SFT_IDL_PLUGIN "" CACHE FILEPATH "The libcycloneddsidlsft.so for the idlc that runs here, likewise")

# Sets `command` to the words that run sft_msgc, and `file` to the file that it is.
function(sft_find_msgc command file)
  set(found $<TARGET_FILE:sft::sft_msgc>)
  set(emulator)
  if(SFT_MSGC)
    set(found ${SFT_MSGC})
  elseif(CMAKE_CROSSCOMPILING)
    set(emulator ${CMAKE_CROSSCOMPILING_EMULATOR})
  endif()
  set(${command} ${emulator} ${found} PARENT_SCOPE)
  set(${file} ${found} PARENT_SCOPE)
endfunction()

# Adds the custom command for one .msg or .srv file. `idl` is the IDL file that the command writes, too, or empty.
function(sft_generate_from_msg name file root output_dir idl_dir roots idl namespace)
  list(TRANSFORM roots PREPEND -I OUTPUT_VARIABLE include_options)
  if(namespace)
    list(APPEND include_options -N ${namespace})
  endif()
  set(header ${output_dir}/${name}.hpp)
  sft_find_msgc(msgc msgc_file)
  add_custom_command(
    OUTPUT ${header} ${idl}
    COMMAND ${msgc} ${file} -b ${root} ${include_options} -o ${output_dir} -i ${idl_dir} -d ${header}.d
    DEPENDS ${file} ${msgc_file}
    DEPFILE ${header}.d
    COMMENT "Generating ${name}.hpp"
    VERBATIM)
endfunction()

# Adds the custom command for one .idl file, which may include the IDL files in `from_msg`, made of .msg files.
function(sft_generate_from_idl name file root output_dir roots from_msg namespace)
  if(NOT SFT_IDLC)
    message(FATAL_ERROR
      "sft_generate: ${file}: needs idlc, the IDL compiler of Cyclone DDS (Debian package cyclonedds-tools)")
  endif()
  set(header ${output_dir}/${name}.hpp)
  set(script_dir ${CMAKE_CURRENT_FUNCTION_LIST_DIR})
  set(script ${script_dir}/run_idlc.sh)
  set(plugin $<TARGET_FILE:sft::cycloneddsidlsft>)
  if(SFT_IDL_PLUGIN)
    set(plugin ${SFT_IDL_PLUGIN})
  endif()
  list(TRANSFORM roots PREPEND -I OUTPUT_VARIABLE include_options)
  if(namespace)
    list(APPEND include_options -N ${namespace})
  endif()
  list(JOIN roots : root_list)
  add_custom_command(
    OUTPUT ${header}
    COMMAND sh ${script} ${header} ${SFT_IDLC} -l ${plugin}
            -f case-sensitive -Wno-unsupported-annotations -Wno-implicit-extensibility
            ${include_options} -r ${root_list} -b ${root} -o ${output_dir} -d ${header}.d ${file}
    DEPENDS ${file} ${from_msg} ${plugin}
            ${script} ${script_dir}/idlc_copy.awk ${script_dir}/idlc_messages.awk
    DEPFILE ${header}.d
    COMMENT "Generating ${name}.hpp"
    VERBATIM)
endfunction()

# Adds the commands for all files, and sets `outputs` to the files that the commands write. The lists `names`, `files`
# and `file_roots` have the same length. IDL that is made of messages goes to the first of `idl_dirs`.
function(sft_generate_all names files file_roots roots idl_dirs output_dir namespace outputs)
  list(GET idl_dirs 0 idl_dir)
  set(headers)
  set(from_msg)
  foreach(name file root IN ZIP_LISTS names files file_roots)
    list(APPEND headers ${output_dir}/${name}.hpp)
    if(file MATCHES "\\.msg$")
      list(APPEND from_msg ${idl_dir}/${name}.idl)
      sft_generate_from_msg(${name} ${file} ${root} ${output_dir} ${idl_dir} "${roots}" ${idl_dir}/${name}.idl
                            "${namespace}")
    elseif(file MATCHES "\\.srv$")
      sft_generate_from_msg(${name} ${file} ${root} ${output_dir} ${idl_dir} "${roots}" "" "${namespace}")
    endif()
  endforeach()
  foreach(name file root IN ZIP_LISTS names files file_roots)
    if(file MATCHES "\\.idl$")
      sft_generate_from_idl(${name} ${file} ${root} ${output_dir} "${idl_dirs};${roots}" "${from_msg}"
                            "${namespace}")
    endif()
  endforeach()
  set(${outputs} ${headers} ${from_msg} PARENT_SCOPE)
endfunction()

# Makes directories absolute, without a trailing slash.
function(sft_absolute_directories result)
  set(absolute)
  foreach(directory IN LISTS ARGN)
    cmake_path(ABSOLUTE_PATH directory NORMALIZE)
    cmake_path(APPEND directory x)
    cmake_path(GET directory PARENT_PATH directory)
    list(APPEND absolute ${directory})
  endforeach()
  set(${result} ${absolute} PARENT_SCOPE)
endfunction()

# Collects from the targets `linked` their roots, and from those of them with the same namespace the directories with
# IDL made of messages, the names of the definitions that they generate, and the targets that generate these.
function(sft_read_linked linked namespace roots idl_dirs names generators)
  foreach(target IN LISTS linked)
    get_property(is_ours TARGET ${target} PROPERTY SFT_ROOTS SET)
    if(NOT is_ours)
      message(FATAL_ERROR "sft_generate: LINK ${target}: name a target that sft_generate() made")
    endif()
    set(results ROOTS)
    get_property(its_namespace TARGET ${target} PROPERTY SFT_NAMESPACE)
    if("${its_namespace}" STREQUAL "${namespace}")
      list(APPEND results IDL_DIRS NAMES GENERATORS)
    endif()
    foreach(result IN LISTS results)
      string(TOLOWER ${result} variable)
      get_property(values TARGET ${target} PROPERTY SFT_${result})
      list(APPEND all_${variable} ${values})
    endforeach()
  endforeach()
  set(${roots} ${all_roots} PARENT_SCOPE)
  set(${idl_dirs} ${all_idl_dirs} PARENT_SCOPE)
  set(${names} ${all_names} PARENT_SCOPE)
  set(${generators} ${all_generators} PARENT_SCOPE)
endfunction()

function(sft_generate)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "TARGET;BASE_DIR;NAMESPACE" "FILES;INCLUDES;LINK")
  if(NOT arg_TARGET OR NOT arg_FILES OR arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR
      "usage: sft_generate(TARGET t FILES a.msg b.idl... [BASE_DIR dir] [INCLUDES dir...] [LINK t...] [NAMESPACE n])")
  endif()
  set(word "[A-Za-z_][A-Za-z0-9_]*")
  if(arg_NAMESPACE AND NOT arg_NAMESPACE MATCHES "^${word}(::${word})*$")
    message(FATAL_ERROR "sft_generate: NAMESPACE ${arg_NAMESPACE}: expected names as in my::robot")
  endif()
  if(NOT arg_BASE_DIR)
    set(arg_BASE_DIR ${CMAKE_CURRENT_SOURCE_DIR})
  endif()
  sft_absolute_directories(roots ${arg_BASE_DIR} ${arg_INCLUDES})
  sft_read_linked("${arg_LINK}" "${arg_NAMESPACE}" linked_roots idl_dirs linked_names generators)
  list(APPEND roots ${linked_roots})
  list(REMOVE_DUPLICATES roots)
  sft_find_all_listed("${arg_FILES}" "${roots}" "${linked_names}" names files file_roots)
  list(PREPEND roots ${file_roots})  # files of the same root come before others of the same name
  list(REMOVE_DUPLICATES roots)
  sft_add_nested("${roots}" "${linked_names}" names files file_roots)

  set(output_dir ${CMAKE_CURRENT_BINARY_DIR}/sft_generated/${arg_TARGET})
  set(idl_dir ${output_dir}_idl)
  list(PREPEND idl_dirs ${idl_dir})
  set(header_dir ${output_dir})
  if(arg_NAMESPACE)
    string(REPLACE "::" "/" folder ${arg_NAMESPACE})
    cmake_path(APPEND header_dir ${folder})
  endif()
  sft_generate_all("${names}" "${files}" "${file_roots}" "${roots}" "${idl_dirs}" ${header_dir} "${arg_NAMESPACE}"
                   outputs)

  add_custom_target(${arg_TARGET}_headers DEPENDS ${outputs})
  if(generators)
    add_dependencies(${arg_TARGET}_headers ${generators})
  endif()
  add_library(${arg_TARGET} INTERFACE)
  add_dependencies(${arg_TARGET} ${arg_TARGET}_headers)
  target_include_directories(${arg_TARGET} SYSTEM INTERFACE ${output_dir})
  target_link_libraries(${arg_TARGET} INTERFACE sft::typesupport ${arg_LINK})
  list(FILTER outputs INCLUDE REGEX "[.]hpp$")
  set_target_properties(${arg_TARGET} PROPERTIES
    SFT_HEADERS "${outputs}"
    SFT_ROOTS "${roots}"
    SFT_NAMESPACE "${arg_NAMESPACE}"
    SFT_IDL_DIRS "${idl_dirs}"
    SFT_NAMES "${names};${linked_names}"
    SFT_GENERATORS "${arg_TARGET}_headers;${generators}")
endfunction()
