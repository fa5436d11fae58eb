include(${CMAKE_CURRENT_LIST_DIR}/verbs.cmake)
write(a/srv/SetMode.srv "Mode mode\n---\nb/Result[] results\nMode before\n")
write(a/srv/Request.srv "---\n")
write(a/msg/Mode.msg "uint8 value\n")
write(b/msg/Result.msg "string text\n")
write_project("
  sft_generate(TARGET t FILES a/srv/SetMode.srv a/srv/Request.srv)
  sft_generate(TARGET linked FILES a/srv/SetMode.srv a/msg/Other.msg LINK t)
")
write(a/msg/Other.msg "Mode mode\n")
expect_generated(t a/srv/SetMode a/srv/Request a/msg/Mode b/msg/Result)
expect_in_header(t a/srv/SetMode "// Generated from a/srv/SetMode.srv. Do not edit.")
expect_in_header(t a/srv/SetMode "#include <a/msg/Mode.hpp>\n#include <b/msg/Result.hpp>\n")
expect_in_header(t a/srv/SetMode "struct SetMode {
  using Request = SetMode_Request;
  using Response = SetMode_Response;
  using Call = SetMode_Call;
  using Reply = SetMode_Reply;
};")
# A struct cannot have a member with its own name.
expect_in_header(t a/srv/Request "struct Request_ {\n  using Request = Request_Request;")
# A service is generated once, and again if a type that it nests changes.
expect_generated(linked a/msg/Other)
let_time_pass()
write(b/msg/Result.msg "Missing m\n")
build_headers(t)
expect_error("there is no b/msg/Missing.msg")

write(a/srv/SetMode.srv "Mode mode\n---\n\nint32 y 1.5\n")
write(b/msg/Result.msg "string text\n")
build_headers(t)
expect_error("${source}/a/srv/SetMode.srv:4: a/srv/SetMode.y: '1.5' is")
write(a/srv/SetMode.srv "Mode mode\n---\nc/Missing m\n")
configure()
expect_error("${source}/a/srv/SetMode.srv:3: there is no c/msg/Missing.msg or .idl below ${source}")
