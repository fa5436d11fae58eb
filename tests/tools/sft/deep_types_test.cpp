// Types as large and as deep as those of V2X are announced together with their fields. Samples of larger or
// deeper types can be read only with their definitions, but can be measured without them.
#include <filesystem>
#include <fstream>
#include <span>
#include <sstream>

#include "tests/tools/sft/tool_fixture.h"

namespace sft::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* root_type = "deep_msgs/L1";

/// A directory with the package deep_msgs, in which L1 nests L2, L2 nests L3, and so on. Each of these
/// types also has `fields` ordinary fields.
class Definitions {
 public:
  Definitions(int levels, int fields) {
    fs::create_directories(root_ / "deep_msgs/msg");
    for (int level = 1; level <= levels; ++level) {
      std::ofstream file(root_ / ("deep_msgs/msg/L" + std::to_string(level) + ".msg"));
      for (int i = 0; i < fields; ++i) file << "uint8 a_field_with_a_long_name_" << i << "\n";
      if (level < levels) file << "L" << level + 1 << "[] inner\n";
      if (level == levels) file << "string word\n";
    }
  }
  ~Definitions() { fs::remove_all(root_); }
  Definitions(const Definitions&) = delete;
  Definitions& operator=(const Definitions&) = delete;

  std::string directory() const { return root_; }
  DynamicType type() const {
    return find_msg(root_type, std::span(&root_, 1), {.bytes = std::size_t{1} << 20, .depth = 64}).value();
  }

 private:
  const fs::path root_ = fs::temp_directory_path() / ("sft_deep_" + std::to_string(getpid()));
};

/// Returns a value of the outermost type as JSON, with a word in its innermost struct.
std::string nested_word(int levels, const std::string& word) {
  std::string json = R"({"word":")" + word + R"("})";
  for (int level = 1; level < levels; ++level) json = R"({"inner":[)" + json + "]}";
  return json;
}

class DeepTypesTest : public ToolTest {
 protected:
  DynamicPublisher keep(const Definitions& definitions, const std::string& json) {
    auto publisher = robot.publisher("deep", definitions.type(), {.durability = transient_local}).value();
    EXPECT_TRUE(publisher.publish_json(json));
    return publisher;
  }
};

TEST_F(DeepTypesTest, OneOf32LevelsAndTensOfKilobytesIsEchoedAndPrinted) {
  const Definitions definitions(32, 40);
  ASSERT_GT(definitions.type().description().size(), 30'000U);
  const auto publisher = keep(definitions, nested_word(32, "deepest"));
  const Ended echo = run_tool({"echo", "deep", "--once", "--json"});
  EXPECT_EQ(echo.code, 0) << echo.err;
  EXPECT_THAT(echo.out, HasSubstr(R"("word":"deepest")"));
  const Ended yaml = run_tool({"echo", "deep", "--once", "--full"});
  EXPECT_THAT(yaml.out, HasSubstr("word: deepest")) << yaml.err;
  const Ended type = run_tool({"type", "deep"});
  EXPECT_EQ(type.code, 0) << type.err;
  EXPECT_THAT(type.out, HasSubstr("MSG: deep_msgs/L32\n"));
}

TEST_F(DeepTypesTest, OneOf32LevelsIsPublished) {
  const Definitions definitions(32, 2);
  const auto subscriber = robot.subscriber("deep", definitions.type(), "*").value();
  const Ended pub =
      run_tool({"pub", "deep", root_type, nested_word(32, "x"), "--once", "-I", definitions.directory()});
  EXPECT_EQ(pub.code, 0) << pub.err;
}

TEST_F(DeepTypesTest, OneThatIsTooDeepToBeDescribedIsReadWithItsDefinition) {
  const Definitions definitions(40, 1);
  const auto publisher = keep(definitions, nested_word(40, "deepest"));
  const Ended refused = run_tool({"echo", "deep", "--once"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.err, HasSubstr("the fields of deep_msgs::msg::L1 are not known here"));
  EXPECT_THAT(refused.err, HasSubstr("-I DIRECTORY"));
  const Ended echo = run_tool({"echo", "deep", "--once", "--json", "-I", definitions.directory()});
  EXPECT_EQ(echo.code, 0) << echo.err;
  EXPECT_THAT(echo.out, HasSubstr(R"("word":"deepest")"));
}

TEST_F(DeepTypesTest, AnotherDefinitionOfThatNameIsNamed) {
  const Definitions definitions(40, 1);
  const auto publisher = keep(definitions, "{}");
  std::ofstream(fs::path(definitions.directory()) / "deep_msgs/msg/L40.msg") << "int32 number\n";
  const Ended echo = run_tool({"echo", "deep", "--once", "-I", definitions.directory()});
  EXPECT_EQ(echo.code, 2);
  EXPECT_THAT(echo.err, HasSubstr("the files define another deep_msgs::msg::L1 than node 'lidar' has"));
}

TEST_F(DeepTypesTest, TheRateOfOneThatIsTooDeepIsThatWhichItsPublisherCounts) {
  const Definitions definitions(40, 1);
  auto publisher = robot.publisher("deep", definitions.type()).value();
  Node other = open("other");
  const auto subscriber = other.subscriber("deep", definitions.type(), "*").value();
  ASSERT_TRUE(publisher.wait_for_subscribers(1, hang_timeout));
  const Ticker publishing(20ms, [&](std::uint32_t) { EXPECT_TRUE(publisher.publish_json("{}")); });
  for (const char* command : {"hz", "bw"}) {
    const Ended ended = run_tool({command, "deep", "--json", "--for", "12"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("what its publishers count is shown instead"));
    std::istringstream lines(ended.out);
    std::uint64_t samples = 0, new_ones = 0;
    for (std::string line; std::getline(lines, line);) {
      const Json json = Json::parse(line);
      samples = json["samples"];
      new_ones += json.value("new", std::uint64_t{0});
    }
    EXPECT_GT(samples, 0U);
    EXPECT_LE(samples, publisher.status().published) << "each is counted once";
    if (std::string_view(command) == "hz") {
      EXPECT_EQ(samples, new_ones) << "all since the beginning";
    }
  }
}

TEST_F(DeepTypesTest, ThatNothingWasSentOfOneThatIsTooDeepIsToldAlsoByTheExitCode) {
  const Definitions definitions(40, 1);
  const auto publisher = robot.publisher("deep", definitions.type()).value();
  const Ended ended = run_tool({"hz", "deep", "--for", "1.5"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.out, HasSubstr("deep: its publishers have sent no sample to a subscriber yet\n"));
}

}  // namespace
}  // namespace sft::test
