# Functions for the tests in this folder. Each test gets WORK, an empty folder of its own.
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})

# Runs a command, which has to succeed. Sets `output` and `errors` to what it prints.
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE errors)
  if(NOT status EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "failed (${status}): ${command}\n${output}\n${errors}")
  endif()
  set(output "${output}" PARENT_SCOPE)
  set(errors "${errors}" PARENT_SCOPE)
endfunction()

# Fails unless the condition, written as for if(), is true.
function(expect left comparison right)
  if(NOT "${left}" ${comparison} "${right}")
    message(FATAL_ERROR "expected: ${comparison} ${right}\ngot: ${left}")
  endif()
endfunction()
