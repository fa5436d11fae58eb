// The routes of the bridges of one domain, which ensure that each sample is carried into the domain only
// once.
//
// A publisher that was not made by a bridge is an origin. A bridge that carries its samples to another
// domain announces a route: the origin, the topic in that domain, and the number of bridges that the
// samples have passed when they arrive there. Each bridge announces its routes on the topic "sft_bridges"
// of the domain into which it carries samples. In each domain, it also announces the DDS writers that it
// has discovered in this domain, whose samples have passed no bridge. Of all routes with the same origin
// and topic, the route with the fewest bridges is used. If several have the same number of bridges, the
// route of the bridge that was started first is used. The other bridges wait. So samples are not repeated
// by rings of bridges, or by several bridges between the same domains. When the route in use is gone, the
// next one is used.
#pragma once

#include <sft/sft.h>
#include <chrono>
#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace sft::tool {

/// The names of the nodes of all bridges begin with this text.
inline constexpr const char* bridge_node_prefix = "sft_bridge_";
/// The topic on which bridges announce their routes.
inline constexpr const char* bridge_topic = "sft_bridges";

class BridgeRoutes {
 public:
  using Time = std::chrono::steady_clock::time_point;
  struct Route {
    std::uint64_t origin = 0;
    /// The number of bridges that the samples have passed; 0: the origin is in this domain
    std::uint32_t bridges = 0;
    std::string topic{};          ///< the name of the topic in this domain
    std::uint64_t publisher = 0;  ///< the id of the bridge's publisher; 0: the route is not in use yet
    auto operator<=>(const Route&) const = default;
  };
  /// The origin of the samples of a publisher, and the number of bridges that they have passed.
  struct Source {
    std::uint64_t origin = 0;
    std::uint32_t bridges = 0;
  };
  enum class Verdict : std::uint8_t { holds, settles, belongs_there, held_by_another };

  /// `bridge` is the number of this bridge, which is the time at which it was started.
  static Result<BridgeRoutes> open(Node& node, std::uint64_t bridge);

  /// Receives the routes of other bridges, and removes bridges that are gone. The routes are limited in
  /// number, and those of a bridge are used only while its publisher is in `domain`.
  void look(const DomainSnapshot& domain, Time now);
  /// Returns the origin of a publisher's samples. Returns nothing if the publisher belongs to a bridge that
  /// has not announced its route yet.
  std::optional<Source> source_of(const DomainSnapshot::Endpoint& publisher) const;
  /// Returns whether this bridge may carry samples of `source` to the topic in this domain.
  Verdict verdict(const Source& source, const std::string& topic, Time now) const;
  /// Announces the routes of this bridge if they have changed, and from time to time if they have not:
  /// another sender may have forged an announcement in the name of this bridge.
  void announce(std::vector<Route> routes, Time now);

 private:
  struct Other {
    std::uint64_t bridge = 0;
    /// The id of the node of its publisher; 0: the publisher has not been discovered yet
    std::uint64_t node = 0;
    std::vector<Route> routes{};
    Time heard{};
    Time seen{};  ///< the last time at which its publisher was in the domain
    /// true if its publisher is in the domain; false: its routes are kept for the case that the publisher
    /// returns, such as after an outage
    bool is_there = false;
  };
  BridgeRoutes(std::uint64_t bridge, DynamicPublisher publisher, DynamicSubscriber subscriber)
      : bridge_(bridge),
        publisher_(std::move(publisher)),
        subscriber_(std::move(subscriber)),
        own_id_(publisher_.status().id) {}
  Result<void> publish(const std::vector<Route>& routes);
  void hear(Time now);
  void forget(Time now);
  bool is_settled(const Source& source, const std::string& topic, Time now) const;

  std::uint64_t bridge_;
  DynamicPublisher publisher_;
  DynamicSubscriber subscriber_;
  std::uint64_t own_id_;  ///< the id of `publisher_`, whose samples the subscriber also receives
  std::map<std::uint64_t, Other> others_{};  ///< bridges by the id of their publisher
  /// bridges without routes so far: when their publishers were discovered
  std::map<std::uint64_t, Time> unheard_{};
  std::set<std::uint64_t> publishers_{};  ///< the ids of all publishers of the domain
  std::vector<Route> announced_{};        ///< the routes that this bridge has announced, sorted
  Time announced_again_at_{};             ///< the time at which they are announced again
  /// when each route was first announced, by origin and topic
  std::map<std::pair<std::uint64_t, std::string>, Time> since_{};
  Time opened_ = std::chrono::steady_clock::now();
};

}  // namespace sft::tool
