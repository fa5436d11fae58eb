// The digest of records shows if two processes have the same records.
#include "core/discovery/records.h"

#include <gtest/gtest.h>

#include <string>

namespace sft::core {
namespace {

Record record(std::uint64_t revision, const std::string& text) {
  const auto* const octets = reinterpret_cast<const std::byte*>(text.data());
  return {revision, std::make_shared<const std::vector<std::byte>>(octets, octets + text.size())};
}

const RecordKey key_of_one{1, RecordKind::announcement}, request_of_one{1, RecordKind::request},
    key_of_two{2, RecordKind::announcement};

Records of(const std::vector<std::pair<RecordKey, Record>>& entries) {
  Records records;
  for (const auto& [key, one] : entries) records.put(key, one);
  return records;
}

TEST(RecordsTest, HaveTheSameDigestInWhicheverOrderTheyCome) {
  const Records ordered = of({{key_of_one, record(1, "a")}, {key_of_two, record(2, "b")}});
  EXPECT_EQ(ordered.digest(), of({{key_of_two, record(2, "b")}, {key_of_one, record(1, "a")}}).digest());
  EXPECT_EQ(ordered.digest(),
            of({{key_of_one, record(9, "x")}, {key_of_two, record(2, "b")}, {key_of_one, record(1, "a")}})
                .digest());
}

TEST(RecordsTest, HaveAnotherDigestIfAnythingOfThemDiffers) {
  const std::uint64_t digest = of({{key_of_one, record(1, "abcdefgh0")}}).digest();
  EXPECT_NE(of({{key_of_two, record(1, "abcdefgh0")}}).digest(), digest) << "the slot";
  EXPECT_NE(of({{request_of_one, record(1, "abcdefgh0")}}).digest(), digest) << "the kind";
  EXPECT_NE(of({{key_of_one, record(2, "abcdefgh0")}}).digest(), digest) << "the revision";
  EXPECT_NE(of({{key_of_one, record(1, "abcdefgh1")}}).digest(), digest) << "the last octet";
  EXPECT_NE(of({{key_of_one, record(1, std::string("abcdefgh0\0", 10))}}).digest(), digest) << "the length";
  EXPECT_NE(of({{key_of_one, {1, nullptr}}}).digest(), of({{key_of_one, record(1, "")}}).digest())
      << "withdrawn";
}

TEST(RecordsTest, CountWithdrawnOnes) {
  Records records;
  records.put(key_of_one, {3, nullptr});
  EXPECT_NE(records.digest(), 0u);
  EXPECT_TRUE(records.find(key_of_one)->is_withdrawn());
  EXPECT_EQ(records.bytes(), 0u);
}

TEST(RecordsTest, AreAsBeforeOnceOneWasErased) {
  Records records = of({{key_of_one, record(1, "a")}});
  const std::uint64_t before = records.digest();
  records.put(key_of_two, record(2, "bcd"));
  EXPECT_EQ(records.bytes(), 4u);
  records.erase(key_of_two);
  records.erase(request_of_one);
  EXPECT_EQ(records.digest(), before);
  EXPECT_EQ(records.bytes(), 1u);
  EXPECT_EQ(records.find(key_of_two), nullptr);
}

TEST(RecordsTest, AreEqualWhereverTheirBytesLie) {
  EXPECT_EQ(record(1, "a"), record(1, "a"));
  EXPECT_NE(record(1, "a"), record(1, "b"));
  EXPECT_NE(record(1, "a"), record(2, "a"));
  EXPECT_NE(record(1, ""), (Record{1, nullptr}));
}

}  // namespace
}  // namespace sft::core
