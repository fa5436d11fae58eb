// Several recordings are read as one. The thread that reads ahead takes limited memory, and gives it back.
#include "tools/sft/played_files.h"

#include <gmock/gmock.h>

#include <atomic>

#include "tests/support/eventually.h"

namespace sft::tool {
namespace {

using ::testing::ElementsAre;

/// A recording in memory, whose messages have these times. Its sequences are their indexes.
class ListedRecording final : public recording::Recording {
 public:
  explicit ListedRecording(std::vector<std::uint64_t> times, std::size_t bytes = 1)
      : times_(std::move(times)), data_(bytes) {}

  std::string format() const override { return "list"; }
  const recording::Overview& overview() override { return overview_; }
  void rewind(std::uint64_t from_ns, const std::set<std::uint16_t>*) override {
    at_ = static_cast<std::size_t>(std::ranges::lower_bound(times_, from_ns) - times_.begin());
  }
  std::optional<recording::Message> next() override {
    if (at_ == times_.size()) return std::nullopt;
    ++given;
    const auto sequence = static_cast<std::uint32_t>(at_);
    return recording::Message{.sequence = sequence, .log_ns = times_[at_++], .data = data_};
  }
  void check() override {}

  std::atomic<std::size_t> given{0};  ///< messages that were read

 private:
  std::vector<std::uint64_t> times_;
  std::vector<std::byte> data_;
  std::size_t at_ = 0;
  recording::Overview overview_;
};

class PlayedFilesTest : public ::testing::Test {
 protected:
  using Times = std::vector<std::uint64_t>;

  static PlayedFiles files_of(const std::vector<Times>& times) {
    std::vector<std::unique_ptr<recording::Recording>> files;
    for (const Times& one : times) files.push_back(std::make_unique<ListedRecording>(one));
    return PlayedFiles(std::move(files));
  }
  /// The rest of the messages, each as its time and the number of its file behind a point.
  static std::vector<std::string> rest_of(PlayedFiles& files) {
    std::vector<std::string> all;
    while (const auto message = files.next())
      all.push_back(std::to_string(message->message.log_ns) + "." + std::to_string(message->file));
    return all;
  }
};

TEST_F(PlayedFilesTest, MessagesComeInTheOrderOfTheirTimesAndOfEqualOnesThatOfTheFirstFile) {
  PlayedFiles files = files_of({{1, 5, 5}, {}, {0, 5, 9}});
  files.start(0, std::vector<std::set<std::uint16_t>>(3));
  EXPECT_THAT(rest_of(files), ElementsAre("0.2", "1.0", "5.0", "5.0", "5.2", "9.2"));
  EXPECT_FALSE(files.next()) << "the end stays the end";
}

TEST_F(PlayedFilesTest, AStartBeginsAtItsTimeWhateverWasReadBefore) {
  PlayedFiles files = files_of({{1, 3, 5}, {2, 4}});
  const std::vector<std::set<std::uint16_t>> only(2);
  files.start(0, only);
  EXPECT_EQ(files.next()->message.log_ns, 1U);
  files.start(3, only);
  EXPECT_THAT(rest_of(files), ElementsAre("3.0", "4.1", "5.0"));
  files.stop();
  std::vector<std::uint64_t> before;
  files.for_each_before(4, only, [&](const auto& message) { before.push_back(message.message.log_ns); });
  EXPECT_THAT(before, ElementsAre(1, 2, 3));
  files.start(0, only);
  EXPECT_EQ(rest_of(files).size(), 5U);
}

TEST_F(PlayedFilesTest, NoMoreThan64MebibytesAreReadAheadAndWhatWasTakenIsRoomForMore) {
  constexpr std::size_t count = 24, bytes = std::size_t{8} << 20, ahead = 8;
  std::vector<std::uint64_t> times(count);
  auto listed = std::make_unique<ListedRecording>(times, bytes);
  ListedRecording& file = *listed;
  std::vector<std::unique_ptr<recording::Recording>> files;
  files.push_back(std::move(listed));
  PlayedFiles played(std::move(files));
  const std::vector<std::set<std::uint16_t>> only(1);
  played.start(0, only);
  ASSERT_TRUE(test::eventually([&] { return file.given >= ahead; }));
  played.stop();
  file.given = 0;
  played.start(0, only);
  for (std::size_t taken = 0; taken < count; ++taken) {
    // Without room for more, the thread would stop, and next() would wait for ever.
    ASSERT_TRUE(test::eventually([&] { return file.given >= std::min(taken + ahead / 2, count); }));
    EXPECT_LE(file.given, taken + ahead + 2) << "one waits for room, and one is the next of its file";
    const auto message = played.next();
    ASSERT_TRUE(message);
    EXPECT_EQ(message->message.sequence, taken);
    EXPECT_EQ(message->message.data.size(), bytes);
  }
  EXPECT_FALSE(played.next());
}

}  // namespace
}  // namespace sft::tool
