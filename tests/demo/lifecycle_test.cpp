// The program as a whole: however it ends, it leaves nothing behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>

#include "examples/demo/descriptor.h"
#include "tests/demo/clouds.h"

namespace sft::demo {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

/// sft_demo in a process of its own. All processes that it leaves behind become children of the test.
class RunningDemo {
 public:
  explicit RunningDemo(std::vector<std::string> arguments) {
    prctl(PR_SET_CHILD_SUBREAPER, 1);
    int ends[2];
    if (pipe(ends) != 0) return;
    output_ = Descriptor(ends[0]);
    const Descriptor written(ends[1]);
    process_ = fork();
    if (process_ == 0) execute(std::move(arguments), written.get());
  }
  ~RunningDemo() {
    if (process_ > 0) kill(process_, SIGKILL);
    nothing_is_left();
  }

  /// Reads its output, standard error included, until it has printed that or has ended.
  bool prints(std::string_view expected) {
    const auto deadline = Clock::now() + 60s;
    while (text_.find(expected) == text_.npos) {
      pollfd readable{.fd = output_.get(), .events = POLLIN, .revents = 0};
      char part[1024];
      if (Clock::now() > deadline || poll(&readable, 1, 1000) < 0) return false;
      if (readable.revents == 0) continue;
      const ssize_t bytes = read(output_.get(), part, sizeof part);
      if (bytes <= 0) return false;
      text_.append(part, static_cast<std::size_t>(bytes));
    }
    return true;
  }
  void send(int signal) const { kill(process_, signal); }
  /// Its exit code, or minus the signal that ended it.
  int wait_for_end() {
    prints(std::string(1, '\0'));  // which it never does: all output until its end
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) continue;
    process_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  /// Whether everything that it has started is gone, or soon is.
  static bool nothing_is_left() {
    for (const auto deadline = Clock::now() + 15s; Clock::now() < deadline;) {
      const pid_t gone = waitpid(-1, nullptr, WNOHANG);
      if (gone < 0 && errno == ECHILD) return true;
      if (gone == 0) poll(nullptr, 0, 10);
    }
    return false;
  }
  const std::string& text() const { return text_; }

 private:
  [[noreturn]] static void execute(std::vector<std::string> arguments, int output) {
    dup2(output, STDOUT_FILENO);
    dup2(output, STDERR_FILENO);
    arguments.insert(arguments.begin(), SFT_DEMO_PATH);
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    execv(SFT_DEMO_PATH, pointers.data());
    _exit(127);
  }

  Descriptor output_;
  pid_t process_ = -1;
  std::string text_;
};

TEST(Demo, EndsEarlyOnCtrlCWithTheSummaryAndTheFigures) {
  const TemporaryDirectory directory;
  const auto json = directory.path() / "figures.json";
  RunningDemo demo({"--seconds", "600", "--json", json.native()});
  ASSERT_TRUE(demo.prints("published; received by")) << demo.text();
  demo.send(SIGINT);
  EXPECT_EQ(demo.wait_for_end(), 0) << demo.text();
  EXPECT_THAT(demo.text(), HasSubstr("The lidar published"));
  EXPECT_GE(nlohmann::json::parse(std::ifstream(json))["samples"], 1);
  EXPECT_TRUE(demo.nothing_is_left());
}

TEST(Demo, MayBeStoppedBeforeItPublishes) {
  RunningDemo demo({"--seconds", "1"});
  ASSERT_TRUE(demo.prints("hosts")) << demo.text();
  demo.send(SIGTERM);
  demo.wait_for_end();
  EXPECT_TRUE(demo.nothing_is_left());
}

TEST(Demo, LeavesNothingBehindWhenItIsKilled) {
  RunningDemo demo({"--seconds", "600"});
  ASSERT_TRUE(demo.prints("published; received by")) << demo.text();
  demo.send(SIGKILL);
  EXPECT_EQ(demo.wait_for_end(), -SIGKILL);
  EXPECT_TRUE(demo.nothing_is_left());
}

TEST(Demo, FailsOnInputThatItCannotRead) {
  const TemporaryDirectory directory;
  const auto truncated = directory.write("scan.bin", Bytes(15));
  RunningDemo demo({"--input", truncated.native()});
  EXPECT_EQ(demo.wait_for_end(), 1);
  EXPECT_THAT(demo.text(), HasSubstr("sft_demo: " + truncated.native() + ": 15 bytes"));
}

TEST(Demo, FailsAtOnceIfItCouldNotWriteTheFigures) {
  RunningDemo demo({"--json", "/nowhere/figures.json"});
  EXPECT_EQ(demo.wait_for_end(), 1);
  EXPECT_THAT(demo.text(), HasSubstr("/nowhere/figures.json cannot be written"));
}

TEST(Demo, FailsOnOptionsThatMakeNoSense) {
  for (const char* hz : {"0", "-1", "1e9", "fast"}) {
    RunningDemo demo({"--hz", hz});
    EXPECT_EQ(demo.wait_for_end(), 1) << hz;
    EXPECT_THAT(demo.text(), HasSubstr("--hz"));
  }
}

}  // namespace
}  // namespace sft::demo
