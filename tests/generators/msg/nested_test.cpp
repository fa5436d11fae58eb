// The search for nested types below search roots.
#include "from_msg/nested.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/generators/msg/parsed.h"
#include "tests/support/temporary_directory.h"

namespace sft::msg {
namespace {

namespace fs = std::filesystem;
using test::parsed;

class NestedTest : public ::testing::Test {
 protected:
  /// Writes a file. `path` is relative to the temporary directory.
  void write(const std::string& path, std::string_view text) { directory_.write(path, text); }

  SearchPath search_path(const std::vector<std::string>& roots) const {
    std::vector<fs::path> paths;
    for (const std::string& root : roots) paths.push_back(root_ / root);
    return SearchPath(std::move(paths));
  }

  /// Returns the files of the types that the text nests, relative to the temporary directory.
  std::vector<std::string> files(std::string_view text, const std::vector<std::string>& roots = {"a"}) {
    std::vector<std::string> relative;
    const auto found = nested_files(parsed(text), search_path(roots));
    if (!found) ADD_FAILURE() << found.error().front().text;
    if (!found) return relative;
    for (const fs::path& file : *found) relative.push_back(file.lexically_relative(root_).string());
    return relative;
  }

  /// Returns the problem of the text as "LINE MEMBER: TEXT", with ROOT in place of the temporary directory.
  /// Expects exactly one problem.
  std::string problem(std::string_view text, const std::vector<std::string>& roots = {"a"}) {
    const auto found = nested_files(parsed(text), search_path(roots));
    if (found || found.error().size() != 1) return "";
    const Problem& problem = found.error().front();
    std::string line = std::to_string(problem.line) + " " + problem.member + ": " + problem.text;
    for (std::size_t at = 0; (at = line.find(root_.string(), at)) != line.npos;)
      line.replace(at, root_.string().size(), "ROOT");
    return line;
  }

  const sft::test::TemporaryDirectory directory_;
  const fs::path root_ = directory_.path();
};

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST_F(NestedTest, TypesOfThePackageAndOfOthersAreFoundOnce) {
  write("a/my_msgs/msg/A.msg", "int8 x");
  write("a/other/msg/B.msg", "int8 x");
  EXPECT_THAT(files("A a\nother/B[] b\nA[3] c\nint8 d"),
              ElementsAre("a/my_msgs/msg/A.msg", "a/other/msg/B.msg"));
}

TEST_F(NestedTest, TypesOfNestedTypesAreFound) {
  write("a/my_msgs/msg/A.msg", "other/B b");
  write("a/other/msg/B.msg", "C c");
  write("a/other/msg/C.msg", "");
  EXPECT_THAT(files("A a"), ElementsAre("a/my_msgs/msg/A.msg", "a/other/msg/B.msg", "a/other/msg/C.msg"));
}

TEST_F(NestedTest, TheFirstRootWinsAndInItTheMessageBeforeIdl) {
  write("a/my_msgs/msg/A.idl", "");
  write("a/my_msgs/msg/A.msg", "");
  write("a/my_msgs/msg/B.idl", "");
  write("b/my_msgs/msg/A.msg", "");
  write("b/my_msgs/msg/B.msg", "");
  write("b/my_msgs/msg/C.msg", "");
  EXPECT_THAT(files("A a\nB b\nC c", {"a", "b"}),
              ElementsAre("a/my_msgs/msg/A.msg", "a/my_msgs/msg/B.idl", "b/my_msgs/msg/C.msg"));
}

TEST_F(NestedTest, ATypeThatIsNowhereIsAnErrorThatSaysWhereItWasLookedFor) {
  EXPECT_EQ(
      problem("int8 x\nother/B b", {"a", "b"}),
      "2 b: there is no other/msg/B.msg or .idl below ROOT/a, ROOT/b: name the directory above the package "
      "as another root (-I; INCLUDES of sft_generate)");
}

TEST_F(NestedTest, AMissingHeaderIsProbablyThatOfStdMsgs) {
  EXPECT_EQ(
      problem("Header header"),
      "1 header: there is no my_msgs/msg/Header.msg or .idl below ROOT/a: did you mean std_msgs/Header?");
}

TEST_F(NestedTest, ATypeWithinItselfIsRefused) {
  EXPECT_EQ(problem("int8 x\nExample[] inner"),
            "2 inner: my_msgs/msg/Example > my_msgs/msg/Example: recursive types are not supported: hold all "
            "nodes in one sequence and refer to them by index");
}

TEST_F(NestedTest, ATypeWithinAnotherWithinItselfIsRefused) {
  write("a/my_msgs/msg/A.msg", "other/B b");
  write("a/other/msg/B.msg", "my_msgs/Example x");
  EXPECT_EQ(
      problem("A a"),
      "1 a: my_msgs/msg/Example > my_msgs/msg/A > other/msg/B > my_msgs/msg/Example: recursive types are "
      "not supported: hold all nodes in one sequence and refer to them by index");
}

TEST_F(NestedTest, RecursionAmongOthersIsLeftToThem) {
  write("a/my_msgs/msg/A.msg", "B b");
  write("a/my_msgs/msg/B.msg", "A a");
  EXPECT_THAT(files("A a"), ElementsAre("a/my_msgs/msg/A.msg", "a/my_msgs/msg/B.msg"));
}

TEST_F(NestedTest, WhatIsWrongInANestedFileIsLeftToIt) {
  write("a/my_msgs/msg/A.msg", "?");
  EXPECT_THAT(files("A a"), ElementsAre("a/my_msgs/msg/A.msg"));
}

TEST_F(NestedTest, ADirectoryIsNoType) {
  fs::create_directories(root_ / "a/my_msgs/msg/A.msg");
  EXPECT_NE(problem("A a"), "");
}

TEST_F(NestedTest, TooManyLevelsAreRefused) {
  for (int i = 0; i < 300; ++i)
    write("a/my_msgs/msg/A" + std::to_string(i) + ".msg", "A" + std::to_string(i + 1) + " a");
  EXPECT_EQ(problem("A0 a"), "1 a: messages are nested over more than 256 levels");
}

TEST_F(NestedTest, NothingIsReadForPrimitiveTypes) { EXPECT_THAT(files("int8 x\nstring y"), IsEmpty()); }

}  // namespace
}  // namespace sft::msg
