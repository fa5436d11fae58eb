// Names of peers are looked up on separate threads, so that no other thread waits for a name server that does
// not answer.
#include "core/platform/peer_addresses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>

#include "tests/support/eventually.h"

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using namespace std::chrono_literals;

constexpr IpAddress first{0x0A000007}, second{0x0A000008};

TEST(PeerInNumbers, IsWhatTheUserWroteWhereThatIsANumberOfTheFamily) {
  for (const char* written : {"10.0.0.7", "10.0.0.7:7410", "udp/10.0.0.7:7410"}) {
    EXPECT_EQ(name_in(written), std::nullopt) << written;
    EXPECT_THAT(in_numbers(written, IpFamily::ipv4, {}), ElementsAre(written));
    EXPECT_THAT(in_numbers(written, IpFamily::ipv6, {}), IsEmpty()) << written;
  }
  for (const char* written : {"fd00::7", "[fd00::7]", "[fd00::7]:7410", "udp6/[fd00::7]:7410"}) {
    EXPECT_EQ(name_in(written), std::nullopt) << written;
    EXPECT_THAT(in_numbers(written, IpFamily::ipv6, {}), ElementsAre(written));
    EXPECT_THAT(in_numbers(written, IpFamily::ipv4, {}), IsEmpty()) << written;
  }
}

TEST(PeerInNumbers, HasThePortThatStandsBehindTheName) {
  const KnownHosts known{{"robot.local", {first, second, loopback_ipv6}}};
  EXPECT_EQ(name_in("robot.local:7410"), "robot.local");
  EXPECT_EQ(name_in("udp/robot.local"), "robot.local");
  EXPECT_THAT(in_numbers("robot.local", IpFamily::ipv4, known), ElementsAre("10.0.0.7", "10.0.0.8"));
  EXPECT_THAT(in_numbers("udp/robot.local:7410", IpFamily::ipv4, known),
              ElementsAre("udp/10.0.0.7:7410", "udp/10.0.0.8:7410"));
  EXPECT_THAT(in_numbers("robot.local:7410", IpFamily::ipv6, known), ElementsAre("[::1]:7410"));
  EXPECT_THAT(in_numbers("other.local", IpFamily::ipv4, known), IsEmpty());
}

/// A name server that answers once the test has set the answer.
class NameServer {
 public:
  Result<std::vector<IpAddress>> answer(const std::string& name) {
    Lock lock(mutex_);
    ++asked_[name];
    while (!answers_.contains(name)) changed_.wait(lock);
    return answers_.at(name);
  }
  void set_answer(const std::string& name, Result<std::vector<IpAddress>> answer) {
    const Lock lock(mutex_);
    answers_.insert_or_assign(name, std::move(answer));
    changed_.notify_all();
  }
  void is_silent_about(const std::string& name) {
    const Lock lock(mutex_);
    answers_.erase(name);
  }
  int asked(const std::string& name) {
    const Lock lock(mutex_);
    return asked_[name];
  }

 private:
  Mutex mutex_;
  Condition changed_;
  std::map<std::string, Result<std::vector<IpAddress>>> answers_ SFT_GUARDED_BY(mutex_);
  std::map<std::string, int> asked_ SFT_GUARDED_BY(mutex_);
};

class PeerAddressesTest : public ::testing::Test {
 protected:
  ~PeerAddressesTest() override {
    for (const char* name : {"robot", "other"})
      server_->set_answer(name, fail(Errc::unavailable, "the test ends"));
  }
  PeerAddresses of(const std::vector<std::string>& peers) {
    PeerAddresses addresses(
        peers, {}, [server = server_](const std::string& name, IpFamily) { return server->answer(name); });
    addresses.used_on(IpFamily::ipv4);
    return addresses;
  }
  /// Waits until no lookup is running, and returns the changes that the answers have caused.
  PeerAddresses::Look answered(PeerAddresses& addresses) {
    addresses.wait_for_answers(std::chrono::steady_clock::now() + sft::test::hang_timeout);
    return addresses.look_after(now_);
  }

  const std::shared_ptr<NameServer> server_ = std::make_shared<NameServer>();
  Time now_ = Time{} + 1h;
};

TEST_F(PeerAddressesTest, AreKnownOnceTheirNamesAreAnswered) {
  PeerAddresses addresses = of({"robot", "10.0.0.9"});
  server_->set_answer("robot", std::vector{first});
  EXPECT_FALSE(addresses.look_after(now_).addresses_changed);
  EXPECT_TRUE(answered(addresses).addresses_changed);
  EXPECT_EQ(addresses.known(), (KnownHosts{{"robot", {first}}}));
  EXPECT_THAT(addresses.warnings(), IsEmpty());
  EXPECT_EQ(server_->asked("10.0.0.9"), 0);
}

TEST_F(PeerAddressesTest, OfOneNameDoNotWaitForThoseOfAnother) {
  PeerAddresses addresses = of({"other", "robot"});
  server_->set_answer("robot", std::vector{first});
  addresses.look_after(now_);
  EXPECT_TRUE(sft::test::eventually([&] { return addresses.look_after(now_).addresses_changed; }));
  EXPECT_EQ(addresses.known(), (KnownHosts{{"robot", {first}}}));
}

TEST_F(PeerAddressesTest, ThatNothingAnswersAreAWarningOnceAndStillLookedFor) {
  PeerAddresses addresses = of({"robot"});
  EXPECT_THAT(addresses.look_after(now_).news, IsEmpty());
  now_ += 1s;
  EXPECT_THAT(addresses.look_after(now_).news, ElementsAre(HasSubstr("'robot' is not looked for yet")));
  now_ += 1h;
  const PeerAddresses::Look look = addresses.look_after(now_);
  EXPECT_THAT(look.news, IsEmpty());
  EXPECT_FALSE(look.warnings_changed);
  EXPECT_GT(look.next, now_);
  EXPECT_THAT(addresses.warnings(), ElementsAre(HasSubstr("has not been answered yet")));
  server_->set_answer("robot", std::vector{first});
  EXPECT_TRUE(answered(addresses).warnings_changed);
  EXPECT_THAT(addresses.warnings(), IsEmpty());
  EXPECT_EQ(server_->asked("robot"), 1);
}

TEST_F(PeerAddressesTest, MayEndWhileALookupIsUnderWay) {
  {
    PeerAddresses addresses = of({"robot"});
    addresses.look_after(now_);
    EXPECT_TRUE(sft::test::eventually([&] { return server_->asked("robot") == 1; }));
  }
  server_->set_answer("robot", std::vector{first});
}

TEST_F(PeerAddressesTest, ThatDoNotExistAreLookedUpAgainAfterPauses) {
  PeerAddresses addresses = of({"robot"});
  server_->set_answer("robot", fail(Errc::unavailable, "Name or service not known"));
  addresses.look_after(now_);
  const PeerAddresses::Look look = answered(addresses);
  EXPECT_THAT(look.news, ElementsAre(HasSubstr("'robot' is not looked for yet: Name or service not known")));
  EXPECT_EQ(look.next, now_ + Retry::pause_min);
  now_ = look.next - 1ms;
  addresses.look_after(now_);
  EXPECT_EQ(server_->asked("robot"), 1);
  now_ = look.next;
  server_->set_answer("robot", std::vector{first});
  addresses.look_after(now_);
  EXPECT_TRUE(answered(addresses).addresses_changed);
  EXPECT_THAT(addresses.warnings(), IsEmpty());
}

TEST_F(PeerAddressesTest, AreKeptWhileTheNameServerFailsWhichIsAWarning) {
  PeerAddresses addresses = of({"robot"});
  server_->set_answer("robot", std::vector{first});
  addresses.look_after(now_);
  EXPECT_TRUE(answered(addresses).addresses_changed);
  server_->set_answer("robot", fail(Errc::unavailable, "Temporary failure"));
  addresses.network_changed();
  addresses.look_after(now_);
  const PeerAddresses::Look look = answered(addresses);
  EXPECT_FALSE(look.addresses_changed);
  EXPECT_THAT(look.news, ElementsAre(HasSubstr("last known address: Temporary failure")));
  EXPECT_EQ(addresses.known(), (KnownHosts{{"robot", {first}}}));
}

TEST_F(PeerAddressesTest, AreLookedUpAgainWhenTheNetworkChangesAndEveryNowAndThen) {
  PeerAddresses addresses = of({"robot"});
  server_->set_answer("robot", std::vector{first});
  addresses.look_after(now_);
  const PeerAddresses::Look look = answered(addresses);
  EXPECT_EQ(look.next, now_ + PeerAddresses::ask_again_after);
  addresses.network_changed();
  addresses.look_after(now_);
  EXPECT_FALSE(answered(addresses).addresses_changed) << "the same answer";
  now_ += PeerAddresses::ask_again_after;
  server_->set_answer("robot", std::vector{second});
  addresses.look_after(now_);
  EXPECT_TRUE(answered(addresses).addresses_changed);
  EXPECT_EQ(addresses.known(), (KnownHosts{{"robot", {second}}}));
}

TEST_F(PeerAddressesTest, AreNotLookedUpWhereNoLinkAsksThem) {
  PeerAddresses addresses = of({"robot"});
  addresses.used_on(std::nullopt);
  EXPECT_EQ(addresses.look_after(now_).next, Time::max());
  EXPECT_EQ(server_->asked("robot"), 0);
  EXPECT_THAT(addresses.warnings(), IsEmpty());
}

TEST_F(PeerAddressesTest, OfAnotherFamilyThanThatOfTheLinksAreAWarning) {
  const PeerAddresses addresses = of({"fd00::7", "10.0.0.7"});
  EXPECT_THAT(addresses.warnings(), ElementsAre(HasSubstr("'fd00::7' is not looked for: discovery")));
}

}  // namespace
}  // namespace sft::core
