# What the tests in this folder are written in. They get WORK, an empty folder of their own.
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})

# Runs a command, which has to succeed, and sets `output` to what it prints.
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE errors)
  if(NOT status EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "failed (${status}): ${command}\n${output}\n${errors}")
  endif()
  set(output "${output}" PARENT_SCOPE)
  set(errors "${errors}" PARENT_SCOPE)
endfunction()

# A condition as if() takes it.
function(expect left comparison right)
  if(NOT "${left}" ${comparison} "${right}")
    message(FATAL_ERROR "expected: ${comparison} ${right}\ngot: ${left}")
  endif()
endfunction()
