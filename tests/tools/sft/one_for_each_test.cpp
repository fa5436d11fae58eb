// Tests of keep_one_for_each(), which keeps one object for each key.
#include "tools/sft/one_for_each.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "sft/result.h"

namespace sft::tool {
namespace {

using ::testing::ElementsAre;
using ::testing::Key;

class OneForEachTest : public ::testing::Test {
 protected:
  void want(const std::set<std::string>& keys) {
    keep_one_for_each(keys, things, [this](const std::string& key) -> Result<std::shared_ptr<std::string>> {
      made.push_back(key);
      if (key == refused) return fail(Errc::unavailable, "not now");
      return std::make_shared<std::string>(key);
    });
  }

  std::string refused;
  std::vector<std::string> made;
  std::map<std::string, std::shared_ptr<std::string>> things;
};

TEST_F(OneForEachTest, IsMadeOnceAndGoesWithItsKey) {
  want({"a", "b"});
  const std::weak_ptr<std::string> of_a = things.at("a");
  want({"b", "c"});
  EXPECT_THAT(things, ElementsAre(Key("b"), Key("c")));
  EXPECT_TRUE(of_a.expired());
  want({});
  EXPECT_TRUE(things.empty());
  want({"a"});
  EXPECT_THAT(made, ElementsAre("a", "b", "c", "a"));
}

TEST_F(OneForEachTest, IsTriedAgainIfItCouldNotBeMade) {
  refused = "b";
  want({"a", "b"});
  EXPECT_THAT(things, ElementsAre(Key("a")));
  refused = "";
  want({"a", "b"});
  EXPECT_THAT(made, ElementsAre("a", "b", "b"));
}

}  // namespace
}  // namespace sft::tool
