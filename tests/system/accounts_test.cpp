// A third node asks the nodes of a pair for their counts, and receives them.
#include <algorithm>
#include <optional>
#include <vector>

#include "tests/system/fixture.h"

namespace sft::test {
namespace {

class AccountsBetweenNodes : public PubSubTest {
 protected:
  /// Returns the counts of the pair as `node` knows them, or nothing if `node` does not know the pair yet.
  static std::optional<DomainSnapshot::Account> account_of(const Node& node, const std::string& topic) {
    const DomainSnapshot domain = node.domain();
    for (const DomainSnapshot::Pair& pair : domain.pairs) {
      for (const DomainSnapshot::Endpoint& publisher : domain.publishers) {
        if (publisher.id == pair.publisher && publisher.topic == topic) return pair.account;
      }
    }
    return std::nullopt;
  }
  static bool is_silent(const std::optional<DomainSnapshot::Account>& account) {
    return account && !account->publisher && !account->subscriber;
  }
  /// Returns true if both nodes of the pair soon report that `samples` samples were sent and received.
  static bool reports(const Node& node, std::uint64_t samples) {
    return eventually([&] {
      const auto account = account_of(node, "points");
      return account && account->publisher && account->subscriber && account->publisher->sent == samples &&
             account->subscriber->received == samples;
    });
  }
  void exchange(int samples) {
    for (int i = 0; i < samples; ++i) {
      pub.publish(cloud(1, 5000));
      EXPECT_TRUE(sub.wait(hang_timeout));
      while (sub.take()) continue;
    }
  }

  Node a = open("a");
  Node b = open("b");
  Node tool = open("tool");
  Publisher<PointCloud2> pub = a.publisher<PointCloud2>("points").value();
  Subscriber<PointCloud2, F::height | F::width> sub =
      b.subscriber<PointCloud2, F::height | F::width>("points").value();
};

TEST_P(AccountsBetweenNodes, AreToldToANodeThatAsksAndGoOnAsSamplesDo) {
  expect_served(pub, 1);
  exchange(10);
  ASSERT_TRUE(eventually([&] { return is_silent(account_of(tool, "points")); })) << "nobody has asked";
  const AccountInquiry inquiry = tool.ask_accounts("/points").value();
  EXPECT_TRUE(reports(tool, 10));
  exchange(5);
  EXPECT_TRUE(reports(tool, 15));
  const DomainSnapshot::Account account = account_of(tool, "points").value();
  const NodeSnapshot::Publisher::Reader counted = a.snapshot().publishers.at(0).readers.at(0);
  EXPECT_EQ(account.publisher->bytes_sent, counted.bytes_sent);
  EXPECT_EQ(account.publisher->bytes_saved, counted.bytes_saved);
  EXPECT_EQ(account.publisher->bytes_saved == 0, in_shared_memory());
  EXPECT_EQ(account.publisher->withheld, 0U);
  EXPECT_EQ(account.publisher->dropped, 0U);
  EXPECT_EQ(account.subscriber->lost, 0U);
  EXPECT_LT(account.publisher->age, 10s);
  EXPECT_TRUE(is_silent(account_of(a, "points"))) << "it has not asked, not even itself";
}

TEST_P(AccountsBetweenNodes, OfOwnPublishersAndSubscribersAreThereAtOnce) {
  expect_served(pub, 1);
  exchange(1);
  const AccountInquiry inquiry = a.ask_accounts("points").value();
  const std::optional<DomainSnapshot::Account> account = account_of(a, "points");
  ASSERT_TRUE(account && account->publisher);
  EXPECT_EQ(account->publisher->sent, 1U);
  EXPECT_EQ(account->publisher->age, 0s);
  EXPECT_TRUE(reports(a, 1)) << "the other side comes by the network";
}

TEST_P(AccountsBetweenNodes, OfMorePairsThanAReportHasRoomForAreReportedInTurns) {
  constexpr std::size_t pairs = 50;
  std::vector<Subscriber<PointCloud2, F::height>> more;
  while (more.size() + 1 < pairs) more.push_back(b.subscriber<PointCloud2, F::height>("points").value());
  expect_served(pub, pairs);
  const AccountInquiry inquiry = tool.ask_accounts("points").value();
  const auto reported = [&] {
    const DomainSnapshot domain = tool.domain();
    return std::ranges::count_if(domain.pairs, [](const DomainSnapshot::Pair& pair) {
      return pair.account.publisher && pair.account.subscriber;
    });
  };
  EXPECT_TRUE(eventually([&] { return reported() == pairs; })) << reported();
}

TEST_P(AccountsBetweenNodes, AreForgottenOnceTheLastQuestionIsTakenBack) {
  expect_served(pub, 1);
  exchange(1);
  std::optional<AccountInquiry> inquiry = tool.ask_accounts("points").value();
  std::optional<AccountInquiry> copy = inquiry;
  EXPECT_TRUE(reports(tool, 1));
  inquiry.reset();
  EXPECT_FALSE(is_silent(account_of(tool, "points")));
  copy.reset();
  EXPECT_TRUE(is_silent(account_of(tool, "points")));
}

TEST_P(AccountsBetweenNodes, OfATopicThatCannotBeAreRefusedWithItsName) {
  const Result<AccountInquiry> refused = tool.ask_accounts("points\n");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::invalid_argument);
  EXPECT_EQ(refused.error().message, "topic 'points\\x0a' has a control character in it");
}

INSTANTIATE_TEST_SUITE_P(Ways, AccountsBetweenNodes, ::testing::Values(Way::shm, Way::udp), way_name);

}  // namespace
}  // namespace sft::test
