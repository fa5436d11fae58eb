# cmake -D DEMO=program -D "ARGUMENTS=a;b" -D CHECK=program -D "EXPECTED=samples;bytes;requirement" -D OUTPUT=file.json
#       -P run_demo.cmake
# Runs the demo and checks its figures.
file(REMOVE ${OUTPUT})
execute_process(COMMAND ${DEMO} ${ARGUMENTS} --json ${OUTPUT} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CHECK} ${OUTPUT} ${EXPECTED} COMMAND_ECHO STDOUT RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  file(READ ${OUTPUT} figures)
  message(FATAL_ERROR "the figures are wrong:\n${figures}")
endif()
