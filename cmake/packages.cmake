# Makes Debian packages of the install components by `cpack -G DEB`: libsft0 (the shared library), libsft-dev (headers,
# messages, message compilers, and the files of CMake and pkg-config), sft-tools (the daemon with its unit) and, if
# pybind11 is there, python3-sft (the Python package). Some paths are compiled in. So `./run package` configures a build
# with the prefix /usr and the configuration in /etc.
set(SFT_PACKAGE_CONTACT "SFT maintainers <sft@example.org>" CACHE STRING "Who maintains the Debian packages")

set(library_package libsft${PROJECT_VERSION_MAJOR})
set(debian ${PROJECT_SOURCE_DIR}/cmake/debian)
set(made ${PROJECT_BINARY_DIR}/CMakeFiles/sft_packages)

# Debian wants a changelog and the copyright in each package.
find_program(GZIP gzip REQUIRED NO_CACHE)
string(TIMESTAMP package_date "%a, %d %b %Y %H:%M:%S +0000" UTC)
foreach(package IN ITEMS ${library_package} libsft-dev sft-tools python3-sft)
  configure_file(${debian}/changelog.in ${made}/${package}/changelog.Debian @ONLY)
  execute_process(COMMAND ${GZIP} -9nfk changelog.Debian
    WORKING_DIRECTORY ${made}/${package} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
function(install_documents package component)
  install(FILES ${debian}/copyright ${made}/${package}/changelog.Debian.gz
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component})
endfunction()
install_documents(${library_package} library)
install_documents(libsft-dev development)
install_documents(sft-tools sftd)
if(TARGET sft_python)
  install_documents(python3-sft python)
endif()

# A control file in the package has the permissions that this function sets.
function(copy_control_file from name executable)
  set(mode OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
  if(executable)
    list(APPEND mode OWNER_EXECUTE GROUP_EXECUTE WORLD_EXECUTE)
  endif()
  configure_file(${debian}/${from} ${made}/${name} @ONLY FILE_PERMISSIONS ${mode})
endfunction()
math(EXPR next_minor "${PROJECT_VERSION_MINOR} + 1")
set(first_incompatible_version ${PROJECT_VERSION_MAJOR}.${next_minor}~)  # docs/operations.md says why, under "Versions"
copy_control_file(libsft.shlibs.in library/shlibs OFF)
copy_control_file(libsft.triggers library/triggers OFF)
copy_control_file(sft-tools.conffiles sftd/conffiles OFF)
foreach(script IN ITEMS postinst prerm postrm)
  copy_control_file(sft-tools.${script} sftd/${script} ON)
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_SET_DESTDIR ON)  # files in /etc and /usr/lib/systemd have absolute paths
set(CPACK_INSTALL_PREFIX ${CMAKE_INSTALL_PREFIX})
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_NAME sft)
set(CPACK_PACKAGE_VENDOR SFT)
set(CPACK_PACKAGE_CONTACT ${SFT_PACKAGE_CONTACT})
set(CPACK_COMPONENTS_ALL library development sftd)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS OFF)
set(this_version ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})
if(CMAKE_CROSSCOMPILING)
  execute_process(COMMAND dpkg-architecture -t ${CMAKE_LIBRARY_ARCHITECTURE} -q DEB_HOST_ARCH
    OUTPUT_VARIABLE CPACK_DEBIAN_PACKAGE_ARCHITECTURE OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
endif()

set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME ${library_package})
set(CPACK_DEBIAN_LIBRARY_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_RECOMMENDS "sft-tools (= ${this_version})")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${made}/library/shlibs ${made}/library/triggers)
set(CPACK_COMPONENT_LIBRARY_DESCRIPTION "publish-subscribe transport that sends each subscriber only what it reads
SFT sends messages between the programs of robots and vehicles. A subscriber
gets the fields that it reads: within a host in place in shared memory, and
between hosts over UDP.
.
This package has the shared library.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libsft-dev)
set(CPACK_DEBIAN_DEVELOPMENT_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${library_package} (= ${this_version}), libexpected-dev")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_RECOMMENDS "cmake | pkg-config, cyclonedds-tools")  # idlc, for .idl files
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "publish-subscribe transport for robots: headers and message compilers
SFT sends messages between the programs of robots and vehicles. A subscriber
gets the fields that it reads.
.
This package has the headers, the common messages of ROS 2, the compilers for
other messages, and files by which CMake and pkg-config find them.")

set(CPACK_DEBIAN_SFTD_PACKAGE_NAME sft-tools)
set(CPACK_DEBIAN_SFTD_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_SFTD_PACKAGE_SECTION net)
set(CPACK_DEBIAN_SFTD_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_SFTD_PACKAGE_DEPENDS "adduser, init-system-helpers (>= 1.54~)")
set(CPACK_DEBIAN_SFTD_PACKAGE_CONTROL_EXTRA
  ${made}/sftd/conffiles ${made}/sftd/postinst ${made}/sftd/prerm ${made}/sftd/postrm)
set(CPACK_COMPONENT_SFTD_DESCRIPTION "publish-subscribe transport for robots: the daemon of shared memory
SFT sends messages between the programs of robots and vehicles. A subscriber
gets the fields that it reads.
.
This package has the daemon sftd, which hosts the memory that the programs of a
host share, and a unit that starts it with the system. Members of the group sft
use that memory.")

if(TARGET sft_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  math(EXPR next_python "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-sft)
  set(CPACK_DEBIAN_PYTHON_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  # dpkg-shlibdeps does not find libsft, which is not installed yet. The others are those of libsft.
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS OFF)
  string(CONCAT CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "${library_package} (= ${this_version}), libc6, libgcc-s1, libstdc++6, "
    "python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${next_python}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "libsft-dev (= ${this_version})")  # the messages that it looks up by name
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "publish-subscribe transport for robots: Python
SFT sends messages between the programs of robots and vehicles. A subscriber
gets the fields that it reads.
.
This package has the module sft, in which arrays of samples are arrays of numpy
in shared memory.")
endif()

include(CPack)
