// Reading the SQLite files of rosbag2, valid, damaged and hostile ones.
#include <sqlite3.h>

#include "tests/support/recorded_data.h"
#include "tests/tools/recording/recorded_file.h"

namespace sft::recording {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Db3Test : public ::testing::Test {
 protected:
  std::string path() const { return (folder_.path() / "a%20?b.db3").string(); }

  void run(const char* sql) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(path().c_str(), &database), SQLITE_OK);
    char* fault = nullptr;
    EXPECT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, &fault), SQLITE_OK) << fault;
    sqlite3_close(database);
  }

  static constexpr const char* tables =
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);"
      "INSERT INTO topics VALUES(4, '/a', 'std_msgs/msg/String', 'cdr');"
      "INSERT INTO topics VALUES(9, '/b', 'std_msgs/msg/String', 'cdr');"
      "INSERT INTO messages VALUES(1, 4, 20, x'01'), (2, 9, 10, x'02'), (3, 4, 30, x'03'), (4, 5, 40, "
      "x'04');";

  test::TemporaryDirectory folder_;
};

TEST_F(Db3Test, MessagesComeInTheOrderOfTime) {
  run(tables);
  const auto bag = open_recording(path());
  ASSERT_TRUE(bag) << bag.error().message;
  EXPECT_EQ(all_of(**bag), (std::vector<Kept>{{2, 0, 10, "\x02"}, {1, 0, 20, "\x01"}, {1, 0, 30, "\x03"}}));
  EXPECT_THAT((*bag)->faults(), ::testing::ElementsAre(HasSubstr("topic 5 has messages")));
  EXPECT_EQ((*bag)->overview().messages, 3U);
  const std::set<std::uint16_t> only{1};
  (*bag)->rewind(21, &only);
  EXPECT_EQ(all_of(**bag).size(), 1U);
}

TEST_F(Db3Test, OtherTablesAreNoRecording) {
  run("CREATE TABLE topics(id INTEGER); CREATE VIEW messages AS WITH RECURSIVE n(i) AS "
      "(SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i FROM n;");
  const auto bag = open_recording(path());
  ASSERT_FALSE(bag);
  EXPECT_THAT(bag.error().message,
              HasSubstr("is no recording of rosbag2: it has no tables 'topics' and 'messages'"));
}

TEST_F(Db3Test, MissingColumnsAreNamed) {
  run("CREATE TABLE topics(id INTEGER); CREATE TABLE messages(id INTEGER);");
  const auto bag = open_recording(path());
  ASSERT_TRUE(bag);
  EXPECT_THAT(all_of(**bag), IsEmpty());
  EXPECT_THAT((*bag)->faults(), Contains(HasSubstr("no such column")));
}

TEST_F(Db3Test, OfVeryManyTopicsThoseThatFitAreReadWithTheirDefinitionsAndTheRestIsNamed) {
  run(tables);
  run("WITH RECURSIVE n(i) AS (SELECT 10 UNION ALL SELECT i + 1 FROM n WHERE i < 70000) "
      "INSERT INTO topics SELECT i, '/t' || i, 'a/msg/A' || i, 'cdr' FROM n;"
      "CREATE TABLE message_definitions(topic_type TEXT, encoding TEXT, encoded_message_definition TEXT);"
      "INSERT INTO message_definitions SELECT type, 'ros2msg', 'int8 a' FROM topics;");
  const auto bag = open_recording(path());
  ASSERT_TRUE(bag) << bag.error().message;
  EXPECT_EQ((*bag)->channels().size(), 65535U);
  EXPECT_THAT((*bag)->faults(), Contains(HasSubstr("more than 65535 topics")));
  for (const auto& [id, schema] : (*bag)->schemas()) ASSERT_EQ(schema.data, "int8 a") << schema.name;
}

TEST_F(Db3Test, ADamagedFileIsReadAsFarAsItGoes) {
  run(tables);
  std::string content;
  {
    std::ifstream file(path(), std::ios::binary);
    content.assign(std::istreambuf_iterator(file), {});
  }
  std::ofstream(path(), std::ios::binary) << content.substr(0, content.size() - 4096);
  const auto bag = open_recording(path());
  if (!bag) return;
  (void)all_of(**bag);
  (*bag)->check();
  EXPECT_THAT((*bag)->faults(), Contains(HasSubstr("SQLite: ")));
}

struct RecordedDb3 {
  const char* file;
  std::uint64_t messages;
};
class RecordedDb3s : public ::testing::TestWithParam<RecordedDb3> {};

TEST_P(RecordedDb3s, AreReadToTheirEnd) {
  const auto file = test::recorded_data() / "rosbag2" / GetParam().file;
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "there is no " << file;
  const auto bag = open_recording(file.string());
  ASSERT_TRUE(bag) << bag.error().message;
  EXPECT_EQ((*bag)->overview().messages, GetParam().messages);
  const std::vector<Kept> found = all_of(**bag);
  EXPECT_EQ(found.size(), GetParam().messages);
  EXPECT_TRUE(std::ranges::is_sorted(found, {}, &Kept::log_ns));
  (*bag)->check();
  EXPECT_THAT((*bag)->faults(), IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(Rosbag2, RecordedDb3s,
                         ::testing::Values(RecordedDb3{"neato_drive_square", 2091},
                                           RecordedDb3{"neato_obstacle-avoider/obstacle-avoider_0.db3", 1545},
                                           RecordedDb3{"plotjuggler_test/rosbag2_test_0.db3", 4695},
                                           RecordedDb3{"ros2_rosbag2_tests/cdr_test_0.db3", 7}));

}  // namespace
}  // namespace sft::recording
