// The command sft shows two nodes with the same name in two namespaces, and rules for their topics.
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

TEST_F(NamesOfToolTest, ATopicThatIsNamedAsItsProgramDoesIsNotFoundAndItsFullNameIsSaid) {
  Node left = cam("left");
  const auto image = left.publisher<PointCloud2>("~/image").value(),
             points = left.publisher<PointCloud2>("points").value();
  for (const char* const command : {"why", "info", "echo", "type"}) {
    const Ended relative = run_tool({command, "points", "--timeout", "1"});
    EXPECT_EQ(relative.code, 1) << command;
    EXPECT_THAT(relative.err, HasSubstr("; did you mean 'left/points'?; node 'left/cam' calls the topic "
                                        "'left/points' so"));
    const Ended private_one = run_tool({command, "~/image", "--timeout", "1"});
    EXPECT_EQ(private_one.code, 2) << command;
    EXPECT_EQ(private_one.err,
              "sft: the topic '~/image' is private to a node: name it in full, as 'sft ls' does; node "
              "'left/cam' calls the topic 'left/raw' so\n");
  }
  EXPECT_EQ(run_tool({"pub", "~/image", "std_msgs/Empty", "--once"}).code, 2);
}

TEST_F(NamesOfToolTest, ANameThatRos2RefusesIsRefusedWithTheRule) {
  for (const char* const command : {"why", "info", "echo", "hz"}) {
    const Ended ended = run_tool({command, "my topic", "--timeout", "1"});
    EXPECT_NE(ended.code, 0) << command;
    EXPECT_THAT(ended.err, HasSubstr("topic 'my topic' has a character in it")) << command;
  }
  EXPECT_THAT(run_tool({"pub", "9lives", "std_msgs/Empty", "--once"}).err, HasSubstr("begins with a digit"));
}

TEST_F(NamesOfToolTest, ATopicThatIsMisspeltIsSuggested) {
  const auto publisher = robot.publisher<PointCloud2>("points").value();
  for (const char* const command : {"why", "info"}) {
    EXPECT_THAT(run_tool({command, "pints", "--timeout", "1"}).err, HasSubstr("did you mean 'points'?"))
        << command;
  }
}

TEST_F(NamesOfToolTest, ACommandWithAPeerSaysThatBothSidesNameEachOther) {
  const std::string both = "have to name this host as a peer, too";
  EXPECT_THAT(run_tool({"ls", "--domain", "17", "--peer", "127.0.0.9"}).err, HasSubstr(both));
  EXPECT_THAT(run_tool({"why", "points", "--timeout", "0.1", "--peer", "127.0.0.9"}).err, HasSubstr(both));
  EXPECT_THAT(run_tool({"why", "points", "--timeout", "0.1"}).err, ::testing::Not(HasSubstr(both)));
}

TEST_F(NamesOfToolTest, RulesForProgramsChangeNoNameOfTheTool) {
  const auto publisher = robot.publisher<PointCloud2>("cam").value();
  const Ended ended = run_tool({"type", "cam", "--name"});
  EXPECT_EQ(ended.out, "sensor_msgs/msg/PointCloud2\n");
  EXPECT_EQ(ended.err, "");
}

}  // namespace
}  // namespace sft::test
