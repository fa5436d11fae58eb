// Tests of the whole program. The program leaves no files or processes behind, whichever way it ends.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "core/platform/file_descriptor.h"
#include "tests/support/temporary_directory.h"

namespace sft::demo {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using Clock = std::chrono::steady_clock;

/// Runs sft_demo in a separate process. Processes that sft_demo leaves behind become children of the test.
class RunningDemo {
 public:
  enum class On { pipe, terminal };
  enum class As { this_user, ordinary_user };
  explicit RunningDemo(std::vector<std::string> arguments, On on = On::pipe, As as = As::this_user) {
    prctl(PR_SET_CHILD_SUBREAPER, 1);
    int ends[2];
    const winsize size{.ws_row = 24, .ws_col = 80, .ws_xpixel = 0, .ws_ypixel = 0};
    if ((on == On::pipe ? pipe(ends) : openpty(&ends[0], &ends[1], nullptr, nullptr, &size)) != 0) return;
    if (on == On::terminal) fcntl(ends[0], F_SETFD, FD_CLOEXEC);
    output_ = core::FileDescriptor(ends[0]);
    const core::FileDescriptor written(ends[1]);
    process_ = fork();
    if (process_ == 0) execute(std::move(arguments), written.get(), as);
  }
  ~RunningDemo() {
    if (process_ > 0) kill(process_, SIGKILL);
    nothing_is_left();
  }

  /// Reads standard output and standard error until the program has printed the text or has ended. Returns
  /// true if it has printed the text.
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
  /// Waits until the program has published samples, and then interrupts the program, since a whole run
  /// takes longer. Returns the exit code.
  int publish_and_stop() {
    if (prints("published; ")) send(SIGINT);
    return wait_for_end();
  }
  /// Waits for the end of the program. Returns its exit code, or minus the signal that ended it.
  int wait_for_end() {
    // Waits for a text that the program never prints, and so reads all output until the end.
    prints(std::string(1, '\0'));
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) continue;
    process_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  /// Returns true if all processes that the program has started have ended, or end within 15 s.
  static bool nothing_is_left() {
    for (const auto deadline = Clock::now() + 15s; Clock::now() < deadline;) {
      const pid_t gone = waitpid(-1, nullptr, WNOHANG);
      if (gone < 0 && errno == ECHILD) return true;
      if (gone == 0) poll(nullptr, 0, 10);
    }
    return false;
  }
  const std::string& text() const { return text_; }

  static constexpr int cannot_run = 127;

 private:
  [[noreturn]] static void execute(std::vector<std::string> arguments, int output, As as) {
    constexpr uid_t nobody = 65534;
    if (as == As::ordinary_user && (setgroups(0, nullptr) != 0 || setgid(nobody) != 0 || setuid(nobody) != 0))
      _exit(cannot_run);

    dup2(output, STDOUT_FILENO);
    dup2(output, STDERR_FILENO);
    arguments.insert(arguments.begin(), SFT_DEMO_PATH);
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    execv(SFT_DEMO_PATH, pointers.data());
    _exit(cannot_run);
  }

  core::FileDescriptor output_;
  pid_t process_ = -1;
  std::string text_;
};

TEST(Demo, EndsEarlyOnCtrlCWithTheSummaryAndTheFigures) {
  const test::TemporaryDirectory directory;
  const auto json = directory.path() / "figures.json";
  RunningDemo demo({"--seconds", "600", "--json", json.native()});
  ASSERT_TRUE(demo.prints("published; ")) << demo.text();
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
  ASSERT_TRUE(demo.prints("published; ")) << demo.text();
  demo.send(SIGKILL);
  EXPECT_EQ(demo.wait_for_end(), -SIGKILL);
  EXPECT_TRUE(demo.nothing_is_left());
}

/// The content of a terminal of 24 rows after the text was printed to it, and the longest line that was on
/// the terminal at any time.
class Screen {
 public:
  explicit Screen(const std::string& text) {
    const std::regex control("\x1b\\[([0-9;]*)([A-Za-z])");
    auto from = text.cbegin();
    for (std::sregex_iterator it(text.begin(), text.end(), control), end; it != end; ++it) {
      print(std::string(from, (*it)[0].first));
      if (*(*it)[2].first == 'K') rows_.back().clear();
      colours_ = colours_ || *(*it)[2].first == 'm';
      from = (*it)[0].second;
    }
    print(std::string(from, text.cend()));
  }
  const std::vector<std::string>& rows() const { return rows_; }
  std::size_t longest() const { return longest_; }
  bool colours() const { return colours_; }

 private:
  void print(const std::string& text) {
    for (const char c : text) {
      if (c == '\n') {
        rows_.emplace_back();
      } else if (c != '\r') {
        rows_.back() += c;
      }
      longest_ = std::max(longest_, rows_.back().size());
    }
  }

  std::vector<std::string> rows_{""};
  std::size_t longest_ = 0;
  bool colours_ = false;
};

TEST(Demo, FitsATerminalOf80ColumnsAnd24Rows) {
  RunningDemo demo({"--seconds", "600"}, RunningDemo::On::terminal);
  EXPECT_EQ(demo.publish_and_stop(), 0) << demo.text();
  const Screen screen(demo.text());
  EXPECT_LE(screen.longest(), 79U) << demo.text();
  EXPECT_TRUE(screen.colours()) << demo.text();
  const auto& rows = screen.rows();
  const auto table =
      std::find_if(rows.begin(), rows.end(), [](const auto& r) { return r.starts_with("name "); });
  EXPECT_LE(rows.end() - table, 24) << "with the row of the prompt";
  const auto result =
      std::find_if(table, rows.end(), [](const auto& r) { return r.find(" carried ") != r.npos; });
  ASSERT_NE(result, rows.end()) << demo.text();
  EXPECT_THAT(*result, testing::MatchesRegex(
                           "(The network|UDP) carried .* instead of .*: [0-9.]+ % saved; nothing lost."));
}

TEST(Demo, HasNoColoursAndReplacesNothingWhereThereIsNoTerminal) {
  RunningDemo demo({"--seconds", "600"});
  EXPECT_EQ(demo.publish_and_stop(), 0) << demo.text();
  EXPECT_THAT(demo.text(), Not(HasSubstr("\x1b")));
  EXPECT_LE(Screen(demo.text()).longest(), 79U) << demo.text();
}

TEST(Demo, SaysWhatItWaitsForUntilTheFirstCloud) {
  RunningDemo demo({"--seconds", "600"});
  ASSERT_TRUE(demo.prints("published; ")) << demo.text();
  EXPECT_THAT(demo.text(), AllOf(HasSubstr("Setting up the hosts ..."), HasSubstr("Not served yet: ")));
}

TEST(Demo, StopsOnCtrlCWhileItWaits) {
  RunningDemo demo({"--seconds", "600"});
  ASSERT_TRUE(demo.prints("Not served yet: ")) << demo.text();
  demo.send(SIGINT);
  EXPECT_EQ(demo.wait_for_end(), 1) << demo.text();
  EXPECT_THAT(demo.text(), HasSubstr("stopped before anything was published"));
  EXPECT_TRUE(demo.nothing_is_left());
}

/// An ordinary user gets separate simulated hosts if user namespaces are allowed. Otherwise the demo uses
/// loopback.
TEST(Demo, RunsForAnOrdinaryUserToo) {
  RunningDemo demo({"--seconds", "600"}, RunningDemo::On::pipe, RunningDemo::As::ordinary_user);
  const int code = demo.publish_and_stop();
  if (code == RunningDemo::cannot_run)
    GTEST_SKIP() << "only root can become another user, who has to be able to read the build tree";
  EXPECT_EQ(code, 0) << demo.text();
  EXPECT_THAT(demo.text(), AllOf(HasSubstr("hosts"), HasSubstr(" % saved; nothing lost.")));
  EXPECT_TRUE(demo.nothing_is_left());
}

TEST(Demo, HasAHelpThatFitsATerminal) {
  RunningDemo demo({"--help"});
  EXPECT_EQ(demo.wait_for_end(), 0);
  const Screen screen(demo.text());
  EXPECT_LE(screen.longest(), 79U) << demo.text();
  EXPECT_LE(screen.rows().size(), 24U) << demo.text();
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
