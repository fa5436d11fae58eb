include(${CMAKE_CURRENT_LIST_DIR}/verbs.cmake)
write(a/msg/A.msg "c/C c\n")
write(c/msg/C.msg "float64 x\n")
write(far/b/msg/B.msg "c/C c\n")
write(a/srv/A.srv "---\n")

run(${SFT_MSGC} ${source}/a/srv/A.srv -o ${build})
expect_error("${source}/a/srv/A.srv:1: a/srv/A.srv: services and actions are not supported")
run(${SFT_MSGC} ${source}/a/msg/A.msg -b ${source}/a -o ${build})
expect_error("${source}/a/msg/A.msg:1: msg/A.msg: this is no place for a message: \
expected PACKAGE/msg/NAME.msg below ${source}/a")
run(${SFT_MSGC} ${source}/a/msg/Missing.msg -o ${build})
expect_error("cannot read ${source}/a/msg/Missing.msg: No such file or directory")
run(${SFT_MSGC} ${source}/far/b/msg/B.msg -o ${build})
expect_error("${source}/far/b/msg/B.msg:1: b/msg/B.c: there is no c/msg/C.msg or .idl below ${source}/far:")
run(${SFT_MSGC} ${source}/far/b/msg/B.msg -I${source} -o /proc/no_such_directory)
expect_error("/proc/no_such_directory")

run(${SFT_MSGC} ${source}/far/b/msg/B.msg -I ${source} -o ${build}/sft_generated/t)
expect_success()
expect_headers(t b/msg/B)

set(wide /usr/share/test_interface_files/msg/WStrings.msg)
run(${SFT_MSGC} ${wide} -o ${build})
expect_error("${wide}:1: test_interface_files/msg/WStrings.wstring_value: wide characters are not supported: \
use string, which holds UTF-8")
expect_error("${wide}:10: test_interface_files/msg/WStrings.unbounded_sequence_of_wstrings: wide characters")
