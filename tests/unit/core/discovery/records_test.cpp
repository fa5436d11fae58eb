// The digest of records tells whether two processes have the same ones.
#include "core/discovery/records.h"

#include <gtest/gtest.h>

#include <string>

namespace sft::core {
namespace {

Record record(std::uint64_t revision, const std::string& text) {
  const auto* const first = reinterpret_cast<const std::byte*>(text.data());
  return {revision, std::make_shared<const std::vector<std::byte>>(first, first + text.size())};
}

const RecordKey first{1, RecordKind::announcement}, request_of_first{1, RecordKind::request},
    second{2, RecordKind::announcement};

Records of(const std::vector<std::pair<RecordKey, Record>>& entries) {
  Records records;
  for (const auto& [key, one] : entries) records.put(key, one);
  return records;
}

TEST(RecordsTest, HaveTheSameDigestInWhicheverOrderTheyCome) {
  const Records ordered = of({{first, record(1, "a")}, {second, record(2, "b")}});
  EXPECT_EQ(ordered.digest(), of({{second, record(2, "b")}, {first, record(1, "a")}}).digest());
  EXPECT_EQ(ordered.digest(),
            of({{first, record(9, "x")}, {second, record(2, "b")}, {first, record(1, "a")}}).digest());
}

TEST(RecordsTest, HaveAnotherDigestIfAnythingOfThemDiffers) {
  const std::uint64_t digest = of({{first, record(1, "abcdefgh0")}}).digest();
  EXPECT_NE(of({{second, record(1, "abcdefgh0")}}).digest(), digest) << "the slot";
  EXPECT_NE(of({{request_of_first, record(1, "abcdefgh0")}}).digest(), digest) << "the kind";
  EXPECT_NE(of({{first, record(2, "abcdefgh0")}}).digest(), digest) << "the revision";
  EXPECT_NE(of({{first, record(1, "abcdefgh1")}}).digest(), digest) << "the last octet";
  EXPECT_NE(of({{first, record(1, std::string("abcdefgh0\0", 10))}}).digest(), digest) << "the length";
  EXPECT_NE(of({{first, {1, nullptr}}}).digest(), of({{first, record(1, "")}}).digest()) << "withdrawn";
}

TEST(RecordsTest, CountWithdrawnOnes) {
  Records records;
  records.put(first, {3, nullptr});
  EXPECT_NE(records.digest(), 0u);
  EXPECT_TRUE(records.find(first)->is_withdrawn());
  EXPECT_EQ(records.bytes(), 0u);
}

TEST(RecordsTest, AreAsBeforeOnceOneWasErased) {
  Records records = of({{first, record(1, "a")}});
  const std::uint64_t before = records.digest();
  records.put(second, record(2, "bcd"));
  EXPECT_EQ(records.bytes(), 4u);
  records.erase(second);
  records.erase(request_of_first);
  EXPECT_EQ(records.digest(), before);
  EXPECT_EQ(records.bytes(), 1u);
  EXPECT_EQ(records.find(second), nullptr);
}

TEST(RecordsTest, AreEqualWhereverTheirBytesLie) {
  EXPECT_EQ(record(1, "a"), record(1, "a"));
  EXPECT_NE(record(1, "a"), record(1, "b"));
  EXPECT_NE(record(1, "a"), record(2, "a"));
  EXPECT_NE(record(1, ""), (Record{1, nullptr}));
}

}  // namespace
}  // namespace sft::core
