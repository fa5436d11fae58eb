// A remapping rule that matches no name in a process is reported once.
#include "core/node/node_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class RuleUseTest : public ::testing::Test {
 protected:
  RuleUse use;
  Time begun{1h};
  Time later = begun + RuleUse::time_to_open;
};

TEST_F(RuleUseTest, ARuleThatHasFittedNothingWhenTheTimeIsOverIsToldOnce) {
  use.enter({"a:=b", "x:=y"}, begun);
  use.fit({"a:=b"});
  EXPECT_THAT(use.take_unfit(later - 1ms), IsEmpty());
  EXPECT_THAT(use.take_unfit(later), ElementsAre("x:=y"));
  EXPECT_THAT(use.take_unfit(later + 1h), IsEmpty());
  EXPECT_THAT(use.leave(), IsEmpty());
}

TEST_F(RuleUseTest, ARuleThatFitsInOneNodeIsNotToldByAnother) {
  use.enter({"a:=b", "x:=y"}, begun);
  use.enter({"a:=b", "x:=y"}, begun);
  use.fit({"a:=b"});
  EXPECT_THAT(use.take_unfit(later), ElementsAre("x:=y"));
}

TEST_F(RuleUseTest, TheTimeBeginsAnewWithEachNode) {
  use.enter({"a:=b"}, begun);
  use.enter({"a:=b"}, begun + 1s);
  EXPECT_THAT(use.take_unfit(later), IsEmpty());
  EXPECT_THAT(use.take_unfit(later + 1s), ElementsAre("a:=b"));
}

TEST_F(RuleUseTest, TheLastNodeThatClosesTellsBeforeTheTimeIsOver) {
  use.enter({"a:=b"}, begun);
  use.enter({"a:=b"}, begun);
  EXPECT_THAT(use.leave(), IsEmpty());
  EXPECT_THAT(use.leave(), ElementsAre("a:=b"));
}

TEST_F(RuleUseTest, NodesOfAProcessShareItWhileOneOfThemHasIt) {
  auto first = RuleUse::of_process();
  EXPECT_EQ(RuleUse::of_process(), first);
  first->enter({"a:=b"}, begun);
  first->fit({"a:=b"});
  first.reset();
  const auto next = RuleUse::of_process();
  next->enter({"a:=b"}, begun);
  EXPECT_THAT(next->take_unfit(later), ElementsAre("a:=b"));
}

}  // namespace
}  // namespace sft::core
