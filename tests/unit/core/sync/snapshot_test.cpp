#include "core/sync/snapshot.h"

#include <gtest/gtest.h>

#include <thread>

namespace sft::core {
namespace {

TEST(SnapshotTest, AReaderSeesTheLatestValueAndKeepsItWhileItIsReplaced) {
  Snapshot<int> snapshot;
  snapshot.store(std::make_shared<int>(1));
  const int* first = snapshot.load();
  snapshot.store(std::make_shared<int>(2));
  EXPECT_EQ(*first, 1);
  EXPECT_EQ(*snapshot.load(), 2);
}

TEST(SnapshotTest, ValuesNeverGoBackWhileOneThreadWritesAndAnotherReads) {
  Snapshot<int> snapshot;
  snapshot.store(std::make_shared<int>(0));
  std::thread writer([&] {
    for (int i = 1; i <= 20'000; ++i) snapshot.store(std::make_shared<int>(i));
  });
  int last = 0;
  while (last < 20'000) {
    const int now = *snapshot.load();
    ASSERT_GE(now, last);
    last = now;
  }
  writer.join();
}

}  // namespace
}  // namespace sft::core
