// Some targets of C++ contain C that is generated for Cyclone DDS. precompiled.cmake needs a C source for them.
typedef int sft_precompiled;
