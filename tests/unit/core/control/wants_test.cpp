// What a request says beside its mask, as bytes that anybody may have sent.
#include "core/control/wants.h"

#include <gtest/gtest.h>

#include "sft/selection.h"

namespace sft::core {
namespace {

bool is_taken(const std::vector<int>& numbers) {
  std::vector<std::byte> bytes;
  for (const int number : numbers) bytes.push_back(static_cast<std::byte>(number));
  Request request;
  return take_wants(bytes, request);
}

Request request_for(std::uint32_t min_period_us, std::size_t bytes_of_parts) {
  Request request;
  request.min_period_us = min_period_us;
  request.parts.assign(bytes_of_parts, std::byte{9});
  return request;
}

TEST(WantsTest, OfWholeFieldsAndEverySampleTakeNoBytes) { EXPECT_TRUE(wants_of(Request{}).empty()); }

TEST(WantsTest, ComeBackAsTheyWere) {
  for (const Request& request : {request_for(0x01020304, 300), request_for(0, 3), request_for(7, 0)}) {
    Request back;
    EXPECT_TRUE(take_wants(wants_of(request), back));
    EXPECT_EQ(back, request);
  }
}

TEST(WantsTest, LeaveOutPartsThatAreTooManyBytes) {
  EXPECT_TRUE(wants_of(request_for(0, Selection::bytes_max + 1)).empty());
}

TEST(WantsTest, FitInARequestAtTheirLargest) {
  EXPECT_LE(wants_of(request_for(1, Selection::bytes_max)).size(), wants_bytes_max);
}

TEST(WantsTest, AreRefusedUnlessAllThatMustBeKnownIsKnown) {
  EXPECT_TRUE(is_taken({1, 4, 0, 5, 0, 0, 0, 2, 1, 0, 7}));
  EXPECT_TRUE(is_taken({2, 1, 0, 7, 128, 2, 0, 1, 1})) << "what may be left out";
  EXPECT_FALSE(is_taken({3, 0, 0})) << "a kind that must be known";
  EXPECT_FALSE(is_taken({2, 1, 0, 7, 1, 4, 0, 5, 0, 0, 0})) << "in another order";
  EXPECT_FALSE(is_taken({2, 1, 0, 7, 2, 1, 0, 7})) << "twice";
  EXPECT_FALSE(is_taken({1, 4, 0, 0, 0, 0, 0})) << "no period";
  EXPECT_FALSE(is_taken({1, 3, 0, 1, 0, 0})) << "a short period";
  EXPECT_FALSE(is_taken({2, 0, 0})) << "no parts";
  EXPECT_FALSE(is_taken({2, 2, 0, 7})) << "a length beyond the end";
  EXPECT_FALSE(is_taken({2, 1})) << "half a head";
}

}  // namespace
}  // namespace sft::core
