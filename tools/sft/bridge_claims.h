// What the bridges of one domain say to each other, so that each sample comes there once.
//
// A publisher that no bridge made is an origin. A bridge that takes its samples to another domain claims
// (origin, topic there), with the number of bridges that the samples have passed by then. Each bridge tells
// its claims on the topic "sft_bridges" of the domain that the samples are taken to. It also tells there
// which DDS writers it hears in that domain: their samples have passed no bridge. Of all claims to the same
// origin and topic the one with the fewest bridges holds, and of equal ones that of the bridge that was
// started first. The bridges whose claims do not hold wait. So neither rings of bridges nor bridges side by
// side multiply samples. When the claim that holds is gone, the next one holds.
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

/// The beginning of the names of nodes of bridges.
inline constexpr const char* bridge_node_prefix = "sft_bridge_";
/// The topic of the claims.
inline constexpr const char* bridge_topic = "sft_bridges";

class BridgeClaims {
 public:
  using Time = std::chrono::steady_clock::time_point;
  struct Claim {
    std::uint64_t origin = 0;
    std::uint32_t bridges = 0;    ///< that the samples have passed; 0: the origin is in this domain
    std::string topic{};          ///< in this domain
    std::uint64_t publisher = 0;  ///< the bridge's publisher; 0: none, the claim does not hold yet
    auto operator<=>(const Claim&) const = default;
  };
  /// Where the samples of a publisher come from.
  struct Source {
    std::uint64_t origin = 0;
    std::uint32_t bridges = 0;
  };
  enum class Verdict : std::uint8_t { holds, settles, belongs_there, held_by_another };

  /// `bridge` is the number of this bridge, the time at which it was started.
  static Result<BridgeClaims> open(Node& node, std::uint64_t bridge);

  /// Takes what other bridges have told, and forgets bridges that are gone.
  void look(const DomainSnapshot& domain, Time now);
  /// Returns nothing for the publisher of a bridge that has not told its origin yet.
  std::optional<Source> source_of(const DomainSnapshot::Endpoint& publisher) const;
  /// Decides whether samples may be carried here.
  Verdict verdict(const Source& source, const std::string& topic, Time now) const;
  /// Tells the claims of this bridge, if they have changed.
  void tell(std::vector<Claim> claims, Time now);

 private:
  struct Other {
    std::uint64_t bridge = 0;
    std::vector<Claim> claims{};
    Time heard{};
    Time seen{};            ///< when its publisher was last there
    bool is_there = false;  ///< false: its claims hold again when it comes back, as after an outage
  };
  BridgeClaims(std::uint64_t bridge, DynamicPublisher publisher, DynamicSubscriber subscriber)
      : bridge_(bridge), publisher_(std::move(publisher)), subscriber_(std::move(subscriber)) {}
  bool is_settled(const Source& source, const std::string& topic, Time now) const;

  std::uint64_t bridge_;
  DynamicPublisher publisher_;
  DynamicSubscriber subscriber_;
  std::map<std::uint64_t, Other> others_{};                        ///< by the id of their publisher
  std::map<std::uint64_t, Time> unheard_{};                        ///< and since when they are known
  std::set<std::uint64_t> publishers_{};                           ///< all of the domain
  std::vector<Claim> told_{};                                      ///< what this bridge has told, sorted
  std::map<std::pair<std::uint64_t, std::string>, Time> since_{};  ///< for how long a claim is told
  Time opened_ = std::chrono::steady_clock::now();
};

}  // namespace sft::tool
