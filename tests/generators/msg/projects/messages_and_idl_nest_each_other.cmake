include(${CMAKE_CURRENT_LIST_DIR}/verbs.cmake)
write(a/msg/Message.msg "b/Plan plan\nInner inner\n")
write(a/msg/Inner.msg "string module\nint32 X=3\n")
write(b/msg/Plan.idl "
  #include \"b/msg/Step.idl\"
  #include \"a/msg/Inner.idl\"
  module b { module msg { struct Plan { sequence<Step> steps; a::msg::Inner inner; }; }; };")
write(b/msg/Step.idl "module b { module msg { struct Step { double length; }; }; };")
write(b/msg/All.idl "
  # include <a/msg/Message.idl>
  module b { module msg { struct All { a::msg::Message message; long x[a::msg::Inner_Constants::X]; }; }; };")
write_project("
  sft_generate(TARGET t FILES a/msg/Message.msg)
  sft_generate(TARGET idl FILES b/msg/All.idl)
  sft_generate(TARGET linked FILES b/msg/All.idl LINK t)
")
expect_generated(t a/msg/Message a/msg/Inner b/msg/Plan b/msg/Step)
expect_generated(idl a/msg/Message a/msg/Inner b/msg/All b/msg/Plan b/msg/Step)
expect_in_header(idl b/msg/All "#include <a/msg/Message.hpp>")
expect_generated(linked b/msg/All)
