// Some targets of C++ contain C that is generated for Cyclone DDS. Hence combined.cmake needs a C source.
typedef int sft_precompiled;
