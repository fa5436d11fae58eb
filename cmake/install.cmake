# Installs what programs outside of this tree need: one shared library with all parts, the public headers, the message
# types with their generated headers, the message compilers, and the files by which CMake and pkg-config find them. The
# install rules of the daemon are in shm_transport/CMakeLists.txt.
#
# Within this tree, the parts are static libraries, and tests and benchmarks link to the parts that they need. A shared
# library is installed for two reasons: a package can have its name and version, and it hides Cyclone DDS, iceoryx,
# liburing and libacl, so that programs need none of their headers, libraries or CMake files.
include(CMakePackageConfigHelpers)

set(objects)
foreach(part IN ITEMS sft sft_core sft_shm sft_udp sft_typesupport)
  list(APPEND objects $<TARGET_OBJECTS:${part}>)
endforeach()
set(exported_names ${PROJECT_SOURCE_DIR}/cmake/libsft.map)
add_library(sft_shared SHARED ${objects})
# Links the libraries that the parts need. The code of the parts themselves is in `objects`.
target_link_libraries(sft_shared PRIVATE sft)
target_link_options(sft_shared PRIVATE
  LINKER:--version-script=${exported_names} LINKER:-Bsymbolic-functions LINKER:--as-needed LINKER:--no-undefined
  LINKER:-z,nodelete)  # threads that look names up are not joined, and return into its code
set_target_properties(sft_shared PROPERTIES
  OUTPUT_NAME sft
  LINKER_LANGUAGE CXX
  LINK_DEPENDS ${exported_names}
  VERSION ${PROJECT_VERSION}
  SOVERSION ${PROJECT_VERSION_MAJOR})

# Messages are installed below a folder of SFT, since ROS 2 has messages of the same names.
set(sft_include_dir ${CMAKE_INSTALL_INCLUDEDIR})
set(sft_interfaces_include_dir ${CMAKE_INSTALL_INCLUDEDIR}/sft/interfaces)
set(sft_interfaces_dir ${CMAKE_INSTALL_DATADIR}/sft/interfaces)
set(sft_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/sft)
set(sft_compiler_dir ${CMAKE_INSTALL_LIBDIR}/sft)
set(typesupport ${PROJECT_SOURCE_DIR}/typesupport)

install(TARGETS sft_shared
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT development)
install(DIRECTORY core/include/ typesupport/runtime/include/
  DESTINATION ${sft_include_dir} COMPONENT development FILES_MATCHING PATTERN *.h)

# `cmake --build` generates the headers of all common messages, even if no target of this build uses them.
set_target_properties(sft_common_interfaces_headers PROPERTIES EXCLUDE_FROM_ALL OFF)
get_target_property(generated sft_common_interfaces INTERFACE_INCLUDE_DIRECTORIES)
get_target_property(generated_idl sft_common_interfaces SFT_IDL_DIRS)
get_target_property(sft_interface_names sft_common_interfaces SFT_NAMES)
install(DIRECTORY ${generated}/
  DESTINATION ${sft_interfaces_include_dir} COMPONENT development FILES_MATCHING PATTERN *.hpp)
install(DIRECTORY ${generated_idl}/
  DESTINATION ${sft_interfaces_dir} COMPONENT development FILES_MATCHING PATTERN *.idl)
install(DIRECTORY ${typesupport}/interfaces/
  DESTINATION ${sft_interfaces_dir} COMPONENT development FILES_MATCHING PATTERN *.msg PATTERN *.srv)

# idlc loads the library cycloneddsidlsft at run time. No program links to it.
install(TARGETS sft_msgc RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT development)
install(TARGETS cycloneddsidlsft LIBRARY DESTINATION ${sft_compiler_dir} COMPONENT development)
install(
  FILES
    ${typesupport}/cmake/SftGenerate.cmake
    ${typesupport}/cmake/SftNested.cmake
    ${typesupport}/cmake/idlc_copy.awk
    ${typesupport}/cmake/idlc_messages.awk
    ${typesupport}/cmake/run_idlc.sh
  DESTINATION ${sft_cmake_dir} COMPONENT development)

# CMake and pkg-config find the installation by these files. All paths in them are relative, so that an installation can
# be moved.
set(made ${PROJECT_BINARY_DIR}/CMakeFiles/sft_install)
set(sft_library_file ${CMAKE_INSTALL_LIBDIR}/libsft.so.${PROJECT_VERSION})
set(sft_daemon_file ${CMAKE_INSTALL_LIBEXECDIR}/sft/sftd)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/sftConfig.cmake.in ${made}/sftConfig.cmake
  INSTALL_DESTINATION ${sft_cmake_dir} NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
write_basic_package_version_file(${made}/sftConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${made}/sftConfig.cmake ${made}/sftConfigVersion.cmake
  DESTINATION ${sft_cmake_dir} COMPONENT development)

file(RELATIVE_PATH sft_prefix_from_pc ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" sft_prefix_from_pc ${sft_prefix_from_pc})
configure_file(${PROJECT_SOURCE_DIR}/cmake/sft.pc.in ${made}/sft.pc @ONLY)
install(FILES ${made}/sft.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
