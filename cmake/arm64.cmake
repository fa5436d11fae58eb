# Toolchain of CMake: builds for arm64 with Debian's cross compiler (g++-aarch64-linux-gnu) and the libraries of the
# foreign architecture arm64. The generators of message headers are built for arm64, too, and run during the build. So
# the system has to run programs of arm64, for which Debian's qemu-user-static is enough. See docs/operations.md.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
# pkg-config finds the libraries of the building machine unless this is set.
set(ENV{PKG_CONFIG_LIBDIR} /usr/lib/aarch64-linux-gnu/pkgconfig:/usr/share/pkgconfig)
