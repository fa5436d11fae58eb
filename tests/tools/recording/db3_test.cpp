// Reading the SQLite files of rosbag2, valid, damaged and hostile ones.
#include <sqlite3.h>

#include <random>

#include "tests/support/recorded_data.h"
#include "tests/support/test_seed.h"
#include "tests/tools/recording/recorded_file.h"

namespace sft::recording {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Db3Test : public ::testing::Test {
 protected:
  std::string path() const { return (folder_.path() / "a%20?b.db3").string(); }

  void run(const std::string& sql) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(path().c_str(), &database), SQLITE_OK);
    char* fault = nullptr;
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &fault), SQLITE_OK) << fault;
    sqlite3_close(database);
  }

  std::string content() const {
    std::ifstream file(path(), std::ios::binary);
    return {std::istreambuf_iterator(file), {}};
  }

  /// A number of three bytes as files of SQLite have it.
  static std::string in_sqlite(std::uint32_t number) {
    return {static_cast<char>(0x80 | number >> 14), static_cast<char>(0x80 | (number >> 7 & 0x7f)),
            static_cast<char>(number & 0x7f)};
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

TEST_F(Db3Test, SqliteTakesNoMemoryForALargeMessage) {
  constexpr std::size_t bytes = 20'000'000;
  run(tables);
  run("INSERT INTO messages VALUES(5, 4, 25, zeroblob(" + std::to_string(bytes) + "))");
  sqlite3_memory_highwater(1);
  const auto bag = open_recording(path());
  ASSERT_TRUE(bag) << bag.error().message;
  const std::vector<Kept> found = all_of(**bag);
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(found[2].data.size(), bytes);
  (*bag)->check();
  EXPECT_LT(sqlite3_memory_highwater(0), static_cast<std::int64_t>(bytes / 4));
}

TEST_F(Db3Test, MessagesWhoseDataCannotBeReadAreNamedAndTheOthersAreRead) {
  run(tables);
  run("INSERT INTO messages VALUES(5, 4, 11, NULL), (6, 4, 12, 1.5), (7, 4, 13, 'text')");
  const auto bag = open_recording(path());
  ASSERT_TRUE(bag) << bag.error().message;
  EXPECT_EQ(all_of(**bag).size(), 4U);
  EXPECT_THAT((*bag)->faults(), Contains("message 5 is left out: SQLite: cannot open value of type null"));
  EXPECT_THAT((*bag)->faults(), Contains("message 6 is left out: SQLite: cannot open value of type real"));
}

TEST_F(Db3Test, AMessageThatClaimsToBeLongerThanTheFileTakesNoMemory) {
  constexpr std::uint32_t bytes = 300'000, claimed = 1'040'000, head = 9;
  run(tables);
  run("INSERT INTO messages VALUES(5, 4, 25, zeroblob(" + std::to_string(bytes) + "))");
  std::string changed = content();
  const auto replace = [&](const std::string& number, const std::string& by) {
    changed.replace(changed.find(number), number.size(), by);
  };
  replace(in_sqlite(2 * bytes + 12), in_sqlite(2 * claimed + 12));  // the type of the blob says its length
  replace(in_sqlite(bytes + head), in_sqlite(claimed + head));
  std::ofstream(path(), std::ios::binary) << changed;
  const auto bag = open_recording(path());
  ASSERT_TRUE(bag) << bag.error().message;
  EXPECT_EQ(all_of(**bag).size(), 3U);
  EXPECT_THAT((*bag)->faults(), Contains("message 5 is left out: it would be longer than the file"));
}

TEST_F(Db3Test, ADamagedFileIsReadAsFarAsItGoes) {
  run(tables);
  const std::string whole = content();
  std::ofstream(path(), std::ios::binary) << whole.substr(0, whole.size() - 4096);
  const auto bag = open_recording(path());
  if (!bag) return;
  (void)all_of(**bag);
  (*bag)->check();
  EXPECT_THAT((*bag)->faults(), Contains(HasSubstr("SQLite: ")));
}

/// Cyclic trees of pages, and rows that name other pages, are what damage makes of a file.
TEST_F(Db3Test, RandomDamageNeitherCrashesNorHangsAReader) {
  run(tables);
  run("WITH RECURSIVE n(i) AS (SELECT 10 UNION ALL SELECT i + 1 FROM n WHERE i < 200) "
      "INSERT INTO messages SELECT i, 4, i, zeroblob(100 * (i % 90)) FROM n;");
  const std::string whole = content();
  std::mt19937_64 random(test::test_seed());
  for (int round = 0; round < 200; ++round) {
    std::string damaged = whole;
    constexpr std::size_t head = 100;  // without it, nothing is opened
    for (unsigned i = 0; i < 1 + random() % 30; ++i)
      damaged[head + random() % (damaged.size() - head)] = static_cast<char>(random());
    std::ofstream(path(), std::ios::binary) << damaged;
    const auto bag = open_recording(path());
    if (!bag) continue;
    EXPECT_LE(all_of(**bag).size(), 10'000U);
    (*bag)->check();
    (void)(*bag)->overview();
  }
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
