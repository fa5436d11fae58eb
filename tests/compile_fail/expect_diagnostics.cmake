# cmake -D SNIPPET=file "-D COMMAND=compiler;argument..." -P expect_diagnostics.cmake
# Each `// expect: REGEX` of the snippet has to match the output of the compiler. The first one has to match the
# compiler's first error. A snippet without expectations has to compile.
file(STRINGS ${SNIPPET} expectations REGEX "^// expect: ")
set(ENV{LC_ALL} C)
execute_process(COMMAND ${COMMAND} RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said)

if(NOT expectations)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "does not compile:\n${said}")
  endif()
  return()
endif()
if(status EQUAL 0)
  message(FATAL_ERROR "${SNIPPET} compiles")
endif()

string(REGEX MATCH "[^\n]*error: [^\n]*" searched "${said}")
foreach(expectation IN LISTS expectations)
  string(REPLACE "// expect: " "" regex "${expectation}")
  if(NOT searched MATCHES "${regex}")
    message(FATAL_ERROR "expected: ${regex}\ngot: ${said}")
  endif()
  set(searched "${said}")  # further expectations may match anywhere in the output
endforeach()
