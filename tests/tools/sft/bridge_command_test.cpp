// What the verb bridge says of its command line and its files.
#include <fstream>

#include "tests/support/temporary_directory.h"
#include "tests/tools/sft/tool_fixture.h"

namespace sft::test {
namespace {

TEST(BridgeCommandTest, RulesThatCannotWorkAreRefusedInASentence) {
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "bridge.toml").string();
  std::ofstream(file) << "[[side]]\ndomain = 41\n[[side]]\ndomain = 42\nradio = true\n";
  struct Wrong {
    std::vector<std::string> words;
    const char* says;
  };
  const std::vector<Wrong> wrong{
      {{"--from", "5", "--to", "5", "chatter"}, "both sides are in domain 5"},
      {{"--from", "5", "--to", "6"}, "name rules"},
      {{"--from", "5", "--to", "6", "chatter", "chatter -> chatter"}, "twice: remove one of them"},
      {{"--from", "5", "--to", "6", "chatter <-> chatter", "chatter <- chatter"}, "twice"},
      {{"--from", "5", "--to", "6", "points->robot/points"}, "is no name of a topic; write TOPIC -> NAME"},
      {{"--from", "5", "--to", "6", "camera/* -> robot/camera"}, "both names have a *, or none"},
      {{"--from", "5", "--to", "6", "points{data{x -> robot/points"}, "a brace is not closed"},
      {{"--from", "5", "--to", "6", "points{data{x}, width}[::4] -> p"}, "for a single field"},
      {{"--from", "5", "--to", "6", "points", "--priority", "points=high"}, "write TOPIC=NUMBER"},
      {{"--from", "5", "--to", "6", "points", "--priority", "points=101"}, "a number from -100 to 100"},
      {{"--from", "5", "--to", "6", "points", "--priority", "points=-101"}, "a number from -100 to 100"},
      {{"--from", "5", "--to", "6", "points", "--priority", "imu=1"}, "no rule has the topic 'imu'"},
      {{"-f", file, "chatter"}, "bridge.toml:5: 'radio' is no key here; there are name, domain"}};
  for (Wrong one : wrong) {
    SCOPED_TRACE(one.says);
    one.words.insert(one.words.begin(), "bridge");
    const Ended ended = run_tool(one.words);
    EXPECT_EQ(ended.code, 2);
    EXPECT_THAT(ended.err, StartsWith("sft: "));
    EXPECT_THAT(ended.err, HasSubstr(one.says));
  }
}

TEST(BridgeCommandTest, TheFilesOfTheExampleAreRead) {
  for (const char* file : {"robot.toml", "station.toml"}) {
    const Ended ended =
        run_tool({"bridge", "-f", std::string(SFT_EXAMPLES) + "/bridge/" + file, "--for", "0.5", "--json"});
    EXPECT_EQ(ended.code, 1) << "nothing was there to be carried: " << ended.err;
    EXPECT_EQ(Json::parse(ended.out)["rules"].size(), 3U);
  }
}

}  // namespace
}  // namespace sft::test
