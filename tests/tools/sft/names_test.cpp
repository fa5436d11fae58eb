// Two nodes with the same name in two namespaces, and rules for their topics, as sft shows them.
#include <cstdlib>
#include <mutex>
#include <vector>

#include "tests/tools/sft/tool_fixture.h"

namespace sft::test {
namespace {

class NamesOfToolTest : public ToolTest {
 protected:
  NamesOfToolTest() { setenv("SFT_REMAP", "~/image:=raw /left/cam:info:=a cam:=b nosuch:=c", 1); }
  ~NamesOfToolTest() override { unsetenv("SFT_REMAP"); }

  Node cam(const std::string& space) {
    NodeOptions options{.name = "cam", .namespace_ = space, .transport = TransportChoice::udp};
    options.log = [this](LogLevel level, std::string_view line) {
      const std::scoped_lock lock(mutex_);
      if (level >= LogLevel::warning && line.find("remapping") != line.npos) warnings_.emplace_back(line);
    };
    return Node::open(options).value();
  }
  std::vector<std::string> warnings() {
    const std::scoped_lock lock(mutex_);
    return warnings_;
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> warnings_;
};

TEST_F(NamesOfToolTest, EachRuleAppliesWhereItFitsAndOneLineNamesTheOneThatFitsNowhere) {
  std::vector<Publisher<PointCloud2>> publishers;
  {
    Node left = cam("/left"), right = cam("/right");
    for (Node* node : {&left, &right}) {
      for (const char* topic : {"~/image", "info", "cam", "/clock"})
        publishers.push_back(node->publisher<PointCloud2>(topic).value());
    }
    EXPECT_EQ(run_tool({"ls", "--names"}).out,
              "clock\nleft/a\nleft/b\nleft/raw\nright/b\nright/info\nright/raw\n");
    EXPECT_EQ(run_tool({"ls", "nodes", "--names"}).out, "left/cam\nright/cam\n");
    publishers.clear();
  }
  EXPECT_TRUE(eventually([&] { return !warnings().empty(); }));
  const std::vector<std::string> lines = warnings();
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_THAT(lines[0],
              HasSubstr("the remapping rule 'nosuch:=c' fits no topic and no node of this program"));
}

TEST_F(NamesOfToolTest, ATopicThatWasRenamedIsShownWithBothNames) {
  Node left = cam("left");
  const auto image = left.publisher<PointCloud2>("~/image").value(),
             clock = left.publisher<PointCloud2>("/clock").value();
  EXPECT_THAT(run_tool({"info", "left/raw"}).out, HasSubstr("    called     ~/image by its program\n"));
  const auto given = [](const char* topic) {
    return Json::parse(run_tool({"info", topic, "--json"}).out)["publishers"][0]["given_topic"];
  };
  EXPECT_EQ(given("left/raw"), "~/image");
  EXPECT_TRUE(given("clock").is_null());
}

TEST_F(NamesOfToolTest, RulesForProgramsChangeNoNameOfTheTool) {
  const auto publisher = robot.publisher<PointCloud2>("cam").value();
  const Ended ended = run_tool({"type", "cam", "--name"});
  EXPECT_EQ(ended.out, "sensor_msgs/msg/PointCloud2\n");
  EXPECT_EQ(ended.err, "");
}

}  // namespace
}  // namespace sft::test
