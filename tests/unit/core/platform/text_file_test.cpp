// Text files that a user names. What is no text file is refused, and is never waited for.
#include "core/platform/text_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <string>

#include "tests/support/temporary_directory.h"

namespace sft::core {
namespace {

class TextFileTest : public testing::Test {
 protected:
  std::string path(const char* name) const { return (directory_.path() / name).string(); }
  static std::string refusal(const std::string& path) {
    const Result<std::string> text = read_text_file(path);
    return text ? "" : text.error().message;
  }

 private:
  test::TemporaryDirectory directory_;
};

TEST_F(TextFileTest, ATextIsReadWhole) {
  std::ofstream(path("text")) << "one\ntwo";
  EXPECT_EQ(read_text_file(path("text")), "one\ntwo");
  std::ofstream(path("empty"));
  EXPECT_EQ(read_text_file(path("empty")), "");
  EXPECT_NE(read_text_file("/proc/self/status").value(), "") << "a file whose size is said to be 0";
}

TEST_F(TextFileTest, WhatIsNoTextFileIsRefusedByName) {
  EXPECT_EQ(refusal(path("none")), path("none") + ": No such file or directory");
  EXPECT_EQ(refusal("/tmp"), "/tmp: this is a directory, not a text file");
  EXPECT_EQ(refusal("/dev/zero"), "/dev/zero: this is not a text file");
  ASSERT_EQ(mkfifo(path("fifo").c_str(), 0600), 0);
  EXPECT_EQ(refusal(path("fifo")), path("fifo") + ": this is not a text file");
}

TEST_F(TextFileTest, ATextOfMoreThanAMebibyteIsRefused) {
  std::ofstream(path("text")) << std::string(1 << 20, 'a');
  EXPECT_EQ(refusal(path("text")), "");
  std::ofstream(path("text"), std::ios::app) << 'a';
  EXPECT_EQ(refusal(path("text")), path("text") + ": this is longer than 1 MiB");
}

}  // namespace
}  // namespace sft::core
