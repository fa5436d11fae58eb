// All combinations of offered and requested QoS, and settings that are refused when an endpoint is opened.
#include "core/names/qos.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace sft::core {
namespace {

using namespace std::chrono_literals;

/// Returns values of the policy, ordered from the weakest offer to the strongest.
std::vector<Qos> weakest_to_strongest(QosPolicy policy) {
  switch (policy) {
    case QosPolicy::reliability:
      return {{.reliability = best_effort}, {.reliability = reliable}};
    case QosPolicy::durability:
      return {{.durability = volatile_}, {.durability = transient_local}};
    case QosPolicy::deadline:
      return {{}, {.deadline = 2s}, {.deadline = 1s}, {.deadline = 1ns}};
    case QosPolicy::liveliness:
      return {{.liveliness = Liveliness::automatic}, {.liveliness = manual_by_topic}};
    case QosPolicy::none:
      break;
  }
  // The leases, also from the weakest offer to the strongest.
  return {{}, {.liveliness_lease = 2s}, {.liveliness_lease = 1s}, {.liveliness_lease = 1ns}};
}

class RulesTest : public ::testing::TestWithParam<QosPolicy> {};

TEST_P(RulesTest, AnOfferThatIsAtLeastTheRequestMatchesAndAnyOtherNamesThePolicy) {
  const QosPolicy named = GetParam() == QosPolicy::none ? QosPolicy::liveliness : GetParam();
  const std::vector<Qos> levels = weakest_to_strongest(GetParam());
  for (std::size_t offered = 0; offered < levels.size(); ++offered) {
    for (std::size_t requested = 0; requested < levels.size(); ++requested) {
      const QosConflict conflict = conflict_between(levels[offered], levels[requested]);
      EXPECT_EQ(conflict.policy, offered >= requested ? QosPolicy::none : named);
      EXPECT_EQ(conflict.reason.empty(), offered >= requested) << conflict.reason;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Policies, RulesTest,
                         ::testing::Values(QosPolicy::reliability, QosPolicy::durability, QosPolicy::deadline,
                                           QosPolicy::liveliness, QosPolicy::none),
                         [](const auto& param) {
                           return param.param == QosPolicy::none ? "lease" : to_string(param.param);
                         });

// All policies together match if and only if each of them matches.
TEST(RulesTest, PoliciesDoNotMix) {
  std::vector<Qos> all;
  for (const Reliability reliability : {best_effort, reliable}) {
    for (const Durability durability : {volatile_, transient_local}) {
      for (const auto deadline : {0ms, 20ms, 10ms}) {
        for (const Liveliness liveliness : {Liveliness::automatic, manual_by_topic}) {
          for (const auto lease : {0ms, 20ms, 10ms}) {
            all.push_back({.reliability = reliability,
                           .durability = durability,
                           .deadline = deadline,
                           .liveliness = liveliness,
                           .liveliness_lease = lease});
          }
        }
      }
    }
  }
  const auto within = [](auto offered, auto requested) {
    return requested.count() == 0 || (offered.count() != 0 && offered <= requested);
  };
  for (const Qos& offered : all) {
    for (const Qos& requested : all) {
      const bool fits =
          offered.reliability >= requested.reliability && offered.durability >= requested.durability &&
          within(offered.deadline, requested.deadline) && offered.liveliness >= requested.liveliness &&
          within(offered.liveliness_lease, requested.liveliness_lease);
      ASSERT_EQ(conflict_between(offered, requested).policy == QosPolicy::none, fits);
    }
  }
}

TEST(QosConflictTest, NamesEveryPolicyThatDoesNotFitWithBothValues) {
  EXPECT_EQ(
      conflict_between({.deadline = 100ms}, {.reliability = reliable, .deadline = 1500us}).reason,
      "incompatible QoS: reliability best_effort is offered, reliable is requested; deadline 100 ms is "
      "offered, 1500 us is requested: open the publisher with .reliability = reliable .deadline = 1500 us, "
      "or the subscriber with .reliability = best_effort .deadline = 100 ms");
  EXPECT_EQ(
      conflict_between({}, {.liveliness_lease = 1s}).reason,
      "incompatible QoS: liveliness_lease none is offered, 1000 ms is requested: open the publisher with "
      ".liveliness_lease = 1000 ms, or the subscriber with .liveliness_lease = none");
}

TEST(OptionsWithoutEffectTest, EachIsNamedOfANode) {
  const auto of = [](const NodeOptions& options) {
    const std::vector<std::string> sentences = options_without_effect(options);
    return sentences.empty() ? "" : sentences.front();
  };
  EXPECT_EQ(of({}), "");
  EXPECT_EQ(of({.udp = {.port = 7}, .shm = {.daemon_path = "/sftd", .daemon_users = {"robot"}}}), "");
  EXPECT_EQ(of({.transport = TransportChoice::shm, .udp = {.port = 7}}),
            "NodeOptions::udp has no effect: the node does not use UDP");
  EXPECT_EQ(of({.transport = TransportChoice::udp, .shm = {.daemon_users = {"robot"}}}),
            "ShmSettings::daemon_users has no effect: the node does not use shared memory");
  EXPECT_EQ(of({.shm = {.start_daemon = false, .daemon_path = "/sftd"}}),
            "ShmSettings::daemon_path has no effect: start_daemon is false");
}

TEST(OptionsWithoutEffectTest, EachIsNamedOfAPublisher) {
  const auto of = [](const PublisherOptions& options, bool udp = true) {
    std::string all;
    for (const std::string& one : options_without_effect(options, udp)) all += one + "\n";
    return all;
  };
  EXPECT_EQ(of({}), "");
  EXPECT_EQ(of({}, false), "");
  EXPECT_EQ(
      of({.reliability = reliable, .durability = transient_local, .history_depth = 9, .max_blocking = 1s}),
      "");
  EXPECT_EQ(
      of({.max_blocking = 1s}),
      "PublisherOptions::max_blocking has no effect: publish() waits for reliable subscribers only; set "
      ".reliability = reliable\n");
  EXPECT_NE(of({.history_depth = 9}).find("history_depth has no effect: only a publisher with .durability"),
            std::string::npos);
  EXPECT_EQ(of({.max_bytes_per_s = 1, .asynchronous = true}), "");
  EXPECT_NE(of({.max_bytes_per_s = 1}, false).find("max_bytes_per_s has no effect: the publisher does not"),
            std::string::npos);
  EXPECT_EQ(of({.reliability = reliable, .resend_bytes = 1}), "");
  EXPECT_EQ(of({.reliability = reliable, .resend_bytes = 1}, false),
            "PublisherOptions::resend_bytes has no effect: the publisher does not use UDP\n");
  EXPECT_EQ(of({.resend_bytes = 1}),
            "PublisherOptions::resend_bytes has no effect: only a reliable publisher sends samples again; "
            "set .reliability = reliable\n");
  EXPECT_NE(of({.asynchronous = true}, false).find("asynchronous has no effect: the publisher does not use"),
            std::string::npos);
  EXPECT_NE(of({.reliability = reliable, .max_blocking = 1s, .asynchronous = true})
                .find("asynchronous has no effect: max_blocking is not 0"),
            std::string::npos);
}

TEST(OptionsWithoutEffectTest, EachIsNamedOfASubscriber) {
  const auto of = [](const SubscriberOptions& options, bool shm = true, bool recorded = true) {
    std::string all;
    for (const std::string& one : options_without_effect(options, shm, recorded)) all += one + "\n";
    return all;
  };
  EXPECT_EQ(of({}), "");
  EXPECT_EQ(of({}, false, false), "");
  const SubscriberOptions learns{.recording = {.learn_samples = 9}};
  EXPECT_EQ(of(learns), "");
  EXPECT_NE(of(learns, true, false).find("recording has no effect: the fields are declared"),
            std::string::npos);
  EXPECT_EQ(of({.recording = {.as_remote = true}}, true, false), "") << "that is for all subscribers";
  EXPECT_EQ(of({.max_held = 9}), "");
  EXPECT_NE(of({.max_held = 9}, false).find("max_held has no effect: the subscriber does not use shared"),
            std::string::npos);
  EXPECT_EQ(of({.spin = 1s}), "");
  EXPECT_NE(of({.spin = 1s, .pollable = true}).find("spin has no effect: the subscriber is pollable"),
            std::string::npos);
}

TEST(QosOptionsTest, WhatCanNeverWorkIsRefusedByName) {
  EXPECT_TRUE(qos_of(PublisherOptions{}));
  EXPECT_TRUE(qos_of(SubscriberOptions{}));
  const auto negative = qos_of(PublisherOptions{.deadline = -1ns});
  ASSERT_FALSE(negative);
  EXPECT_NE(negative.error().message.find("deadline"), std::string::npos);
  EXPECT_FALSE(qos_of(SubscriberOptions{.liveliness_lease = -1ns}));
  const auto short_lease = qos_of(SubscriberOptions{.liveliness_lease = 999us});
  ASSERT_FALSE(short_lease);
  EXPECT_EQ(short_lease.error().message, "liveliness_lease 999 us: it is at least 1 ms, or 0 for none");
  EXPECT_FALSE(qos_of(PublisherOptions{.liveliness_lease = 1ns}));
  EXPECT_FALSE(qos_of(PublisherOptions{.deadline = 999'999ns}));
  EXPECT_FALSE(qos_of(SubscriberOptions{.deadline = 1ns}));
  EXPECT_TRUE(qos_of(PublisherOptions{.deadline = 1ms, .lifespan = 1ns, .liveliness_lease = 1ms}));
  for (const std::uint32_t depth : {0U, 1'000'001U, 1'000'000'000U}) {
    const auto refused = qos_of(SubscriberOptions{.depth = depth});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().message,
              "SubscriberOptions::depth is 1 to 1000000, not " + std::to_string(depth));
  }
  EXPECT_TRUE(qos_of(SubscriberOptions{.depth = 1'000'000}));
  EXPECT_FALSE(qos_of(PublisherOptions{.history_depth = 0}));
  EXPECT_FALSE(qos_of(PublisherOptions{.history_depth = 129}));
  EXPECT_FALSE(qos_of(PublisherOptions{.lifespan = -1ns}));
  EXPECT_FALSE(qos_of(SubscriberOptions{.deadline = 50ms, .max_rate_hz = 10}));
  EXPECT_TRUE(qos_of(SubscriberOptions{.deadline = 100ms, .max_rate_hz = 10}));
  EXPECT_FALSE(qos_of(PublisherOptions{.liveliness = manual_by_topic})) << "who would notice?";
}

TEST(QosOptionsTest, RatesAreSentAsPeriods) {
  EXPECT_EQ(min_period_us_of(0), 0U);
  EXPECT_EQ(min_period_us_of(10), 100'000U);
  EXPECT_EQ(min_period_us_of(30), 33'333U);
  for (const double none : {-1.0, 1e-9, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_FALSE(min_period_us_of(none)) << none;
  }
}

}  // namespace
}  // namespace sft::core
