// An unmodified DDS writer on one host and an unmodified reader on another, with a bridge beside each.
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/pace.h"
#include "tests/support/xyz_cloud.h"
#include "tests/system/vanilla_fixture.h"

namespace sft::test {
namespace {

/// A process of `sft bridge` on a host.
class BridgeProcess {
 public:
  BridgeProcess(const hosts::NetworkNamespace& host, std::vector<std::string> words) {
    const std::string program = program_directory() + "/sft";
    words.insert(words.begin(), {program, "bridge"});
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    process_ = fork();
    if (process_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (host.enter()) execv(program.c_str(), pointers.data());
    _exit(3);
  }
  ~BridgeProcess() {
    if (process_ > 0) end();
  }
  BridgeProcess(const BridgeProcess&) = delete;
  BridgeProcess& operator=(const BridgeProcess&) = delete;

  /// Ends it as Ctrl-C does, and returns its exit code.
  int end() {
    int status = 0;
    kill(process_, SIGINT);
    waitpid(std::exchange(process_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t process_ = -1;
};

/// The robot is the first host, with DDS domain 31, and the station the second one, with 32.
class BridgeOfHostsTest : public VanillaTest {
 protected:
  /// The processes of DDS take their domain from the environment.
  static void use_domain(const char* domain) { setenv("ROS_DOMAIN_ID", domain, 1); }
};

TEST_F(BridgeOfHostsTest, CloudsOfAnUnmodifiedWriterReachAnUnmodifiedReaderBehindTwoBridges) {
  use_domain("31");
  VanillaWriter writer(network_.host(0), {.kind = "points"});
  use_domain("32");
  VanillaReader reader(network_.host(1), {});
  BridgeProcess robot(network_.host(0), {"--from", "31", "--to", "33", "--to-dds", "never", "--type",
                                         "sensor_msgs/PointCloud2", "points -> robot/points"});
  BridgeProcess station(network_.host(1), {"--from", "33", "--from-dds", "never", "--to", "32",
                                           "robot/points{data{x,y,z}}[::4] -> points"});
  ASSERT_TRUE(writer.matches(1) && reader.matches(1));
  std::uint32_t number = 0;
  std::optional<Ticker> ticker(std::in_place, 50ms,
                               [&](std::uint32_t) { writer.write_cloud(++number, points); });
  for (int i = 0; i < 5; ++i) {
    const auto sample = reader.take();
    ASSERT_FALSE(sample.body.empty());
    const auto sent = xyz_cloud(static_cast<std::uint32_t>(sample.body[0]));
    auto expected = sent;
    expected.width = points / 4;
    expected.point_step = 12;
    expected.row_step = points / 4 * 12;
    expected.fields.resize(3);
    expected.data = thinned(sent);
    EXPECT_EQ(sample.body, body_of(expected));
  }
  ticker.reset();
  EXPECT_EQ(robot.end(), 0);
  EXPECT_EQ(station.end(), 0);
}

}  // namespace
}  // namespace sft::test
