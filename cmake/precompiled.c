// What is generated in C for Cyclone DDS is a part of targets that are of C++ otherwise: for precompiled.cmake.
typedef int sft_precompiled;
