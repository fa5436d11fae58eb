# cmake -D DEMO=program -D "ARGUMENTS=a;b" -D CHECK=program -D "EXPECTED=samples;bytes;requirement" -D OUTPUT=file.json
# [-D INPUT=path] -P run_demo.cmake
# Runs the demo and checks its figures. If INPUT is not on this machine, the script reports that, and the test counts as
# skipped.
if(DEFINED INPUT)
  if(NOT EXISTS "${INPUT}")
    message("SKIPPED: ${INPUT} is not on this machine")
    return()
  endif()
  list(APPEND ARGUMENTS --input ${INPUT})
endif()
file(REMOVE ${OUTPUT})
execute_process(COMMAND ${DEMO} ${ARGUMENTS} --json ${OUTPUT} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CHECK} ${OUTPUT} ${EXPECTED} COMMAND_ECHO STDOUT RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  file(READ ${OUTPUT} figures)
  message(FATAL_ERROR "the figures are wrong:\n${figures}")
endif()
