# Saves work that the compiler would repeat for each source. The sources that a target has in one folder are compiled as
# one, and headers that nearly every source includes are precompiled. So a first build takes a quarter of the time. A
# build with SFT_COMBINE=OFF does neither, and shows that each source includes what it uses.
#
# A folder is compiled in a few seconds, and a whole target as one object would not be much faster. It would also be
# worse: a program links the objects of a library that it uses, so that sftd would depend on Cyclone DDS.
#
# Sources that are compiled as one share their anonymous namespaces. A source with compile options or definitions of its
# own is compiled separately. So are sources with SKIP_UNITY_BUILD_INCLUSION, and the sources of targets that turn
# UNITY_BUILD off.
if(NOT SFT_COMBINE)
  return()
endif()

# Precompiling the headers takes as long as this many objects save.
set(SFT_OBJECTS_MIN 4)

# sft_targets_below(VARIABLE DIRECTORY): lists the programs and libraries of the directory and its subdirectories.
function(sft_targets_below variable directory)
  set(found)
  get_property(targets DIRECTORY ${directory} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    if(type MATCHES "^(EXECUTABLE|STATIC_LIBRARY|OBJECT_LIBRARY)$")
      list(APPEND found ${target})
    endif()
  endforeach()
  get_property(subdirectories DIRECTORY ${directory} PROPERTY SUBDIRECTORIES)
  foreach(subdirectory IN LISTS subdirectories)
    sft_targets_below(below ${subdirectory})
    list(APPEND found ${below})
  endforeach()
  set(${variable} ${found} PARENT_SCOPE)
endfunction()

# sft_kind(VARIABLE TARGET): names the kind of TARGET. Targets of one kind can use the same precompiled headers. Only
# targets that link to GoogleTest get the headers of GoogleTest, which are slow to load.
function(sft_kind variable target)
  get_target_property(type ${target} TYPE)
  get_target_property(options ${target} COMPILE_OPTIONS)
  get_target_property(visibility ${target} CXX_VISIBILITY_PRESET)
  get_target_property(libraries ${target} LINK_LIBRARIES)
  set(kind library)
  if(type STREQUAL EXECUTABLE)
    set(kind program)
  endif()
  if(libraries MATCHES "GTest::gtest_main|sft_isolated_main")
    set(kind test)
  endif()
  string(MD5 key "${options};${visibility}")
  string(SUBSTRING ${key} 0 6 key)
  set(${variable} ${kind}_${key} PARENT_SCOPE)
endfunction()

# sft_precompile(KIND TARGET...): gives these targets, which are all of that kind, precompiled headers.
function(sft_precompile kind first)
  get_target_property(options ${first} COMPILE_OPTIONS)
  get_target_property(visibility ${first} CXX_VISIBILITY_PRESET)
  set(headers sft_headers_of_${kind})
  set(sources ${PROJECT_SOURCE_DIR}/cmake/precompiled.cpp ${PROJECT_SOURCE_DIR}/cmake/precompiled.c)
  if(kind MATCHES "^library")
    add_library(${headers} STATIC EXCLUDE_FROM_ALL ${sources})
  else()
    add_executable(${headers} EXCLUDE_FROM_ALL ${sources})
  endif()
  if(visibility)
    set_target_properties(${headers} PROPERTIES CXX_VISIBILITY_PRESET ${visibility})
  endif()
  if(options)
    target_compile_options(${headers} PRIVATE ${options})
  endif()
  set(header ${PROJECT_SOURCE_DIR}/cmake/precompiled.h)
  if(kind MATCHES "^test")
    target_link_libraries(${headers} PRIVATE GTest::gtest GTest::gmock)
    set(header ${PROJECT_SOURCE_DIR}/cmake/precompiled_tests.h)
  endif()
  target_link_libraries(${headers} PRIVATE sft_warnings)
  # With a time stamp in it, the result would differ in each build, and a compiler cache could not find it again.
  target_compile_options(${headers} PRIVATE "$<$<CXX_COMPILER_ID:Clang>:SHELL:-Xclang -fno-pch-timestamp>")
  target_include_directories(${headers} PRIVATE ${PROJECT_SOURCE_DIR} ${TL_EXPECTED_INCLUDE_DIR})
  target_precompile_headers(${headers} PRIVATE
    $<$<COMPILE_LANGUAGE:CXX>:${header}> $<$<COMPILE_LANGUAGE:C>:<stddef.h$<ANGLE-R>>)
  foreach(target IN LISTS first ARGN)
    target_precompile_headers(${target} REUSE_FROM ${headers})
    # A library of Debian may bring definitions with which GCC cannot use the precompiled headers. It then compiles the
    # headers again.
    set_target_properties(${target} PROPERTIES PCH_WARN_INVALID OFF)
    # GCC gives false warnings about precompiled headers of the standard library.
    set(false_warnings -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread)
    # Many sources together take so much memory that GCC's garbage collector would run. Without it, GCC is a tenth
    # faster.
    set(memory_kB 1000000)
    target_compile_options(${target} PRIVATE
      "$<$<CXX_COMPILER_ID:GNU>:${false_warnings};--param=ggc-min-heapsize=${memory_kB}>")
  endforeach()
endfunction()

# sft_combine(VARIABLE TARGET): combines the sources of TARGET, and sets VARIABLE to the number of objects of C++ that
# it then has.
function(sft_combine variable target)
  get_target_property(combines ${target} UNITY_BUILD)
  get_target_property(directory ${target} SOURCE_DIR)
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "[.](c|cpp)$")
  set(folders)
  foreach(source IN LISTS sources)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${directory} NORMALIZE)
    cmake_path(GET source PARENT_PATH folder)
    file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${folder})
    string(MAKE_C_IDENTIFIER "${folder}" folder)
    set_source_files_properties(${source} TARGET_DIRECTORY ${target} PROPERTIES UNITY_GROUP ${folder})
    list(APPEND folders ${folder})
  endforeach()
  if(combines STREQUAL OFF)
    list(LENGTH sources objects)
  else()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
    list(REMOVE_DUPLICATES folders)
    list(LENGTH folders objects)
  endif()
  set(${variable} ${objects} PARENT_SCOPE)
endfunction()

sft_targets_below(all ${PROJECT_SOURCE_DIR})
set(kinds)
foreach(target IN LISTS all)
  sft_combine(objects ${target})
  sft_kind(kind ${target})
  list(APPEND kinds ${kind})
  list(APPEND targets_of_${kind} ${target})
  math(EXPR objects_of_${kind} "0${objects_of_${kind}} + ${objects}")
endforeach()
list(REMOVE_DUPLICATES kinds)
foreach(kind IN LISTS kinds)
  if(objects_of_${kind} GREATER_EQUAL SFT_OBJECTS_MIN)
    sft_precompile(${kind} ${targets_of_${kind}})
  endif()
endforeach()
