include(${CMAKE_CURRENT_LIST_DIR}/verbs.cmake)
write(a/msg/A.msg "B b\n")
write(a/msg/B.msg "# [\n\nfloat64[] x\nc/Missing[] y\n")
write_project("sft_generate(TARGET t FILES a/msg/A.msg INCLUDES other)")
configure()
expect_error("${source}/a/msg/B.msg:4: there is no c/msg/Missing.msg or .idl below ${source}, ${source}/other: \
name the directory above the package in INCLUDES")
# After the missing message was written, the configuration succeeds.
write(c/msg/Missing.msg "float64 x\n")
expect_generated(t a/msg/A a/msg/B c/msg/Missing)
# The type `Header` without a package, which ROS 1 accepted in every package.
write(a/msg/B.msg "Header header\n")
configure()
expect_error("there is no a/msg/Header.msg or .idl below ${source}, ${source}/other: did you mean std_msgs/Header?")
