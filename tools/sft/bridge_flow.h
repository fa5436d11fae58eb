// One topic with one type that a rule of `sft bridge` carries to the other side.
//
// Each publisher of the topic has a publisher of its own there, with its QoS, so that readers there get the
// retained samples of each, and match as they would match it. Publishers of a topic may offer different QoS:
// each kind of offer has a subscriber that requests just that, as in recorded_topic.h. A topic without
// retained samples is subscribed to only while a subscriber on the other side reads it.
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

/// One side at work.
struct BridgeEnd {
  std::string name;       ///< for messages
  std::string node_name;  ///< the name of `node`
  Node node;
  BridgeRoutes routes;
  DomainSnapshot domain{};  ///< as it was at the last look
};

class BridgeFlow {
 public:
  using Time = std::chrono::steady_clock::time_point;
  struct Counts {
    std::uint64_t carried = 0;
    std::uint64_t bytes = 0;    ///< of the messages that were carried
    std::uint64_t lost = 0;     ///< on the way to this bridge, or in it
    std::uint64_t refused = 0;  ///< malformed ones, or such that could not be published
  };
  /// The state of the flow, for messages to the user.
  struct State {
    std::size_t publishers = 0, carried = 0, read = 0;
    bool is_held_by_another = false;
  };

  /// Returns an error if the rule's selection does not suit the type, or leaves out fields that the type has.
  /// `epoll` gets the file descriptors of subscribers, with this object as their data: it must not move any
  /// more once look() was called. `rule`, `from`, `to` and `counts` must outlive this object.
  static Result<BridgeFlow> open(const BridgeRule& rule, std::string topic, std::string target,
                                 const DynamicType& type, int epoll, Counts& counts);

  /// Looks for publishers and readers. Adds its routes to the lists of both sides.
  Result<void> look(BridgeEnd& from, BridgeEnd& to, Time now, std::vector<BridgeRoutes::Route>& here,
                    std::vector<BridgeRoutes::Route>& there);
  /// Carries some of the samples that have come.
  void carry();

  const BridgeRule& rule() const { return *rule_; }
  const std::string& topic() const { return topic_; }
  const std::string& target() const { return target_; }
  std::uint64_t type_hash() const { return type_.hash(); }
  State state() const;
  /// Returns true if the topic is gone. The caller has to call look() before.
  bool is_over(Time now) const;
  /// The size of a sample, about.
  std::size_t sample_bytes() const { return sample_bytes_; }
  /// Returns the reason why samples were refused, once.
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
  /// A publisher of the topic.
  struct Source {
    Qos qos{};
    bool is_known = false;  ///< false: a sample has come before it was seen
    bool is_dds = false;    ///< it is a writer that knows nothing of SFT
    Time seen{};
    std::optional<BridgeRoutes::Source> origin{};
    BridgeRoutes::Verdict verdict = BridgeRoutes::Verdict::settles;
    std::optional<DynamicPublisher> publisher{};
    std::uint64_t publisher_id = 0;
    Time opened{};               ///< when the publisher was
    bool is_read = false;        ///< a subscriber on the other side reads it
    std::uint64_t sequence = 0;  ///< of the last sample that was carried
    /// Samples that came before the route was decided.
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
  std::map<std::uint64_t, Source> sources_{};  ///< by the id of the publisher
  Time had_sources_{};                         ///< the time of the last look at which there was a publisher
  std::size_t sample_bytes_ = 0;
  std::set<std::string> faults_{};
  std::string fault_{};
};

}  // namespace sft::tool
