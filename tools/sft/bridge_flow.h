// One topic with one type that a rule of `sft bridge` carries to the other side.
//
// For each publisher of the topic, the bridge opens a publisher with the same QoS on the other side. So
// readers there receive the retained samples of each publisher, and match in the same way as on the first
// side. Publishers of a topic may offer different QoS. So the bridge has one subscriber for each
// combination of reliability and durability, which requests exactly these, as in recorded_topic.h. If a
// topic has no retained samples, the bridge subscribes to it only while a subscriber on the other side
// reads it.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tools/sft/bridge_routes.h"
#include "tools/sft/bridge_rules.h"

namespace sft::tool {

/// One of the two sides of a running bridge.
struct BridgeEnd {
  std::string name;       ///< the name of the side for messages to the user
  std::string node_name;  ///< the name of `node`
  Node node;
  BridgeRoutes routes;
  DomainSnapshot domain{};  ///< the domain at the last look
};

class BridgeFlow {
 public:
  using Time = std::chrono::steady_clock::time_point;
  struct Counts {
    std::uint64_t carried = 0;
    std::uint64_t bytes = 0;    ///< bytes of the messages that were carried
    std::uint64_t lost = 0;     ///< messages that were lost before they reached this bridge, or in it
    std::uint64_t refused = 0;  ///< messages that were malformed or could not be published
  };
  /// The state of the flow, for messages to the user.
  struct State {
    std::size_t publishers = 0, carried = 0, read = 0;
    bool is_held_by_another = false;
  };

  /// Returns an error if the rule's selection does not suit the type, or leaves out fields that the type
  /// has. The file descriptors of subscribers are added to `epoll`, with the address of this object as
  /// their data. So the object must not be moved after the first look(). `rule` and `counts` must outlive
  /// this object.
  static Result<BridgeFlow> open(const BridgeRule& rule, std::string topic, std::string target,
                                 const DynamicType& type, int epoll, Counts& counts);

  /// Looks for publishers and readers, and opens and closes endpoints for them. Adds the routes of this
  /// topic to the lists for both sides, `here` and `there`.
  Result<void> look(BridgeEnd& from, BridgeEnd& to, Time now, std::vector<BridgeRoutes::Route>& here,
                    std::vector<BridgeRoutes::Route>& there);
  /// Carries some of the samples that have arrived.
  void carry();

  const BridgeRule& rule() const { return *rule_; }
  const std::string& topic() const { return topic_; }
  const std::string& target() const { return target_; }
  std::uint64_t type_hash() const { return type_.hash(); }
  State state() const;
  /// Returns true if the topic no longer exists. Must be called after look().
  bool is_over(Time now) const;
  /// Returns the approximate size of a sample in bytes.
  std::size_t sample_bytes() const { return sample_bytes_; }
  /// Returns the reason why samples were refused, and clears it.
  std::string take_fault() { return std::exchange(fault_, {}); }

 private:
  struct Offer {
    Reliability reliability = best_effort;
    Durability durability = volatile_;
    friend bool operator==(const Offer&, const Offer&) = default;
  };
  struct Subscription {
    Offer offer;
    DynamicSubscriber subscriber;
  };
  /// A publisher of the topic, and the publisher of the bridge for it.
  struct Source {
    Qos qos{};
    bool is_known = false;  ///< false: a sample has arrived before the publisher was discovered
    bool is_dds = false;    ///< true: it is a DDS writer that knows nothing of SFT
    Time seen{};
    std::optional<BridgeRoutes::Source> origin{};
    BridgeRoutes::Verdict verdict = BridgeRoutes::Verdict::settles;
    std::optional<DynamicPublisher> publisher{};
    std::uint64_t publisher_id = 0;
    Time opened{};               ///< when `publisher` was opened
    bool is_read = false;        ///< true: a subscriber on the other side reads `publisher`
    std::uint64_t sequence = 0;  ///< the sequence of the last sample that was carried
    /// Samples that arrived before the verdict about their route.
    std::deque<std::pair<Offer, DynamicSample>> early{};
    std::size_t early_bytes = 0;

    Offer offer() const { return {qos.reliability, qos.durability}; }
    bool is_retained() const { return qos.durability == transient_local; }
  };

  BridgeFlow(const BridgeRule& rule, std::string topic, std::string target, const DynamicType& type,
             Selection selection, int epoll, Counts& counts)
      : rule_(&rule),
        topic_(std::move(topic)),
        target_(std::move(target)),
        type_(type),
        selection_(std::move(selection)),
        epoll_(epoll),
        counts_(&counts) {}
  void find_sources(const BridgeEnd& from, Time now);
  Result<void> decide(Source& source, BridgeEnd& to, Time now);
  Result<void> begin(Source& source, Node& node, Time now);
  std::vector<Offer> wanted_offers() const;
  bool is_unwanted(const Offer& offer, Time now) const;
  Result<void> subscribe(Node& node, Time now);
  void close(const Offer& offer);
  void take(const Offer& offer, DynamicSample&& sample, Time now);
  void pass_on_early(Source& source);
  void pass_on(Source& source, const DynamicSample& sample);
  void refuse(const std::string& why);

  const BridgeRule* rule_;
  std::string topic_, target_;
  DynamicType type_;
  Selection selection_;
  int epoll_;
  Counts* counts_;
  std::list<Subscription> subscriptions_{};
  std::map<std::uint64_t, Source> sources_{};  ///< publishers of the topic by their ids
  Time had_sources_{};                         ///< the time of the last look at which there was a publisher
  std::size_t sample_bytes_ = 0;
  std::set<std::string> faults_{};
  std::string fault_{};
};

}  // namespace sft::tool
