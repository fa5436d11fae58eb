// Merges what is heard on all links: duplicates are dropped, an endpoint lives while any link has it alive,
// and the ids of endpoints, readers and nodes are bound to the participants that announced them first. Pure:
// (event, now) goes in, news come out. discovery.md has the rules.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/claim_counts.h"
#include "core/discovery/claimed_endpoints.h"
#include "core/discovery/discovery_news.h"
#include "core/discovery/endpoint_claims.h"
#include "core/discovery/node_claims.h"
#include "core/discovery/requests_in_advance.h"
#include "core/discovery/speakers.h"
#include "core/platform/clock.h"

namespace sft::core {

class LinkMerge {
 public:
  struct Limits {
    std::size_t share = 1024;    ///< announcements that each participant may have in any case
    std::size_t crowded = 8192;  ///< from so many announcements on a participant gets its share and no more
    std::size_t endpoints = 32'768;
    std::size_t early_requests = 1024;
    std::chrono::seconds forget_after{60};
  };

  LinkMerge() : LinkMerge(Limits{}) {}
  explicit LinkMerge(const Limits& limits)
      : limits_(limits),
        nodes_(speakers_, limits.endpoints),
        counts_({.share = limits.share, .crowded = limits.crowded, .all = limits.endpoints}),
        early_requests_(limits.early_requests) {}
  LinkMerge(const LinkMerge&) = delete;
  LinkMerge& operator=(const LinkMerge&) = delete;

  /// Claims of others about these ids are passed on unchanged: the node answers them.
  void owns(EndpointId id) { own_.insert(id); }
  /// The endpoint is withdrawn: who repeats what was said of it is not believed.
  void disowns(EndpointId id, std::uint64_t revision, Time now) {
    own_.erase(id);
    departed_[id] = {revision, now};
  }

  void endpoint_came(const Speaker& speaker, Endpoint endpoint, Time now);
  void endpoint_withdrawn(const Speaker& speaker, EndpointId id, Time now);
  /// Nobody on that link keeps the endpoint alive any more.
  void endpoint_unheard(LinkId link, EndpointId id, Time now);
  void request_came(const Speaker& speaker, Request request, Time now);
  void assertion_came(const Speaker& speaker, Assertion assertion, Time now);
  /// The speaker has said by a pulse that this node lives; none if the pulse does not count.
  void pulse_came(const Speaker& speaker, std::optional<NodeId> living, Time now);
  /// That node has gone on to live until then, as pulses of the speaker have said. Nobody needs to be told.
  void pulses_came_until(const Speaker& speaker, NodeId node, Time last);
  /// All pulses that had come until then have been told.
  void pulses_heard(Time now) { speakers_.pulses_heard(now); }
  void node_unheard(LinkId link, NodeId id, Time now);
  void participant_departed(const Speaker& speaker, Time now);
  void link_dropped(LinkId link, Time now);
  /// The same for a link that was made anew: what another link says of the same participants counts, although
  /// what came by the dropped link may be newer. That may have been somebody else's word.
  void replaced_link_dropped(LinkId link, Time now);
  void tick(Time now);
  /// All that these nodes announce is known. What was lost of them has departed: its withdrawal was not
  /// heard.
  void end_what_was_lost_of(const std::set<NodeId>& nodes_known_whole);
  /// The time until tick() is worth its cost again, which grows with the number of endpoints.
  std::chrono::milliseconds pause_between_ticks() const;

  struct Unrest {
    /// More than one speaker is heard for some endpoint or node: their silence decides between them.
    bool has_rivals = false;
    /// Time alone may change something, although all go on to say that they live.
    bool is_any = false;
    std::size_t living = 0;  ///< nodes
  };
  Unrest unrest() const;
  /// The digests (control_digest.h) of all that is known here of each speaker's announcements.
  std::map<Speaker, std::uint32_t> digests() const;
  /// The claims of that speaker are not what its node says. They do not count any more once another speaker
  /// of the node, or the same one on another link, is heard. And endpoints that were withdrawn may be there.
  void begin_anew(const Speaker& speaker);
  /// The same if all that the node says is known already from another speaker: that counts from now on.
  void disbelieve(const Speaker& speaker, Time now);
  /// Withdrawals may have been somebody else's: what was withdrawn may be there after all.
  void doubt_departures() { departed_.clear(); }

  const ClaimedEndpoints& endpoints() const { return endpoints_; }
  /// Returns the news in the order in which they happened.
  std::vector<News> take_news() { return std::exchange(news_, {}); }

 private:
  struct Departed {
    std::uint64_t revision;
    Time at;
  };
  std::chrono::milliseconds lease_of(NodeId node) const;
  void tell_lost_nodes(Time now);
  void refuse_old_requests(Time now);
  void forget_old(Time now);
  const Limits limits_;
  Speakers speakers_;
  NodeClaims nodes_;
  ClaimCounts counts_;
  std::vector<News> news_;
  const ClaimContext context_{speakers_, nodes_, counts_, news_};
  std::set<EndpointId> own_;
  std::set<Speaker> disbelieved_;  ///< on links that go soon
  ClaimedEndpoints endpoints_{context_};
  std::map<EndpointId, Departed> departed_;
  Time forgets_at_{};
  RequestsInAdvance early_requests_;
};

}  // namespace sft::core
