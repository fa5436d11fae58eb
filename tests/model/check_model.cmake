# cmake -D MODEL=file -D WORK=folder -D "DEFINES=A=1;B" -D SPIN=program -D CC=program [-D FINDS=regex]
#       -P check_model.cmake
# Searches all states of a model, or all fair runs if DEFINES has LIVENESS. Fails if a property does not hold, or if a
# statement is never reached, since properties of it would mean nothing. With FINDS, DEFINES makes a mistake on purpose.
# Then the script fails unless the checker finds a violation that matches FINDS.
cmake_minimum_required(VERSION 3.22)
set(memory_max_mib 2000)
set(depth_max 100000)

file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
list(TRANSFORM DEFINES PREPEND -D OUTPUT_VARIABLE spin_options)

function(run)
  execute_process(COMMAND ${ARGV} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE status OUTPUT_VARIABLE output
                  ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGV}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(level -O1)
if(FINDS)
  set(level -O0) # a deliberate mistake is found soon, so optimising the checker does not pay
endif()
if(LIVENESS IN_LIST DEFINES)
  set(compile_options -DNFAIR=4) # for models of up to 18 processes
  set(search_options -a -f -A)   # searches acceptance cycles under weak fairness, and checks no assertions
else()
  set(compile_options -DSAFETY)
endif()
run(${SPIN} -a ${spin_options} ${MODEL})
run(${CC} ${level} -w -DMEMLIM=${memory_max_mib} ${compile_options} -o pan pan.c)
run(${CMAKE_COMMAND} -E time ./pan ${search_options} -m${depth_max} -w22)
message("${output}")

if(output MATCHES "max search depth too small|out of memory|memory limit|too many processes|interrupted")
  message(FATAL_ERROR "not all states were searched")
endif()
if(FINDS)
  if(NOT output MATCHES "pan:[0-9]+: [^\n]*${FINDS}")
    message(FATAL_ERROR "not found: ${FINDS}")
  endif()
  return()
endif()

if(NOT output MATCHES "errors: 0\n")
  file(GLOB trails ${WORK}/*.trail)
  execute_process(COMMAND ${SPIN} -p -g -k ${trails} ${spin_options} ${MODEL} WORKING_DIRECTORY ${WORK})
  message(FATAL_ERROR "a property does not hold; the steps that lead there are above")
endif()
string(REGEX REPLACE "unreached in claim.*" "" statements "${output}") # spin prints the claim last
string(REGEX MATCHALL "[^\n]*\\.pml:[0-9]+, state [0-9]+, [^\n]*" unreached "${statements}")
list(FILTER unreached EXCLUDE REGEX "-end-")
if(unreached)
  list(JOIN unreached "\n" lines)
  message(FATAL_ERROR "never reached:\n${lines}")
endif()
