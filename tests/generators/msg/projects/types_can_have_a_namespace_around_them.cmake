include(${CMAKE_CURRENT_LIST_DIR}/verbs.cmake)
write(base/a/msg/A.msg "float64 x\n")
write(top/t/msg/T.msg "a/A a\nT2[] more\n")
write(top/t/msg/T2.msg "a/A a\n")
write(top/t/srv/S.srv "T2 t\n---\n")
write(top/t/msg/I.idl "#include \"t/msg/T.idl\"\n#include \"a/msg/A.idl\"
module t { module msg {
  enum E { ONE, @default_literal TWO };
  struct I { t::msg::T t; sequence<a::msg::A> as; E e; };
}; };\n")
write_project("
  sft_generate(TARGET base FILES a/msg/A.msg BASE_DIR base)
  sft_generate(TARGET top FILES t/msg/T.msg t/srv/S.srv t/msg/I.idl BASE_DIR top LINK base NAMESPACE my::robot)
  sft_generate(TARGET more FILES t/msg/T2.msg LINK top NAMESPACE my::robot)
  sft_generate(TARGET other FILES t/msg/T2.msg LINK top NAMESPACE other)
")
# If a linked target generates messages without the namespace, they are generated again. If it generates them in the
# same namespace, they are not.
expect_generated(top my/robot/a/msg/A my/robot/t/msg/I my/robot/t/msg/T my/robot/t/msg/T2 my/robot/t/srv/S)
expect_generated(other other/a/msg/A other/t/msg/T2)
expect_headers(more)
expect_in_header(top my/robot/t/msg/T "#include <my/robot/a/msg/A.hpp>\n")
expect_in_header(top my/robot/t/msg/T "namespace my::robot::t::msg {")
expect_in_header(top my/robot/t/msg/T "std::vector<::my::robot::t::msg::T2> more{};")
expect_in_header(top my/robot/t/msg/T "sft::StructType type{\"t::msg::T\", members}")
expect_in_header(top my/robot/t/srv/S "sft::StructType type{\"t::srv::S_Request\", members}")
expect_in_header(top my/robot/t/msg/I "#include <my/robot/t/msg/T.hpp>\n")
expect_in_header(top my/robot/t/msg/I "::my::robot::t::msg::E e = ::my::robot::t::msg::E::TWO;")
expect_in_header(top my/robot/t/msg/I "sft::EnumType type{\"t::msg::E\"")

foreach(bad IN ITEMS "a-b" "my::" "my:robot")
  write_project("sft_generate(TARGET top FILES t/msg/T2.msg BASE_DIR top INCLUDES base NAMESPACE ${bad})")
  configure()
  expect_error("sft_generate: NAMESPACE ${bad}: expected names as in my::robot")
endforeach()
foreach(word IN ITEMS std sft class NULL)
  write_project("sft_generate(TARGET top FILES t/msg/T2.msg BASE_DIR top INCLUDES base NAMESPACE my::${word})")
  configure()
  expect_success()
  build_headers(top)
  expect_error("the namespace 'my::${word}': expected names as in my::robot, and '${word}' is a word of C++")
endforeach()
